//! `evswarm reproduce`, killed half way and started again, writes the same report to the byte.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;

use api::{Job, State};
use rusqlite::{Connection, OpenFlags};
use serde_json::json;
use tests::server::Server;
use tests::{command, wait};

/// All that the report consists of.
const FILES: [&str; 4] = ["runs.csv", "claims.json", "report.md", "report.html"];

/// Every method, small runs, some under rapier; into the directory `out` of `home`.
fn start(home: &Path, out: &str) -> std::process::Child {
    let out = home.join(out);
    let arguments = [
        "reproduce",
        "--out",
        out.to_str().unwrap(),
        "--seeds",
        "2",
        "--epochs",
        "40",
        "--arenas",
        "easy",
        "--rapier-seeds",
        "1",
        "--threads",
        "1",
    ];
    command::start(&arguments, home)
}

/// Runs in all and runs that are done, by the database that a service could be started on.
fn runs(out: &Path) -> Option<[u32; 2]> {
    let database = out.join("data").join("evswarm.sqlite3");
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY;
    let connection = Connection::open_with_flags(database, flags).ok()?;
    let counts = "SELECT count(*), count(*) FILTER (WHERE state = 'done') FROM runs";
    let count = |row: &rusqlite::Row<'_>| Ok([row.get(0)?, row.get(1)?]);
    connection.query_row(counts, [], count).ok()
}

fn done(out: &Path) -> u32 {
    runs(out).map_or(0, |[_, done]| done)
}

#[test]
fn a_killed_reproduction_ends_in_the_same_report() {
    let home = tempfile::tempdir().unwrap();
    let whole = command::finish(start(home.path(), "whole"));
    assert_eq!(whole.code, Some(0), "{whole:?}");
    assert!(whole.stdout.contains("claim 10:"), "{whole:?}");
    let [all, finished] = runs(&home.path().join("whole")).unwrap();
    assert_eq!(all, finished);

    let out = home.path().join("killed");
    let mut child = start(home.path(), "killed");
    wait::until("some runs", || (done(&out) >= all / 2).then_some(()));
    child.kill().unwrap();
    let killed = command::finish(child);
    assert_eq!(killed.code, None, "it was done too soon");
    assert!(done(&out) < all && !out.join("report.md").exists());

    let resumed = command::finish(start(home.path(), "killed"));
    assert_eq!(resumed.code, Some(0), "{resumed:?}");
    assert!(resumed.stderr.contains("runs are complete"), "{resumed:?}");
    for name in FILES {
        let of = |out: &str| fs::read(home.path().join(out).join(name)).unwrap();
        assert!(of("whole") == of("killed"), "{name} differs");
    }
    the_same_over_http(&out);
}

/// A service on the same data gives the same report, of that job and of the same one posted to it.
fn the_same_over_http(out: &Path) {
    let server = Server::start(out);
    let job = json!({
        "base": { "epochs": 40 },
        "seeds": { "first": 1, "count": 2 },
        "parts": [
            { "matrix": { "arena": ["easy"], "controller.method": server.chapter_5_methods() } },
            {
                "base": { "engine": "rapier" },
                "matrix": {
                    "arena": ["easy"], "controller.method": ["im", "ev-iter-c", "curiosity-a"]
                },
                "seeds": [1]
            }
        ]
    });
    let posted = server.post("/v1/jobs", &job);
    assert_eq!(posted.status, 201, "{}", posted.text());
    let posted: Job = posted.json();
    assert_eq!(
        (posted.state, posted.runs.done),
        (State::Done, posted.runs.total)
    );
    for id in ["1", &posted.id] {
        for (file, suffix) in FILES.iter().zip([".csv", "", ".md", ".html"]) {
            let answer = server.get(&format!("/v1/jobs/{id}/report{suffix}"));
            assert_eq!(answer.status, 200, "{}", answer.text());
            assert!(
                answer.body == fs::read(out.join(file)).unwrap(),
                "{file} of job {id} differs"
            );
        }
    }
}
