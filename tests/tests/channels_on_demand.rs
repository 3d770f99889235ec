//! Channels that are asked for over HTTP while a run is under way: open within a second, closed again,
//! and the run none the wiser, also where it waits for readers of lossless frames.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use api::State;
use api::channels::{AskedBy, ChannelDescription, EVENTS, STATES, run_service};
use api::reader::{
    CoverageReader, EventReader, FrameReader, MetricsReader, ReaderError, StatusReader,
};
use serde_json::{Value, json};
use tests::files::Findings;
use tests::http::Client;
use tests::server::Server;
use tests::{job, program, small_spec, wait};

const WAIT: Duration = Duration::from_secs(60);

fn channels(server: &Client, id: &str) -> Vec<ChannelDescription> {
    server.read(&format!("/v1/runs/{id}/channels"))
}

fn named(server: &Client, id: &str, name: &str) -> ChannelDescription {
    let channels = channels(server, id);
    channels.into_iter().find(|it| it.name == name).unwrap()
}

fn ask(server: &Client, id: &str, what: Value) -> Vec<ChannelDescription> {
    let answer = server.post(&format!("/v1/runs/{id}/channels"), &what);
    assert_eq!(answer.status, 200, "{what}");
    answer.json()
}

fn root(home: &Path) -> PathBuf {
    home.join("evswarm")
}

/// So long that no test sees its end.
fn endless() -> Value {
    let mut spec = small_spec();
    spec["epochs"] = json!(100_000);
    spec["steps_per_epoch"] = json!(2_000);
    spec
}

