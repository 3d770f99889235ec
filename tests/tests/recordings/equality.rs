//! A recording is the same to the last byte whether the run recorded itself, was killed on the way,
//! or was recorded afterwards, from its beginning or from a checkpoint.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use api::recording::{RecordingList, RecordingState};
use recording::Reader;
use serde_json::{Value, json};
use tests::command;
use tests::server::Server;
use tests::wait;

use super::{one_run, recorded_afterwards, with};

/// What is recorded of a run, and from which epoch on in part.
struct Case {
    name: &'static str,
    spec: Value,
    record: Value,
    from_epoch: u64,
}

/// Both engines, both ways of sharing, objects that are pushed; each of several blocks.
fn cases() -> [Case; 4] {
    let boxes = json!({
        "name": "boxes", "width_m": 1.0, "height_m": 1.0, "walls_m": [],
        "starts": [{ "x_m": 0.2, "y_m": 0.5, "heading_rad": 0.0 },
                   { "x_m": 0.2, "y_m": 0.3, "heading_rad": 0.0 }],
        "objects": [{ "kind": "box", "x_m": 0.3, "y_m": 0.5, "heading_rad": 0.1,
                      "width_m": 0.08, "height_m": 0.08, "mass_kg": 0.05, "friction": 0.3 }],
    });
    let swarm = |sharing: Value, epochs: u32| {
        json!({
            "arena": "easy", "robots": 3, "placement": "grid", "sharing": sharing,
            "controller": { "method": "ev-iter-c", "train": { "arena": "easy", "epochs": 20 } },
            "epochs": epochs, "steps_per_epoch": 1_000,
        })
    };
    let pushing = |controller: Value| {
        json!({
            "arena": boxes, "engine": "rapier", "robots": 2, "controller": controller,
            "epochs": 50, "steps_per_epoch": 1_000,
        })
    };
    let learner = json!({ "method": "im", "babbling_epochs": 5 });
    [
        Case {
            name: "kinematic, shared in the arena",
            spec: swarm(json!({ "mode": "arena" }), 420),
            record: json!({ "every_steps": 10 }),
            from_epoch: 150,
        },
        Case {
            name: "kinematic, shared by radio",
            spec: swarm(json!({ "mode": "radio" }), 400),
            record: json!({ "every_steps": 10, "robots": [0, 2] }),
            from_epoch: 200,
        },
        Case {
            name: "rapier with objects",
            spec: pushing(json!({ "method": "brownian" })),
            record: json!({ "every_steps": 1, "fields": ["pose", "command"] }),
            from_epoch: 15,
        },
        Case {
            name: "rapier with objects, shared by radio, continued",
            spec: with(
                with(pushing(learner), "sharing", json!({ "mode": "radio" })),
                "episodes",
                json!("continue"),
            ),
            record: json!({ "every_steps": 2 }),
            from_epoch: 30,
        },
    ]
}

/// The recording that `evswarm run` leaves.
fn by_command(spec: &Value) -> Vec<u8> {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let done = command::run(&with(spec.clone(), "seed", json!(1)), &out, "1");
    assert_eq!(done.code, Some(0), "{done:?}");
    fs::read(out.join("recording.evrec")).unwrap()
}

/// Kills a server when a run has come so far, and starts another one. Says whether the run was not
/// done then.
fn killed(
    server: Server,
    home: &Path,
    arguments: &[&str],
    job: &api::Job,
    share: f64,
) -> (Server, bool) {
    let is_under_way = wait::until("some of the run", || {
        let runs = server.runs(job);
        let run = runs.first()?;
        let done = run.progress.as_ref().map_or(0.0, |p| p.fraction);
        let is_done = run.state == api::State::Done;
        (done > share || is_done).then_some(!is_done)
    });
    server.kill();
    (Server::start_with(home, arguments), is_under_way)
}

/// Removes the checkpoints that were kept of a run; says whether there were any.
fn without_checkpoints(home: &Path, run: &str) -> bool {
    let folder = home.join("data/recordings").join(run);
    let mut were_there = false;
    for file in fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_some_and(|end| end == "snapshot") {
            fs::remove_file(path).unwrap();
            were_there = true;
        }
    }
    were_there
}

