//! A recording as MCAP, which Foxglove and other players open: poses, what robots sense and do, and
//! the arena with everything in it as a scene. Schemas are inside.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer};
use recording::{Header, Reader, SamplePlace, Samples};
use serde_json::{Value, json};

use super::rows::failed;
use super::slice::{epoch_of, step_of};

/// Frame that all poses are in.
const FRAME: &str = "arena";
/// Height of what is drawn, metres.
const HEIGHT_M: f64 = 0.05;
/// Robots that are drawn in the scene; more have their poses alone.
const MOST_DRAWN: usize = 200;

/// The kinds of messages, with the JSON Schema of each.
#[derive(Clone, Copy)]
enum Kind {
    Pose,
    Scene,
    Signals,
    Progress,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::Pose => "foxglove.PoseInFrame",
            Kind::Scene => "foxglove.SceneUpdate",
            Kind::Signals => "evswarm.Signals",
            Kind::Progress => "evswarm.Progress",
        }
    }

    fn schema(self) -> Value {
        let number = json!({ "type": "number" });
        let whole = json!({ "type": "integer" });
        let time = json!({ "type": "object", "title": "time",
            "properties": { "sec": whole, "nsec": whole } });
        let xyz = json!({ "type": "object",
            "properties": { "x": number, "y": number, "z": number } });
        let quaternion = json!({ "type": "object",
            "properties": { "x": number, "y": number, "z": number, "w": number } });
        let pose = json!({ "type": "object",
            "properties": { "position": xyz, "orientation": quaternion } });
        let color = json!({ "type": "object",
            "properties": { "r": number, "g": number, "b": number, "a": number } });
        let some = |properties: Value| json!({ "type": "array", "items": { "type": "object", "properties": properties } });
        let properties = match self {
            Kind::Pose => {
                json!({ "timestamp": time, "frame_id": { "type": "string" }, "pose": pose })
            }
            Kind::Scene => {
                let solid = json!({ "pose": pose, "size": xyz, "color": color });
                let line = json!({ "type": whole, "pose": pose, "thickness": number,
                    "scale_invariant": { "type": "boolean" },
                    "points": { "type": "array", "items": xyz }, "color": color });
                let entity = json!({ "timestamp": time, "frame_id": { "type": "string" },
                    "id": { "type": "string" }, "lifetime": time,
                    "frame_locked": { "type": "boolean" }, "lines": some(line),
                    "cubes": some(solid.clone()), "cylinders": some(solid) });
                let deletion = json!({ "timestamp": time, "type": whole,
                    "id": { "type": "string" } });
                json!({ "deletions": some(deletion), "entities": some(entity) })
            }
            Kind::Signals => json!({ "left": number, "right": number, "state": whole,
                "action": whole,
                "sensors": { "type": "array", "items": number } }),
            Kind::Progress => json!({ "step": whole, "epoch": whole, "epoch_step": whole,
                "phase": { "type": "string" }, "phase_epoch": whole,
                "in_training": { "type": "boolean" } }),
        };
        json!({ "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": self.name(), "type": "object", "properties": properties })
    }
}

/// A file that is being written.
struct File<W: Write> {
    writer: Writer<NoSeek<W>>,
    schemas: BTreeMap<&'static str, u16>,
    sequence: u32,
}

impl<W: Write> File<W> {
    fn channel(&mut self, topic: &str, kind: Kind) -> io::Result<u16> {
        let schema = match self.schemas.get(kind.name()) {
            Some(schema) => *schema,
            None => {
                let text = kind.schema().to_string();
                let added = self
                    .writer
                    .add_schema(kind.name(), "jsonschema", text.as_bytes());
                let schema = added.map_err(io::Error::other)?;
                self.schemas.insert(kind.name(), schema);
                schema
            }
        };
        self.writer
            .add_channel(schema, topic, "json", &BTreeMap::new())
            .map_err(io::Error::other)
    }

    fn put(&mut self, channel_id: u16, time_ns: u64, message: &Value) -> io::Result<()> {
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let bytes = serde_json::to_vec(message)?;
        let written = self.writer.write_to_known_channel(&header, &bytes);
        written.map_err(sent)
    }
}