#[test]
fn channels_open_and_close_while_a_run_is_under_way() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let posted = server.submit(&job(endless(), 1));
    let id = server.only_run(&posted).id;
    wait::until("the run", || {
        (server.only_run(&posted).state == State::Running).then_some(())
    });
    let before: Value = server.read(&format!("/v1/runs/{id}/spec"));
    let described = channels(&server, &id);
    let names: Vec<_> = described.iter().map(|it| it.name.as_str()).collect();
    let expected = [
        "frames", "lossless", "coverage", "metrics", "events", "status",
    ];
    assert_eq!(names, expected);
    assert!(
        described
            .iter()
            .all(|it| !it.is_open && it.asked_by.is_none())
    );

    let since = Instant::now();
    let all = json!({ "frames": true, "coverage": true, "metrics": true, "status": true });
    let answered = ask(&server, &id, all);
    assert!(
        since.elapsed() < Duration::from_secs(5),
        "{:?}",
        since.elapsed()
    );
    for channel in &answered {
        let asked = channel.name != "lossless";
        assert_eq!(channel.is_open, asked, "{channel:?}");
        assert_eq!(channel.asked_by, asked.then_some(AskedBy::Request));
    }
    let root = root(home.path());
    let service = |name| run_service(&id, name);

    let frames = FrameReader::open(&root, &service("frames")).unwrap();
    assert_eq!(frames.wait(WAIT).unwrap().unwrap().payload().len(), 1);
    let coverage = CoverageReader::open(&root, &service("coverage")).unwrap();
    let first = coverage.wait(WAIT).unwrap().unwrap();
    let header = *first.user_header();
    assert_eq!(
        first.payload().len(),
        (header.columns * header.rows) as usize
    );
    let entered = first.payload().iter().filter(|it| it.entries > 0).count();
    assert_eq!(entered, header.entered as usize);
    drop(first);
    let later = coverage.wait(WAIT).unwrap().unwrap();
    assert!(later.user_header().counted_steps > header.counted_steps);
    let metrics = MetricsReader::open(&root, &service("metrics")).unwrap();
    let row = metrics.wait(WAIT).unwrap().unwrap();
    let named_values: Vec<_> = row
        .payload()
        .iter()
        .map(|it| it.name().to_owned())
        .collect();
    assert_eq!(named_values[0], "fraction_1");
    assert!(
        named_values.contains(&"distance_m".to_owned()),
        "{named_values:?}"
    );
    let events = EventReader::open(&root, &service("events")).unwrap();
    let epoch = wait::until("the end of an epoch", || {
        let event = events.wait(WAIT).unwrap().unwrap();
        let event = event.payload()[0];
        (EVENTS[event.kind as usize] == "epoch").then_some(event.value)
    });
    assert!(epoch > 0);
    let status = StatusReader::open(&root, &service("status")).unwrap();
    wait::until("a status with a speed", || {
        (status.get().robot_steps_per_s > 0.0).then_some(())
    });
    assert_eq!(STATES[status.get().state as usize], "running");
    assert_eq!(status.get().robots, 1);

    let none = server.send("DELETE", &format!("/v1/runs/{id}/channels"), &[], b"");
    assert_eq!(none.status, 204);
    let since = Instant::now();
    wait::until("closed channels", || {
        channels(&server, &id)
            .iter()
            .all(|it| !it.is_open)
            .then_some(())
    });
    assert!(
        since.elapsed() < Duration::from_secs(5),
        "{:?}",
        since.elapsed()
    );
    assert!(frames.is_closed() && coverage.is_closed() && events.is_closed());
    assert!(FrameReader::open(&root, &service("objects")).is_err());
    assert_eq!(server.read::<Value>(&format!("/v1/runs/{id}/spec")), before);
    assert_eq!(server.only_run(&posted).state, State::Running);

    // Asked for once more: what was open before can be opened again.
    let answered = ask(&server, &id, json!({ "status": true }));
    assert!(
        answered.iter().any(|it| it.name == "status" && it.is_open),
        "{answered:?}"
    );
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn what_cannot_be_asked_for_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let done = server.wait_for(&server.submit(&job(small_spec(), 1)));
    let id = server.only_run(&done).id;
    let route = format!("/v1/runs/{id}/channels");
    let problem = server.post(&route, &json!({ "frames": true })).problem(409);
    assert_eq!(problem.code, "already-ended");
    let wrong = json!({ "frame": true, "lossless": { "every_steps": 0 } });
    let problem = server.post(&route, &wrong).problem(422);
    let pointers: Vec<_> = problem
        .errors
        .iter()
        .map(|it| it.pointer.as_str())
        .collect();
    assert_eq!(pointers, ["/frame", "/lossless/every_steps"]);
    let external = json!({ "arena": "easy", "controller": { "method": "external" } });
    let posted = server.submit(&job(external, 1));
    let external = named(&server, &server.only_run(&posted).id, "external");
    assert_eq!(external.asked_by, Some(AskedBy::Method));
    assert_eq!(external.pattern, "request-response");
    assert_eq!(external.bells.len(), 2);
    assert_eq!(external.answer.unwrap().type_name, "swarm.WheelCommand.v1");
}

/// A run that waits for its worker, held by another one; with lossless frames asked for.
struct Held {
    home: tempfile::TempDir,
    server: Server,
    posted: api::Job,
    id: String,
    holder: api::Job,
}

impl Held {
    fn new(lossless: Value) -> Self {
        let home = tempfile::tempdir().unwrap();
        let server = Server::start_with(home.path(), &["--threads", "1"]);
        let holder = server.submit(&job(endless(), 1));
        let posted = server.submit(&job(short(), 1));
        let id = server.only_run(&posted).id;
        ask(&server, &id, json!({ "lossless": lossless }));
        Self {
            home,
            server,
            posted,
            id,
            holder,
        }
    }

    /// Lets the run begin.
    fn begin(&self) {
        let job = self.holder.id.clone();
        let answer = self
            .server
            .send("POST", &format!("/v1/jobs/{job}/cancel"), &[], b"");
        assert_eq!(answer.status, 200);
    }

    fn reader(&self) -> FrameReader {
        let service = run_service(&self.id, "lossless");
        FrameReader::open_within(&root(self.home.path()), &service, WAIT).unwrap()
    }
}

