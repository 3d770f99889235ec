//! A disk that runs full under a server: what is asked for is refused with the reason, the server
//! says that it is not ready, and its runs are taken up again when there is room.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use serde_json::Value;
use tests::server::Server;
use tests::{job, small_spec, wait};

/// Writes until nothing more fits.
fn fill(path: &Path) {
    let mut file = File::create(path).unwrap();
    for bytes in [1 << 20, 4_096, 1] {
        let part = vec![1_u8; bytes];
        while file.write_all(&part).is_ok() {}
    }
}

#[test]
fn a_full_disk_is_told_and_runs_go_on_when_there_is_room() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_on_a_small_disk(home.path(), 48 << 20);
    let disk = server.disk(home.path());
    assert_eq!(server.get("/health/readyz").status, 200);
    // Long enough to be under way when the disk is full, and to end meanwhile.
    let mut spec = small_spec();
    spec["epochs"] = 2_000.into();
    let posted = server.post("/v1/jobs", &job(spec.clone(), 1));
    assert_eq!(posted.status, 201);
    let run = wait::until("the run has begun", || {
        let runs = server.read::<Value>("/v1/jobs/1/runs");
        let run = runs["items"][0].clone();
        (run["state"] == "running").then(|| run["id"].as_str().unwrap().to_owned())
    });

    let filler = disk.join("filler");
    fill(&filler);
    let ready = server.get("/health/readyz").problem(503);
    assert!(ready.detail.unwrap().contains("no room"));
    assert_eq!(server.get("/health/livez").status, 200);
    let many = server.post("/v1/jobs", &job(spec, 300));
    let problem = many.problem(507);
    assert_eq!(problem.code, "store-full");
    assert!(problem.detail.unwrap().contains("no room"));
    // An old checkpoint is not passed off as a new one.
    let asked = server.send("POST", &format!("/v1/runs/{run}/checkpoint"), &[], b"");
    assert_eq!(asked.problem(507).code, "store-full");
    // What is there can be read, and the run is neither lost nor failed: it waits with its end.
    wait::until("the run waits for room", || {
        let run = server.read::<Value>(&format!("/v1/runs/{run}"));
        assert_eq!(run["state"], "running", "{run}");
        (run["waits_for"] == "store").then_some(())
    });
    let asked = server.send("POST", &format!("/v1/runs/{run}/checkpoint"), &[], b"");
    assert_eq!(asked.problem(507).code, "store-full");

    fs::remove_file(&filler).unwrap();
    assert_eq!(server.get("/health/readyz").status, 200);
    wait::until("the run is done", || {
        let run = server.read::<Value>(&format!("/v1/runs/{run}"));
        assert_ne!(run["state"], "failed", "{run}");
        (run["state"] == "done").then_some(())
    });
    // Nothing is left of what was refused, and what is posted now is done.
    let jobs = server.read::<Value>("/v1/jobs");
    assert_eq!(jobs["items"].as_array().unwrap().len(), 1, "{jobs}");
    let again = server.post("/v1/jobs", &job(small_spec(), 2));
    assert_eq!(again.status, 201);
    wait::until("the next job", || {
        (server.read::<Value>("/v1/jobs")["items"][0]["state"] == "done").then_some(())
    });
    assert!(server.terminate().success());
}
