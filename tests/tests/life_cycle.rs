//! Jobs outlive the server: killed right after a job was accepted, or asked to stop; and jobs that
//! nobody wants any more end.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::Write;
use std::net::TcpStream;
use std::time::Duration;

use api::{Job, State};
use rustix::process::Signal;
use serde_json::{Value, json};
use tests::server::Server;
use tests::{job, small_spec, wait};

/// A job that takes far longer than a test.
fn endless() -> serde_json::Value {
    let mut spec = small_spec();
    spec["epochs"] = json!(100_000);
    spec["steps_per_epoch"] = json!(10_000);
    job(spec, 3)
}

#[test]
fn an_accepted_job_survives_a_kill() {
    let home = tempfile::tempdir().unwrap();
    for round in 0..3 {
        let server = Server::start(home.path());
        let mut spec = small_spec();
        spec["epochs"] = json!(10 + round);
        let accepted = server.submit(&job(spec, 2));
        server.kill();

        let server = Server::start(home.path());
        let done = server.wait_for(&accepted);
        assert_eq!((&done.id, done.runs.done), (&accepted.id, 2));
        assert_eq!(done.created_at, accepted.created_at);
        for run in server.runs(&done) {
            assert!(run.result.unwrap().p1 > 0);
        }
    }
}

#[test]
fn a_server_that_is_asked_to_stop_ends_well_and_goes_on() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let posted = server.submit(&endless());
    wait::until("some steps", || {
        let progress = server.runs(&posted)[0].progress.clone()?;
        (progress.robot_steps_done > 0).then_some(())
    });
    let before = server.runs(&posted)[0].progress.clone().unwrap();
    let status = server.terminate();
    assert_eq!(status.code(), Some(0), "{status}");

    let server = Server::start(home.path());
    let after = wait::until("the run", || server.runs(&posted)[0].progress.clone());
    assert!(after.robot_steps_done >= before.robot_steps_done);
    // Not where a checkpoint happened to be: where it was stopped.
    wait::until("more steps", || {
        let now = server.runs(&posted)[0].progress.clone()?;
        (now.robot_steps_done > after.robot_steps_done).then_some(())
    });
}

/// Process groups, Slurm and container inits send several signals within milliseconds.
#[test]
fn a_server_that_is_asked_several_times_at_once_still_ends_well() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let posted = server.submit(&endless());
    wait::until("some steps", || {
        let progress = server.runs(&posted)[0].progress.clone()?;
        (progress.robot_steps_done > 0).then_some(())
    });
    for signal in [Signal::TERM, Signal::INT, Signal::TERM] {
        server.signal(signal);
        std::thread::sleep(Duration::from_millis(3));
    }
    let status = server.end();
    assert_eq!(status.code(), Some(0), "{status}");
    let checkpoints = std::fs::read_dir(home.path().join("data/checkpoints")).unwrap();
    assert_eq!(checkpoints.count(), 2, "of the runs that two threads had");
}

#[test]
fn a_server_that_is_asked_again_a_second_later_ends_at_once() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    // A request that is never finished, which the server waits for a little.
    let mut open = TcpStream::connect(server.url().trim_start_matches("http://")).unwrap();
    open.write_all(b"POST /v1/jobs HTTP/1.1\r\nhost: 127.0.0.1\r\n")
        .unwrap();
    open.write_all(b"content-type: application/json\r\ncontent-length: 100\r\n\r\n{")
        .unwrap();
    std::thread::sleep(Duration::from_millis(300));
    server.signal(Signal::TERM);
    std::thread::sleep(Duration::from_millis(1_200));
    server.signal(Signal::TERM);
    assert_eq!(server.end().code(), Some(1));
}

#[test]
fn a_log_for_programs_has_an_object_a_line_with_the_run_in_it() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_with(
        home.path(),
        &["--log-format", "json", "--run-memory-bytes", "1000000"],
    );
    let mut spec = small_spec();
    spec["robots"] = json!(500);
    spec["placement"] = json!("grid");
    spec["arena"] = json!({ "from": "easy", "tile": [5, 5] });
    let posted = server.submit(&job(spec, 1));
    wait::until("the failure", || {
        let job: Job = server.read(&format!("/v1/jobs/{}", posted.id));
        (job.runs.failed == 1).then_some(())
    });
    let id = server.only_run(&posted).id;
    assert_eq!(server.terminate().code(), Some(0));
    let log = std::fs::read_to_string(home.path().join("server.log")).unwrap();
    let lines: Vec<Value> = log
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}")))
        .collect();
    let failed = lines.iter().find(|line| line["level"] == "ERROR").unwrap();
    assert_eq!(failed["span"]["id"], id.as_str(), "{failed}");
    assert!(failed["timestamp"].is_string());
}

#[test]
fn two_servers_do_not_share_a_data_directory() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let data = home.path().join("data");
    let arguments = [
        "serve",
        "--listen",
        "127.0.0.1:0",
        "--data",
        data.to_str().unwrap(),
    ];
    let second = tests::command::evswarm(&arguments, "");
    assert_eq!(second.code, Some(1), "{second:?}");
    assert_eq!(server.get("/health/readyz").status, 200);
}

#[test]
fn jobs_are_paused_resumed_cancelled_and_deleted() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let posted = server.submit(&endless());
    let path = format!("/v1/jobs/{}", posted.id);
    let ask = |what: &str| -> Job {
        let answer = server.send("POST", &format!("{path}/{what}"), &[], b"");
        assert_eq!(answer.status, 200, "{}", answer.text());
        answer.json()
    };
    let wait_for = |state: State, running: u64| {
        wait::until("the state", || {
            let job: Job = server.read(&path);
            (job.state == state && job.runs.running == running).then_some(job)
        })
    };
    wait_for(State::Running, 2);
    assert_eq!(ask("pause").state, State::Paused);
    let paused = wait_for(State::Paused, 0);
    assert_eq!(paused.runs.paused, 3);
    ask("resume");
    wait_for(State::Running, 2);
    assert_eq!(ask("cancel").state, State::Cancelled);
    let cancelled = wait_for(State::Cancelled, 0);
    assert_eq!((cancelled.runs.cancelled, cancelled.runs.done), (3, 0));
    server
        .send("POST", &format!("{path}/resume"), &[], b"")
        .problem(409);

    // Threads are free again.
    let other = server.submit(&job(small_spec(), 2));
    server.wait_for(&other);
    assert_eq!(server.send("DELETE", &path, &[], b"").status, 204);
    server.get(&path).problem(404);
    let done = format!("/v1/jobs/{}/cancel", other.id);
    server.send("POST", &done, &[], b"").problem(409);
}
