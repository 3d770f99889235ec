//! A run that waits for another program, at a step boundary: it says so, answers meanwhile, is
//! paused and cancelled at once, and finds what it would have found.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use api::channels::run_service;
use api::controller::Controller;
use api::events::Event;
use api::learnt::Learning;
use api::reader::FrameReader;
use api::{Job, RunSummary, State, WaitsFor};
use serde_json::{Value, json};
use tests::files::Findings;
use tests::http::Client;
use tests::server::Server;
use tests::{job, wait};

const WAIT: Duration = Duration::from_secs(60);
/// Well below every time that the server would wait otherwise, well above what an answer takes on a
/// busy machine.
const AT_ONCE: Duration = Duration::from_secs(4);

fn root(home: &Path) -> PathBuf {
    home.join("evswarm")
}

/// A run that learns, of a second or so.
fn learner() -> Value {
    json!({
        "seed": 1, "arena": "easy", "robots": 3, "placement": "grid",
        "controller": { "method": "im" }, "epochs": 40, "steps_per_epoch": 500,
    })
}

/// What is done soon, or the test fails.
fn at_once<T>(what: &str, done: impl FnOnce() -> T) -> T {
    let since = Instant::now();
    let result = done();
    let took = since.elapsed();
    assert!(took < AT_ONCE, "{what} took {took:?}");
    result
}

fn change(server: &Client, run: &str, what: &str) {
    let answer = server.send("POST", &format!("/v1/runs/{run}/{what}"), &[], b"");
    assert_eq!(answer.status, 200, "{what}: {}", answer.text());
}

fn until_it_waits(server: &Client, job: &Job, whom: WaitsFor) -> RunSummary {
    wait::until("the wait", || {
        let run = server.only_run(job);
        (run.waits_for == Some(whom)).then_some(run)
    })
}

/// Lossless frames are asked for of a run before a worker has it: until then another run holds it.
fn begin_with_lossless(server: &Client, lossless: &Value) -> (Job, String) {
    let mut endless = learner();
    endless["epochs"] = json!(100_000);
    let holder = server.submit(&job(endless, 1));
    let posted = server.submit(&job(learner(), 1));
    let run = server.only_run(&posted).id;
    let asked = json!({ "lossless": lossless });
    let answer = server.post(&format!("/v1/runs/{run}/channels"), &asked);
    assert_eq!(answer.status, 200);
    let end = format!("/v1/jobs/{}/cancel", holder.id);
    assert_eq!(server.send("POST", &end, &[], b"").status, 200);
    (posted, run)
}

#[test]
fn a_run_that_waits_for_readers_says_so_and_answers_meanwhile() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_with(home.path(), &["--threads", "1"]);
    let lossless = json!({ "readers": 1, "timeout_ms": 60_000 });
    let (posted, run) = begin_with_lossless(&server, &lossless);
    let seen = until_it_waits(&server, &posted, WaitsFor::LosslessReaders);
    assert_eq!(seen.state, State::Running);
    assert!(seen.waited_s.is_some_and(|waited_s| waited_s >= 0.3));

    let route = format!("/v1/runs/{run}/learning");
    let learning: Learning = at_once("learning", || server.read(&route));
    assert!(learning.is_live);
    assert_eq!((learning.arena_step, learning.robots), (Some(0), 3));
    let route = format!("/v1/runs/{run}/checkpoint");
    let taken = at_once("a checkpoint", || server.send("POST", &route, &[], b""));
    assert_eq!(taken.status, 200, "{}", taken.text());
    let downloaded = at_once("its file", || server.get(&route));
    let bytes = downloaded.body.len().to_string();
    assert_eq!(downloaded.header("content-length"), bytes);
    let metrics = at_once("metrics", || server.get("/metrics"));
    let waiting = "evswarm_waiting_runs{for=\"lossless_readers\"} 1\n";
    assert!(metrics.text().contains(waiting), "{}", metrics.text());

    let mut listener = server.listen(&format!("/v1/runs/{run}/events"), None);
    let heard = listener.until(|event| matches!(event, Event::Run(_)));
    let Some(Event::Run(told)) = heard.last().map(|heard| &heard.event) else {
        panic!("{heard:?}");
    };
    assert_eq!(told.waits_for, Some(WaitsFor::LosslessReaders));
    change(&server, &run, "pause");
    let paused = at_once("the pause", || {
        wait::until("the pause", || {
            let run: RunSummary = server.read(&format!("/v1/runs/{run}"));
            (run.state == State::Paused && run.waits_for.is_none()).then_some(run)
        })
    });
    assert_eq!(paused.waited_s, None);
    listener.until(|event| matches!(event, Event::Run(run) if run.waits_for.is_none()));

    // What was asked for is kept: it waits again.
    change(&server, &run, "resume");
    until_it_waits(&server, &posted, WaitsFor::LosslessReaders);
    change(&server, &run, "cancel");
    at_once("a free worker", || {
        wait::until("a free worker", || {
            let workers: Value = server.read("/v1/workers");
            workers["items"]
                .as_array()
                .unwrap()
                .is_empty()
                .then_some(())
        })
    });
    assert_eq!(server.only_run(&posted).state, State::Cancelled);
    assert_eq!(server.terminate().code(), Some(0));
}

