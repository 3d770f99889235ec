//! Samples of one block as they are kept: whole numbers of ticks, robot by robot.

use crate::header::Fields;
use crate::raw::Raw;
use crate::units::{SENSORS, TICKS_PER_COMMAND, TICKS_PER_M, TICKS_PER_RAD};

/// Samples of a block. What belongs to a robot lies together, in the order of time; a column that is
/// not recorded is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Samples {
    /// Number of the first sample.
    pub first: u64,
    /// Samples.
    pub count: usize,
    /// Robots of a sample.
    pub rows: usize,
    /// Objects of a sample.
    pub objects: usize,
    /// x, y and heading in ticks.
    pub pose: [Vec<i32>; 3],
    /// Wheel speeds at the first sample, 1/1000 rad/s, left and right; empty in short blocks.
    pub wheels: Vec<[i32; 2]>,
    /// Commands in ticks, left and right.
    pub command: [Vec<i16>; 2],
    /// State and action, each one more than its number, 0 for none.
    pub decision: [Vec<u16>; 2],
    /// Sensor values, of each robot one sensor after the other.
    pub sensors: Vec<u16>,
    /// As for robots.
    pub object_pose: [Vec<i32>; 3],
}

/// What a robot had decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The state that it was in; `None` where its learner has none.
    pub state: Option<u16>,
    /// The action that it had chosen.
    pub action: Option<u16>,
}

/// Samples from which on a block keeps wheel speeds.
pub(crate) const KEEPS_WHEELS: usize = 16;

fn ticks(value: f32, per_unit: f64) -> i32 {
    // A cast saturates, and takes what is no number for 0.
    (f64::from(value) * per_unit + 0.5).floor() as i32
}

/// Farthest from 0 that a heading is kept: a tick more would be beyond half a turn, and be taken for
/// one on the other side.
const FARTHEST: i32 = 3_141;

fn heading(cos: f32, sin: f32) -> i32 {
    ticks(libm::atan2f(sin, cos), TICKS_PER_RAD).clamp(-FARTHEST, FARTHEST)
}

fn pose([x, y, cos, sin]: [f32; 4]) -> [i32; 3] {
    [
        ticks(x, TICKS_PER_M),
        ticks(y, TICKS_PER_M),
        heading(cos, sin),
    ]
}

/// From moment by moment to row by row.
fn by_row<T: Copy, U>(all: &[T], rows: usize, of: impl Fn(T) -> U) -> Vec<U> {
    let mut turned = Vec::with_capacity(all.len());
    for row in 0..rows {
        turned.extend(all[row..].iter().step_by(rows).map(|value| of(*value)));
    }
    turned
}

fn poses(all: &[[f32; 4]], rows: usize) -> [Vec<i32>; 3] {
    let mut turned = [(); 3].map(|()| Vec::with_capacity(all.len()));
    for row in 0..rows.min(all.len()) {
        for value in all[row..].iter().step_by(rows) {
            for (column, ticks) in turned.iter_mut().zip(pose(*value)) {
                column.push(ticks);
            }
        }
    }
    turned
}

impl Samples {
    /// Of samples as they were taken, in blocks of at most so many.
    pub fn of(raw: &Raw, longest_block: usize) -> Self {
        let rows = raw.rows;
        let pick = |of: fn([f32; 2]) -> f32| {
            by_row(&raw.commands, rows.min(raw.commands.len()), |c| {
                ticks(of(c), TICKS_PER_COMMAND) as i16
            })
        };
        let decided =
            |which: usize| by_row(&raw.decisions, rows.min(raw.decisions.len()), |d| d[which]);
        let mut sensors = Vec::with_capacity(raw.sensors.len() * SENSORS);
        for row in 0..rows.min(raw.sensors.len()) {
            for sensor in 0..SENSORS {
                let of_row = raw.sensors[row..].iter().step_by(rows);
                sensors.extend(of_row.map(|values| ticks(values[sensor], 1.0) as u16));
            }
        }
        let wheels = raw.wheels_rad_s.iter();
        Self {
            first: raw.first,
            count: raw.count,
            rows,
            objects: raw.objects,
            pose: poses(&raw.poses, rows),
            wheels: match longest_block < KEEPS_WHEELS {
                true => Vec::new(),
                false => wheels
                    .map(|both| both.map(|speed| ticks(speed, 1_000.0)))
                    .collect(),
            },
            command: [pick(|c| c[0]), pick(|c| c[1])],
            decision: [decided(0), decided(1)],
            sensors,
            object_pose: poses(&raw.object_poses, raw.objects),
        }
    }

