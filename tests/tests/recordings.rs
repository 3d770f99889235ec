//! A recording is the same to the last byte whether the run recorded itself, was killed on the way,
//! or was recorded afterwards; and it is read as its file, in slices and as tables.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;

use api::recording::{RecordingList, RecordingSlice, RecordingState, RecordingSummary};
use serde_json::{Value, json};
use tests::command;
use tests::server::Server;
use tests::wait;

/// Learners that share, and boxes that are pushed: both engines.
fn specs() -> [Value; 2] {
    let boxes = json!({
        "name": "boxes", "width_m": 1.0, "height_m": 1.0, "walls_m": [],
        "starts": [{ "x_m": 0.2, "y_m": 0.5, "heading_rad": 0.0 },
                   { "x_m": 0.2, "y_m": 0.3, "heading_rad": 0.0 }],
        "objects": [{ "kind": "box", "x_m": 0.3, "y_m": 0.5, "heading_rad": 0.1,
                      "width_m": 0.08, "height_m": 0.08, "mass_kg": 0.05, "friction": 0.3 }],
    });
    [
        json!({
            "arena": "easy", "robots": 3, "placement": "grid", "sharing": { "mode": "arena" },
            "controller": { "method": "ev-iter-c", "train": { "arena": "easy", "epochs": 20 } },
            "epochs": 1_500, "steps_per_epoch": 1_000,
        }),
        json!({
            "arena": boxes, "engine": "rapier", "robots": 2,
            "controller": { "method": "brownian" }, "epochs": 100, "steps_per_epoch": 1_000,
        }),
    ]
}

fn with(mut spec: Value, field: &str, value: Value) -> Value {
    spec[field] = value;
    spec
}

fn one_run(spec: &Value) -> Value {
    json!({ "base": spec, "seeds": { "first": 1, "count": 1 } })
}

/// The recording that `evswarm run` leaves.
fn by_command(spec: &Value) -> Vec<u8> {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let done = command::run(&with(spec.clone(), "seed", json!(1)), &out, "1");
    assert_eq!(done.code, Some(0), "{done:?}");
    fs::read(out.join("recording.evrec")).unwrap()
}

fn wait_for_recording(server: &Server, path: &str) -> RecordingSummary {
    wait::until("the recording", || {
        let list: RecordingList = server.read(path);
        let last = list.items.into_iter().next_back()?;
        let ended = matches!(last.state, RecordingState::Done | RecordingState::Cut);
        ended.then_some(last)
    })
}

#[test]
fn live_afterwards_and_after_a_crash_are_the_same_bytes() {
    let record = json!({ "every_steps": 25 });
    for spec in specs() {
        let recorded = with(spec.clone(), "record", record.clone());
        let reference = by_command(&recorded);
        let home = tempfile::tempdir().unwrap();
        let kept = ["--threads", "2", "--keep-checkpoints-every", "40"];
        let server = Server::start_with(home.path(), &kept);
        let job = server.submit(&one_run(&recorded));
        let id = server.only_run(&job).id;
        let live = format!("/v1/runs/{id}/recording");
        let wait_for = |server: &Server, share: f64| {
            wait::until("some of the run", || {
                let run = server.only_run(&job);
                let done = run.progress.map_or(0.0, |progress| progress.fraction);
                (done > share || run.state == api::State::Done).then_some(())
            });
        };
        // Ended with a checkpoint, then killed with more in the file than the checkpoint knows of.
        wait_for(&server, 0.2);
        server.terminate();
        let server = Server::start_with(home.path(), &kept);
        wait_for(&server, 0.5);
        server.kill();
        let server = Server::start_with(home.path(), &kept);
        server.wait_for(&job);
        let answer = server.get(&live);
        assert!(answer.body == reference, "killed and gone on");

        // The same run, which does not record itself: recorded afterwards, whole.
        let plain = server.submit(&one_run(&spec));
        server.wait_for(&plain);
        let id = server.only_run(&plain).id;
        let path = format!("/v1/runs/{id}/recordings");
        server
            .get(&format!("/v1/runs/{id}/recording"))
            .refused("a recording that is not there");
        let asked = server.post(&path, &record);
        assert_eq!(asked.status, 201, "{}", asked.text());
        let location = asked.header("location").to_owned();
        assert_eq!(
            server.post(&path, &record).status,
            200,
            "it was asked for before"
        );
        let made = wait_for_recording(&server, &path);
        assert_eq!(made.state, RecordingState::Done, "{made:?}");
        let afterwards = server.get(&location);
        assert!(afterwards.body == reference, "recorded afterwards");

        // A stretch, from a checkpoint that was kept: what it shows is what the whole shows.
        let asked = server.post(&path, &with(record.clone(), "from_epoch", json!(90)));
        assert_eq!(asked.status, 201, "{}", asked.text());
        let stretch = asked.header("location").to_owned();
        wait_for_recording(&server, &path);
        let slice = |of: &str| -> RecordingSlice {
            let from = 90 * 1_000 + 300;
            server.read(&format!("{of}.json?from_step={from}&steps=900&every=50"))
        };
        let (part, whole) = (slice(&stretch), slice(&location));
        assert_eq!(part.robots, whole.robots);
        assert_eq!(part.objects, whole.objects);
        assert_eq!(part.step, whole.step);
        assert_eq!(part.step.len(), 19);
        assert_eq!(server.send("DELETE", &stretch, &[], b"").status, 204);
        server
            .get(&stretch)
            .refused("a recording that is not there");
        // A part of the file, as the page fetches it.
        let range = server.send("GET", &location, &[("range", "bytes=100-199")], b"");
        assert_eq!((range.status, &range.body[..]), (206, &reference[100..200]));
    }
}