/// Also where the checkpoint that the run goes on from was taken while it waited.
#[test]
fn a_run_that_waits_for_a_reader_that_lags_behind_is_saved_and_finds_the_same() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_with(home.path(), &["--threads", "1"]);
    let lossless = json!({ "readers": 1, "timeout_ms": 60_000 });
    let (posted, run) = begin_with_lossless(&server, &lossless);
    let service = run_service(&run, "lossless");
    let reader = FrameReader::open_within(&root(home.path()), &service, WAIT).unwrap();
    for _ in 0..700 {
        reader.wait(WAIT).unwrap().unwrap();
    }
    until_it_waits(&server, &posted, WaitsFor::LosslessReaders);
    let route = format!("/v1/runs/{run}/learning");
    let learning: Learning = at_once("learning", || server.read(&route));
    assert!(learning.is_live && learning.arena_step.is_some_and(|step| step >= 700));
    let route = format!("/v1/runs/{run}/checkpoint");
    let taken = at_once("a checkpoint", || server.send("POST", &route, &[], b""));
    assert_eq!(taken.status, 200, "{}", taken.text());
    drop(reader);
    server.kill();

    let server = Server::start(home.path());
    server.wait_for(&posted);
    let other = tempfile::tempdir().unwrap();
    let alone = Server::start(other.path());
    alone.wait_for(&alone.submit(&job(learner(), 1)));
    assert!(
        Findings::of_run(&alone, &run) == Findings::of_run(&server, &run),
        "a wait changed what a run found"
    );
}

#[test]
fn a_run_whose_controller_is_silent_says_so_and_is_let_go_at_once() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let posted = server.submit(&json!({
        "base": {
            "arena": "easy", "epochs": 3,
            "controller": { "method": "external", "deadline_ms": 600_000 },
        },
        "seeds": [1],
    }));
    let run = server.only_run(&posted).id;
    // Nobody is there: the question is not even asked.
    until_it_waits(&server, &posted, WaitsFor::Controllers);
    // Somebody is there, and silent.
    let _silent = Controller::open(&root(home.path()), &run, 0).unwrap();
    std::thread::sleep(Duration::from_millis(100));
    until_it_waits(&server, &posted, WaitsFor::Controllers);
    let route = format!("/v1/runs/{run}/checkpoint");
    let taken = at_once("a checkpoint", || server.send("POST", &route, &[], b""));
    assert_eq!(taken.status, 200, "{}", taken.text());
    for (what, is_so) in [
        ("pause", State::Paused),
        ("resume", State::Running),
        ("cancel", State::Cancelled),
    ] {
        change(&server, &run, what);
        at_once(what, || {
            wait::until(what, || {
                let run = server.only_run(&posted);
                let workers: Value = server.read("/v1/workers");
                let is_held = !workers["items"].as_array().unwrap().is_empty();
                (run.state == is_so && is_held == (is_so == State::Running)).then_some(())
            })
        });
    }
    assert_eq!(server.terminate().code(), Some(0));
}