    /// As they could have been taken: gives the same again when it is turned back.
    pub fn to_raw(&self, fields: Fields, room: usize) -> Raw {
        let mut raw = Raw::with_room(fields, room.max(self.count), self.rows, self.objects);
        raw.begin(self.first);
        raw.count = self.count;
        let wheels = self.wheels.iter();
        raw.wheels_rad_s
            .extend(wheels.map(|both| both.map(|ticks| (f64::from(ticks) / 1_000.0) as f32)));
        for sample in 0..self.count {
            for row in 0..self.rows {
                let at = self.at(row, sample);
                if fields.pose {
                    raw.poses.push(as_taken(&self.pose, at));
                }
                if fields.command {
                    raw.commands.push([0, 1].map(|wheel| {
                        (f64::from(self.command[wheel][at]) / TICKS_PER_COMMAND) as f32
                    }));
                }
                if fields.decision {
                    raw.decisions
                        .push([self.decision[0][at], self.decision[1][at]]);
                }
                if fields.sensors {
                    let values = self.sensors(row, sample);
                    raw.sensors.push(values.map(f32::from));
                }
            }
            for object in 0..self.objects {
                let at = object * self.count + sample;
                raw.object_poses.push(as_taken(&self.object_pose, at));
            }
        }
        raw
    }

    fn at(&self, row: usize, sample: usize) -> usize {
        row * self.count + sample
    }

    /// Where a robot was: x and y in metres, heading in radians.
    pub fn pose(&self, row: usize, sample: usize) -> [f64; 3] {
        in_units(&self.pose, self.at(row, sample))
    }

    /// Where an object was.
    pub fn object_pose(&self, object: usize, sample: usize) -> [f64; 3] {
        in_units(&self.object_pose, self.at(object, sample))
    }

    /// The command that a robot was given last, left and right.
    pub fn command(&self, row: usize, sample: usize) -> [f64; 2] {
        let at = self.at(row, sample);
        [0, 1].map(|wheel| f64::from(self.command[wheel][at]) / TICKS_PER_COMMAND)
    }

    /// What a robot's sensors read.
    pub fn sensors(&self, row: usize, sample: usize) -> [u16; SENSORS] {
        std::array::from_fn(|sensor| self.sensors[(row * SENSORS + sensor) * self.count + sample])
    }

    /// What a robot had decided.
    pub fn decision(&self, row: usize, sample: usize) -> Decision {
        let at = self.at(row, sample);
        Decision {
            state: self.decision[0][at].checked_sub(1),
            action: self.decision[1][at].checked_sub(1),
        }
    }
}

fn as_taken(pose: &[Vec<i32>; 3], at: usize) -> [f32; 4] {
    let [x_m, y_m, heading_rad] = in_units(pose, at);
    [
        x_m as f32,
        y_m as f32,
        libm::cos(heading_rad) as f32,
        libm::sin(heading_rad) as f32,
    ]
}

fn in_units(pose: &[Vec<i32>; 3], at: usize) -> [f64; 3] {
    [
        f64::from(pose[0][at]) / TICKS_PER_M,
        f64::from(pose[1][at]) / TICKS_PER_M,
        f64::from(pose[2][at]) / TICKS_PER_RAD,
    ]
}