#[test]
fn a_recording_that_is_asked_for_survives_a_crash_and_goes_with_its_run() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let job = server.submit(&one_run(&with(specs()[0].clone(), "epochs", json!(200))));
    server.wait_for(&job);
    let id = server.only_run(&job).id;
    let path = format!("/v1/runs/{id}/recordings");
    let asked = server.post(
        &path,
        &json!({ "every_steps": 1, "robots": [2], "epochs": 100 }),
    );
    assert_eq!(asked.status, 201, "{}", asked.text());
    let location = asked.header("location").to_owned();
    server.kill();
    let server = Server::start(home.path());
    let made = wait_for_recording(&server, &path);
    assert_eq!((made.state, made.epochs), (RecordingState::Done, 100));
    let slice: RecordingSlice = server.read(&format!("{location}.json?steps=3"));
    assert_eq!(slice.step, [0, 1, 2]);
    assert_eq!(slice.robots[0].robot, 2);
    let wrong = [
        (json!({ "from_epoch": 2_000 }), "/from_epoch"),
        (json!({ "robots": [3] }), "/robots/0"),
        (json!({ "every_steps": 0 }), "/every_steps"),
        (json!({ "every_step": 1 }), "/every_step"),
    ];
    for (document, pointer) in wrong {
        let problem = server.post(&path, &document).problem(422);
        assert_eq!(problem.errors[0].pointer, pointer, "{problem:?}");
    }
    assert_eq!(
        server
            .send("DELETE", &format!("/v1/runs/{id}"), &[], b"")
            .status,
        204
    );
    let folder = home.path().join(format!("data/recordings/{id}"));
    wait::until("the folder to go", || (!folder.exists()).then_some(()));
}

#[test]
fn tables_hold_what_slices_show() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut spec = tests::small_spec();
    spec["robots"] = json!(2);
    spec["placement"] = json!("grid");
    spec["record"] = json!({ "every_steps": 50, "fields": ["pose", "command"] });
    let job = server.submit(&tests::job(spec, 1));
    server.wait_for(&job);
    let id = server.only_run(&job).id;
    let path = format!("/v1/runs/{id}/recording");
    let slice: RecordingSlice = server.read(&format!("{path}.json?robots=1"));
    // Three epochs, each with its beginning and four moments more.
    assert_eq!(slice.step[..6], [0, 50, 100, 150, 200, 200]);
    assert_eq!(slice.epoch_step[..6], [0, 50, 100, 150, 200, 0]);
    assert_eq!(slice.step.len(), 15);
    assert_eq!(slice.recording.state, RecordingState::Done);
    let csv = server.get(&format!("{path}.csv"));
    let mut lines = csv.text().lines();
    assert_eq!(
        lines.next().unwrap(),
        "step,time_s,epoch,epoch_step,phase,in_training,robot,x_m,y_m,heading_rad,left,right"
    );
    let of_robot = lines.filter(|line| line.split(',').nth(6) == Some("1"));
    let x_m: Vec<f64> = of_robot
        .map(|line| line.split(',').nth(7).unwrap().parse().unwrap())
        .collect();
    assert_eq!(x_m, slice.robots[0].poses.x_m);
    assert_eq!(server.get(&format!("{path}.parquet")).body[..4], *b"PAR1");
    let wrong = server.get(&format!("{path}.json?robots=7")).problem(400);
    assert_eq!(wrong.code, "invalid-query");
}