/// Blocks that lie in the part are those of the whole, byte for byte; what else it has is the same
/// to the last number.
fn is_part_of(part: &[u8], whole: &[u8], name: &str) {
    let open = |file: &[u8]| Reader::open(Cursor::new(file.to_vec())).unwrap();
    let (mut a, mut b) = (open(part), open(whole));
    assert!(a.is_complete() && b.is_complete());
    let samples = a.samples();
    assert_eq!(samples.end, b.samples().end);
    let bytes = |reader: &Reader<Cursor<Vec<u8>>>, file: &[u8], sample: u64| {
        let (offsets, end) = reader.blocks();
        let place = reader.layout().block_of(sample);
        let next = offsets.get(place + 1).copied().unwrap_or(end);
        file[offsets[place] as usize..next as usize].to_vec()
    };
    let (mut sample, mut equal) = (samples.start, 0);
    while sample < samples.end {
        let next = a.layout().block_end(sample);
        if b.layout().block_start(sample) == sample {
            assert!(
                bytes(&a, part, sample) == bytes(&b, whole, sample),
                "{name}"
            );
            equal += 1;
        } else {
            let (of_part, of_whole) = (a.block(sample).unwrap(), b.block(sample).unwrap());
            let before = (of_part.first - of_whole.first) as usize;
            for at in 0..of_part.count {
                for row in 0..of_part.rows {
                    assert_eq!(of_part.pose(row, at), of_whole.pose(row, before + at));
                }
                for object in 0..of_part.objects {
                    let there = of_whole.object_pose(object, before + at);
                    assert_eq!(of_part.object_pose(object, at), there);
                }
            }
        }
        sample = next;
    }
    assert!(equal >= 1, "{name}: no whole block is in the part");
}

#[test]
fn live_afterwards_after_a_crash_and_in_part_are_the_same_bytes() {
    let home = tempfile::tempdir().unwrap();
    let kept = ["--threads", "2", "--keep-checkpoints-every", "20"];
    let server = Server::start_with(home.path(), &kept);
    let cases = cases();
    let recorded = |case: &Case| with(case.spec.clone(), "record", case.record.clone());
    let (mut server, references) = std::thread::scope(|threads| {
        let made = threads.spawn(|| {
            cases
                .iter()
                .map(|case| by_command(&recorded(case)))
                .collect()
        });
        // Ended with a checkpoint, then killed with more in the file than the checkpoint knows of.
        let live: Vec<_> = cases
            .iter()
            .map(|case| server.submit(&one_run(&recorded(case))))
            .collect();
        wait::until("steps", || {
            let run = server.only_run(&live[0]);
            (run.state != api::State::Queued).then_some(())
        });
        std::thread::sleep(std::time::Duration::from_millis(150));
        assert!(server.terminate().success());
        let mut server = Server::start_with(home.path(), &kept);
        let mut interrupted = false;
        for (place, share) in [(0, 0.5), (2, 0.3), (3, 0.6)] {
            let (next, hit) = killed(server, home.path(), &kept, &live[place], share);
            server = next;
            interrupted |= hit;
        }
        assert!(
            interrupted,
            "every run was done before the server was killed"
        );
        let references: Vec<Vec<u8>> = made.join().unwrap();
        for ((job, case), reference) in live.iter().zip(&cases).zip(&references) {
            server.wait_for(job);
            let run = server.only_run(job).id;
            let answer = server.get(&format!("/v1/runs/{run}/recording"));
            assert!(
                answer.body == *reference,
                "killed and gone on: {}",
                case.name
            );
        }
        (server, references)
    });

    // The same runs, which do not record themselves: recorded afterwards.
    let plain: Vec<_> = cases
        .iter()
        .map(|case| server.submit(&one_run(&case.spec)))
        .collect();
    for ((job, case), reference) in plain.iter().zip(&cases).zip(&references) {
        server.wait_for(job);
        let run = server.only_run(job).id;
        server
            .get(&format!("/v1/runs/{run}/recording"))
            .refused("a recording that is not there");
        let path = format!("/v1/runs/{run}/recordings");
        let asked = server.post(&path, &case.record);
        assert_eq!(asked.status, 201, "{}", asked.text());
        assert_eq!(
            server.post(&path, &case.record).status,
            200,
            "asked for before"
        );
        // Killed while it is made: it is made by the next server.
        wait::until("it is being made", || {
            let list: RecordingList = server.read(&path);
            let last = list.items.into_iter().next_back()?;
            (last.state != RecordingState::Queued).then_some(())
        });
        server.kill();
        server = Server::start_with(home.path(), &kept);
        let made = super::wait_for_recording(&server, &path);
        assert_eq!(made.state, RecordingState::Done, "{made:?}");
        let afterwards = server.get(asked.header("location"));
        assert!(afterwards.body == *reference, "afterwards: {}", case.name);

        // A part, from the nearest checkpoint and from the beginning.
        let part = with(case.record.clone(), "from_epoch", json!(case.from_epoch));
        let location = recorded_afterwards(&server, &run, &part);
        let near = server.get(&location).body;
        is_part_of(&near, reference, case.name);
        assert_eq!(server.send("DELETE", &location, &[], b"").status, 204);
        server
            .get(&location)
            .refused("a recording that is not there");
        assert!(without_checkpoints(home.path(), &run), "none was kept");
        let location = recorded_afterwards(&server, &run, &part);
        assert!(server.get(&location).body == near, "in part: {}", case.name);
    }
}
