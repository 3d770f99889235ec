//! The program is killed at named places (`EVSWARM_BREAK`): nothing that was acknowledged is lost,
//! and what runs come to is the same to the bit.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use api::{Job, JobPage};
use rusqlite::Connection;
use serde_json::{Value, json};
use tests::files::Findings;
use tests::readme;
use tests::server::Server;
use tests::wait;

/// Two runs, long enough that they can be stopped on the way.
fn two_runs() -> Value {
    json!({
        "base": {
            "arena": "easy", "controller": { "method": "im", "babbling_epochs": 2 },
            "epochs": 3_000, "steps_per_epoch": 1_000,
        },
        "seeds": { "first": 1, "count": 2 },
    })
}

/// What they come to when nothing happens.
fn undisturbed() -> &'static [Findings] {
    static FINDINGS: OnceLock<Vec<Findings>> = OnceLock::new();
    FINDINGS.get_or_init(|| {
        let home = tempfile::tempdir().unwrap();
        let server = Server::start(home.path());
        let job = server.submit(&two_runs());
        finish(&server, &job)
    })
}

fn finish(server: &Server, job: &Job) -> Vec<Findings> {
    server.wait_for(job);
    let runs = server.runs(job);
    let findings = runs.iter().map(|run| Findings::of_run(server, &run.id));
    findings.collect()
}

/// A server that kills itself at the `count`th time that it comes to `place`.
fn doomed(home: &Path, place: &str, count: u32) -> Result<Server, String> {
    let asked = format!("{place}:{count}");
    Server::try_start(
        home,
        &["--threads", "1"],
        &[("EVSWARM_BREAK", asked.as_str())],
    )
}

/// Kills a server at a place, after `act`, which may be cut short by that.
fn kill_at(home: &Path, place: &str, act: impl Fn(&Server)) {
    // One that has work to do may be dead before it listens.
    if let Ok(mut server) = doomed(home, place, 1) {
        act(&server);
        server.wait_until_killed();
    }
}

#[test]
fn runs_killed_after_their_claim_in_a_checkpoint_and_at_their_end_come_to_the_same() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_with(home.path(), &["--threads", "1"]);
    let job = server.submit(&two_runs());
    assert_eq!(
        server
            .post(&format!("/v1/jobs/{}/pause", job.id), &Value::Null)
            .status,
        200
    );
    assert!(server.terminate().success());

    kill_at(home.path(), "claimed", |server| {
        let path = format!("/v1/jobs/{}/resume", job.id);
        // It may be killed before it answers.
        drop(server.try_send("POST", &path, &[], b""));
    });
    for _ in 0..2 {
        kill_at(home.path(), "checkpoint-rename", |server| {
            wait::until("progress", || {
                let runs = server.runs(&job);
                runs.iter().any(|run| run.progress.is_some()).then_some(())
            });
            server.ask_to_end();
        });
    }
    kill_at(home.path(), "result-stored", |_| {});
    kill_at(home.path(), "claimed", |_| {});
    kill_at(home.path(), "result-stored", |_| {});

    let server = Server::start(home.path());
    let found = finish(&server, &job);
    for (found, expected) in found.iter().zip(undisturbed()) {
        expected.assert_same(found, "killed again and again");
    }
    drop(server);
    let left: Vec<_> = fs::read_dir(home.path().join("data/checkpoints"))
        .unwrap()
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn a_kill_in_a_migration_leaves_the_old_database_or_the_new_one() {
    for old in [None, Some("v1")] {
        let mut survived = false;
        for count in 1..100 {
            let home = tempfile::tempdir().unwrap();
            if let Some(old) = old {
                let directory = readme::root().join("tests/data_directories").join(old);
                fs::create_dir_all(home.path().join("data/checkpoints")).unwrap();
                let name = "data/evswarm.sqlite3";
                fs::copy(directory.join(name), home.path().join(name)).unwrap();
            }
            survived = doomed(home.path(), "migration", count).is_ok();
            let server = Server::start(home.path());
            let jobs: JobPage = server.read("/v1/jobs");
            assert_eq!(jobs.items.len(), old.map_or(0, |_| 6), "{old:?} {count}");
            let done: Vec<&Job> = jobs.items.iter().filter(|job| job.runs.done > 0).collect();
            for run in done.iter().flat_map(|job| server.runs(job)) {
                let answer = server.get(&format!("/v1/runs/{}/coverage", run.id));
                assert_eq!(answer.status, 200, "{old:?} {count}");
            }
            if survived {
                assert!(count > 4, "there are more places than that");
                break;
            }
        }
        assert!(survived);
    }
}