/// An error of whoever takes the bytes is told as it is.
fn sent(error: mcap::McapError) -> io::Error {
    match error {
        mcap::McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}

fn time(time_ns: u64) -> Value {
    json!({ "sec": time_ns / 1_000_000_000, "nsec": time_ns % 1_000_000_000 })
}

fn pose([x_m, y_m, heading_rad]: [f64; 3], z_m: f64) -> Value {
    let half = heading_rad / 2.0;
    json!({
        "position": { "x": x_m, "y": y_m, "z": z_m },
        "orientation": { "x": 0.0, "y": 0.0, "z": libm::sin(half), "w": libm::cos(half) },
    })
}

fn color([r, g, b]: [f64; 3]) -> Value {
    json!({ "r": r, "g": g, "b": b, "a": 1.0 })
}

fn entity(id: &str, time_ns: u64) -> Value {
    json!({ "id": id, "timestamp": time(time_ns), "frame_id": FRAME,
        "lifetime": { "sec": 0, "nsec": 0 }, "frame_locked": false, "metadata": [],
        "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "lines": [],
        "triangles": [], "texts": [], "models": [] })
}

/// The walls of an arena, its outer ones included.
fn walls(arena: &Value, time_ns: u64) -> Value {
    let side = |name: &str| arena[name].as_f64().unwrap_or(0.0);
    let (width_m, height_m) = (side("width_m"), side("height_m"));
    let corners = [
        [0.0, 0.0],
        [width_m, 0.0],
        [width_m, height_m],
        [0.0, height_m],
    ];
    let outer = (0..4).map(|at| [corners[at], corners[(at + 1) % 4]]);
    let inner = arena["walls_m"].as_array().into_iter().flatten();
    let inner = inner.map(|wall| {
        let at = |place: usize| wall[place].as_f64().unwrap_or(0.0);
        [[at(0), at(1)], [at(2), at(3)]]
    });
    let points: Vec<Value> = outer
        .chain(inner)
        .flatten()
        .map(|[x, y]| json!({ "x": x, "y": y, "z": 0.0 }))
        .collect();
    let mut walls = entity("walls", time_ns);
    // Type 2 is a list of lines, two points each.
    walls["lines"] = json!([{ "type": 2, "pose": pose([0.0; 3], 0.0), "thickness": 0.005,
        "scale_invariant": false, "points": points, "color": color([0.2, 0.2, 0.25]),
        "colors": [], "indices": [] }]);
    walls
}

/// Robots and objects of a moment.
fn moment(header: &Header, arena: &Value, block: &Samples, at: usize, time_ns: u64) -> Value {
    let diameter_m = 2.0 * header.body_radius_m;
    let robot = |row: usize| {
        json!({ "pose": pose(block.pose(row, at), HEIGHT_M / 2.0),
            "size": { "x": diameter_m, "y": diameter_m, "z": HEIGHT_M },
            "bottom_scale": 1.0, "top_scale": 1.0, "color": color([0.1, 0.45, 0.8]) })
    };
    let mut robots = entity("robots", time_ns);
    if header.fields.pose {
        let rows = 0..block.rows.min(MOST_DRAWN);
        robots["cylinders"] = rows.map(robot).collect();
    }
    let mut objects = entity("objects", time_ns);
    let (mut cubes, mut cylinders) = (Vec::new(), Vec::new());
    for (number, object) in arena["objects"]
        .as_array()
        .into_iter()
        .flatten()
        .enumerate()
    {
        if number >= block.objects {
            break;
        }
        let size = |name: &str| object[name].as_f64();
        let solid = |[x, y]: [f64; 2]| {
            json!({ "pose": pose(block.object_pose(number, at), HEIGHT_M / 2.0),
                "size": { "x": x, "y": y, "z": HEIGHT_M },
                "bottom_scale": 1.0, "top_scale": 1.0, "color": color([0.8, 0.5, 0.1]) })
        };
        match (size("width_m"), size("height_m"), size("radius_m")) {
            (Some(width_m), Some(height_m), _) => cubes.push(solid([width_m, height_m])),
            (_, _, Some(radius_m)) => cylinders.push(solid([2.0 * radius_m; 2])),
            _ => {}
        }
    }
    objects["cubes"] = cubes.into();
    objects["cylinders"] = cylinders.into();
    json!({ "deletions": [], "entities": [robots, objects] })
}

fn signals(header: &Header, block: &Samples, row: usize, at: usize) -> Value {
    let mut signals = json!({});
    if header.fields.command {
        let [left, right] = block.command(row, at);
        (signals["left"], signals["right"]) = (left.into(), right.into());
    }
    if header.fields.decision {
        let decision = block.decision(row, at);
        let number = |number: Option<u16>| number.map_or(-1, i64::from);
        signals["state"] = number(decision.state).into();
        signals["action"] = number(decision.action).into();
    }
    if header.fields.sensors {
        signals["sensors"] = block.sensors(row, at).to_vec().into();
    }
    signals
}

/// Channels of one robot.
struct Robot {
    pose: u16,
    signals: u16,
}

/// Writes all that there is of a recording.
///
/// # Errors
/// When it cannot be written, or the recording is damaged.
pub fn write_mcap<F: Read + Seek>(reader: &mut Reader<F>, out: impl Write) -> io::Result<()> {
    let header = reader.header().clone();
    let layout = *reader.layout();
    let options = WriteOptions::new()
        .library(concat!("evswarm ", env!("CARGO_PKG_VERSION")))
        .compression(Some(mcap::Compression::Zstd))
        .disable_seeking(true);
    let writer = options.create(NoSeek::new(out)).map_err(sent)?;
    let mut file = File {
        writer,
        schemas: BTreeMap::new(),
        sequence: 0,
    };
    let scene = file.channel("/scene", Kind::Scene)?;
    let progress = file.channel("/progress", Kind::Progress)?;
    let mut robots = Vec::with_capacity(header.robots.len());
    for number in header.robots.numbers() {
        robots.push(Robot {
            pose: file.channel(&format!("/robot/{number}/pose"), Kind::Pose)?,
            signals: file.channel(&format!("/robot/{number}/signals"), Kind::Signals)?,
        });
    }
    let samples = reader.samples();
    let mut sample = samples.start;
    let mut shown: Option<bool> = None;
    while sample < samples.end {
        let block = reader.block(sample).map_err(failed)?;
        while sample < block.first + block.count as u64 {
            let at = (sample - block.first) as usize;
            let place = layout.place(sample);
            let time_ns = time_ns(&header, place);
            let epoch = epoch_of(&header, place.arena_epoch);
            let arena = match &header.training_arena {
                Some(training) if epoch.in_training => training,
                _ => &header.arena,
            };
            if shown != Some(epoch.in_training) {
                shown = Some(epoch.in_training);
                let walls = json!({ "deletions": [], "entities": [walls(arena, time_ns)] });
                file.put(scene, time_ns, &walls)?;
            }
            file.put(scene, time_ns, &moment(&header, arena, &block, at, time_ns))?;
            let told = json!({ "step": step_of(&header, place), "epoch": place.arena_epoch,
                "epoch_step": place.step, "phase": epoch.phase,
                "phase_epoch": epoch.phase_epoch, "in_training": epoch.in_training });
            file.put(progress, time_ns, &told)?;
            for (row, robot) in robots.iter().enumerate() {
                if header.fields.pose {
                    let message = json!({ "timestamp": time(time_ns), "frame_id": FRAME,
                        "pose": pose(block.pose(row, at), 0.0) });
                    file.put(robot.pose, time_ns, &message)?;
                }
                let message = signals(&header, &block, row, at);
                file.put(robot.signals, time_ns, &message)?;
            }
            sample += 1;
        }
    }
    file.writer.finish().map(drop).map_err(sent)
}

/// Simulated time of a moment.
fn time_ns(header: &Header, place: SamplePlace) -> u64 {
    (step_of(header, place) as f64 * header.step_s * 1e9) as u64
}