/// A run of 3 epochs of 200 steps.
fn short() -> Value {
    let mut spec = small_spec();
    spec["controller"] = json!({ "method": "brownian" });
    spec["epochs"] = json!(3);
    spec["steps_per_epoch"] = json!(200);
    spec["robots"] = json!(4);
    spec["placement"] = json!("grid");
    spec
}

#[test]
fn no_lossless_frame_is_lost_to_a_slow_reader_and_the_run_finds_the_same() {
    let held = Held::new(json!({ "readers": 1, "timeout_ms": 60_000 }));
    held.begin();
    let reader = held.reader();
    let mut steps = Vec::new();
    while let Some(frame) = reader.wait(WAIT).unwrap() {
        assert_eq!(frame.payload().len(), 4);
        assert_eq!(frame.user_header().sequence, steps.len() as u64);
        steps.push(frame.user_header().arena_step);
        if steps.len() % 50 == 0 {
            // Several times what the buffer holds.
            std::thread::sleep(Duration::from_millis(50));
        }
    }
    assert_eq!(steps, (0..=600).collect::<Vec<_>>());
    held.server.wait_for(&held.posted);
    // Another server on this machine, with the same run and nobody who looks on.
    let other = tempfile::tempdir().unwrap();
    let alone = Server::start(other.path());
    let done = alone.wait_for(&alone.submit(&job(short(), 1)));
    assert_eq!(alone.only_run(&done).id, held.id);
    assert!(
        Findings::of_run(&alone, &held.id) == Findings::of_run(&held.server, &held.id),
        "a reader changed what a run found"
    );
}

#[test]
fn a_stopped_reader_of_lossless_frames_does_not_hold_a_run_for_ever() {
    let held = Held::new(json!({ "readers": 1, "timeout_ms": 300, "every_steps": 5 }));
    held.begin();
    let reader = held.reader();
    let first = reader.wait(WAIT).unwrap().unwrap();
    assert_eq!(first.user_header().arena_step, 0);
    held.server.wait_for(&held.posted);
    assert!(reader.is_closed());
    // What had come before is still there, without a gap.
    let mut next = 5;
    while let Some(frame) = reader.receive().unwrap() {
        assert_eq!(frame.user_header().arena_step, next);
        next += 5;
    }
    assert!((10..600).contains(&next), "{next}");
    let log = held.server.log();
    assert!(log.contains("a reader took no frame for 300 ms"), "{log}");
}