#[test]
fn a_post_that_was_not_acknowledged_can_be_repeated_and_leaves_nothing_half() {
    for (place, count, stored) in [
        ("job-part", 1, false),
        ("job-part", 3, false),
        ("job-stored", 1, true),
    ] {
        let home = tempfile::tempdir().unwrap();
        let mut server = doomed(home.path(), place, count).unwrap();
        let headers = [
            ("content-type", "application/json"),
            ("idempotency-key", "once"),
        ];
        let body = many_runs().to_string();
        let broken = server.try_send("POST", "/v1/jobs", &headers, body.as_bytes());
        assert!(broken.is_err(), "{place}:{count}: {broken:?}");
        server.wait_until_killed();
        let server = Server::start(home.path());
        let jobs: JobPage = server.read("/v1/jobs");
        assert_eq!(jobs.items.len(), usize::from(stored), "{place}:{count}");
        let again = server.send("POST", "/v1/jobs", &headers, body.as_bytes());
        assert_eq!(again.status, 201, "{}", again.text());
        let again: Job = again.json();
        assert_eq!(again.runs.total, 2_500);
        let jobs: JobPage = server.read("/v1/jobs");
        assert_eq!(jobs.items.len(), 1, "{place}:{count}");
        drop(server);
        assert_eq!(rows(home.path(), "runs"), 2_500);
        assert_eq!(rows(home.path(), "job_runs"), 2_500);
    }
}

#[test]
fn a_job_whose_cancellation_or_deletion_was_cut_short_is_cancelled_or_gone() {
    for (method, action, state) in [("POST", "/cancel", Some("cancelled")), ("DELETE", "", None)] {
        let home = tempfile::tempdir().unwrap();
        let server = Server::start(home.path());
        let id = server.submit(&many_runs()).id;
        assert!(server.terminate().success());
        let mut server = doomed(home.path(), "job-changed", 2).unwrap();
        let broken = server.try_send(method, &format!("/v1/jobs/{id}{action}"), &[], b"");
        assert!(broken.is_err(), "{method}: {broken:?}");
        server.wait_until_killed();
        let server = Server::start(home.path());
        let answer = server.get(&format!("/v1/jobs/{id}"));
        match state {
            Some(state) => {
                let job: Value = answer.json();
                assert_eq!(job["state"], state);
                assert_eq!(job["runs"]["cancelled"], 2_500);
            }
            None => {
                answer.problem(404);
                assert_eq!(rows(home.path(), "runs"), 0);
            }
        }
        drop(server);
        let checkpoints = fs::read_dir(home.path().join("data/checkpoints")).unwrap();
        assert_eq!(checkpoints.count(), 0);
    }
}

fn rows(home: &Path, table: &str) -> i64 {
    let database = Connection::open(home.join("data/evswarm.sqlite3")).unwrap();
    let sql = format!("SELECT count(*) FROM {table}");
    database.query_row(&sql, [], |row| row.get(0)).unwrap()
}

/// More runs than are stored or changed in one transaction; none of them ends.
fn many_runs() -> Value {
    json!({
        "base": { "arena": "easy", "controller": { "method": "brownian" }, "epochs": 1_000_000 },
        "seeds": { "first": 1, "count": 2_500 },
    })
}