/// A recorder in a process of its own.
fn recorder(held: &Held) -> Child {
    Command::new(program("examples/record_csv"))
        .args([&held.id, "--lossless", "--delay-ms", "2", "--root"])
        .arg(root(held.home.path()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
fn a_killed_reader_of_lossless_frames_is_not_waited_for() {
    let held = Held::new(json!({ "readers": 2, "timeout_ms": 60_000 }));
    held.begin();
    let reader = held.reader();
    let mut doomed = recorder(&held);
    let mut steps = 0;
    while let Some(frame) = reader.wait(WAIT).unwrap() {
        assert_eq!(frame.user_header().arena_step, steps);
        steps += 1;
        if steps == 100 {
            doomed.kill().unwrap();
            doomed.wait().unwrap();
        }
    }
    doomed.wait().unwrap();
    assert_eq!(steps, 601, "the other reader got every frame");
    held.server.wait_for(&held.posted);
}

#[test]
fn a_run_that_waits_for_a_reader_can_be_paused() {
    let held = Held::new(json!({ "readers": 1, "timeout_ms": 60_000 }));
    held.begin();
    let _reader = held.reader();
    wait::until("the run", || {
        (held.server.only_run(&held.posted).state == State::Running).then_some(())
    });
    std::thread::sleep(Duration::from_millis(300));
    let route = format!("/v1/runs/{}/pause", held.id);
    assert_eq!(held.server.send("POST", &route, &[], b"").status, 200);
    wait::until("the pause", || {
        let lossless = named(&held.server, &held.id, "lossless");
        (!lossless.is_open).then_some(())
    });
    assert_eq!(held.server.only_run(&held.posted).state, State::Paused);
    assert_eq!(held.server.terminate().code(), Some(0));
}

#[test]
fn a_run_that_waits_for_a_reader_goes_on_when_the_channel_is_taken_back() {
    let held = Held::new(json!({ "readers": 1, "timeout_ms": 60_000 }));
    held.begin();
    let _reader_of_two = held.reader();
    ask(
        &held.server,
        &held.id,
        json!({ "lossless": { "readers": 2, "timeout_ms": 60_000 } }),
    );
    std::thread::sleep(Duration::from_millis(300));
    let route = format!("/v1/runs/{}/channels", held.id);
    assert_eq!(held.server.send("DELETE", &route, &[], b"").status, 204);
    held.server.wait_for(&held.posted);
}

#[test]
fn channels_open_again_however_often_they_were_taken_back() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let posted = server.submit(&job(endless(), 1));
    let id = server.only_run(&posted).id;
    let route = format!("/v1/runs/{id}/channels");
    for _ in 0..3 {
        ask(&server, &id, json!({ "status": true }));
        wait::until("the channel", || {
            named(&server, &id, "status").is_open.then_some(())
        });
        for _ in 0..2 {
            assert_eq!(server.send("DELETE", &route, &[], b"").status, 204);
            wait::until("its end", || {
                (!named(&server, &id, "status").is_open).then_some(())
            });
        }
    }
}

#[test]
fn a_reader_of_another_version_is_refused_with_a_sentence() {
    use api::channels::{MetricsHeader, SquareEntries};
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut spec = endless();
    spec["channels"] = json!(true);
    let posted = server.submit(&job(spec, 1));
    let id = server.only_run(&posted).id;
    wait::until("channels", || {
        named(&server, &id, "coverage").is_open.then_some(())
    });
    let service = run_service(&id, "coverage");
    let refused =
        api::reader::Reader::<SquareEntries, MetricsHeader>::open(&root(home.path()), &service);
    let Err(ReaderError::OtherVersion { .. }) = refused else {
        panic!("a reader with another header was let in");
    };
    let sentence = refused.err().unwrap().to_string();
    assert!(sentence.contains("is of another version"), "{sentence}");
    assert_eq!(server.terminate().code(), Some(0));
}

/// Two servers of one user meet in shared memory. The run is the same in both, so only one can show it.
#[test]
fn two_servers_with_the_same_run_do_not_disturb_each_other() {
    let home = tempfile::tempdir().unwrap();
    let shared = home.path().to_str().unwrap();
    let servers = ["first", "second"].map(|name| {
        let data = home.path().join(name);
        std::fs::create_dir(&data).unwrap();
        Server::try_start(&data, &["--threads", "1"], &[("XDG_RUNTIME_DIR", shared)]).unwrap()
    });
    let mut spec = endless();
    spec["channels"] = json!(true);
    let [first, second] = servers;
    let posted = first.submit(&job(spec.clone(), 1));
    let id = first.only_run(&posted).id;
    wait::until("the first server's channels", || {
        named(&first, &id, "status").is_open.then_some(())
    });
    let posted = second.submit(&job(spec, 1));
    assert_eq!(second.only_run(&posted).id, id);
    for name in ["frames", "coverage", "status"] {
        let why = wait::until("why the second has none", || {
            named(&second, &id, name).closed_because
        });
        assert!(why.contains("another process sends"), "{name}: {why}");
    }
    assert_eq!(second.only_run(&posted).state, State::Running);
    assert!(named(&first, &id, "frames").is_open);
    assert_eq!(first.terminate().code(), Some(0));
    wait::until("the second server's channels", || {
        let open = ["frames", "coverage", "metrics", "status"];
        open.iter()
            .all(|name| named(&second, &id, name).is_open)
            .then_some(())
    });
    let frames = FrameReader::open(&root(home.path()), &run_service(&id, "frames")).unwrap();
    assert!(frames.wait(WAIT).unwrap().is_some());
    assert_eq!(second.terminate().code(), Some(0));
}
