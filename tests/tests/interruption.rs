//! The same spec gives the same files on any number of threads, through a server or not, and
//! whether or not the process was killed on the way.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;
use std::process::Child;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use rustix::process::Signal;
use serde_json::{Value, json};
use tests::command::{self, Done};
use tests::files::Findings;
use tests::server::{Server, signal};
use tests::wait;

/// Seconds that the run takes at least, so that it can be killed in the middle.
const RUN_S: f64 = 4.0;

/// All phases, with two robots that meet; long enough, on any machine, to be killed in the middle.
fn spec() -> Value {
    static EPOCHS: OnceLock<u32> = OnceLock::new();
    let epochs = EPOCHS.get_or_init(|| {
        let home = tempfile::tempdir().unwrap();
        let (probe, start) = (400, Instant::now());
        findings(&spec_of(probe), &home.path().join("out"), "1");
        let longer = RUN_S / start.elapsed().as_secs_f64();
        (f64::from(probe) * longer).clamp(3_000.0, 500_000.0) as u32
    });
    spec_of(*epochs)
}

fn spec_of(epochs: u32) -> Value {
    json!({
        "seed": 7, "arena": "graph", "robots": 2, "placement": "grid",
        "controller": { "method": "ev-iter-c", "train": { "arena": "easy", "epochs": 100 } },
        "epochs": epochs
    })
}

/// What the run finds when nothing happens to it.
fn undisturbed() -> &'static Findings {
    static FINDINGS: OnceLock<Findings> = OnceLock::new();
    FINDINGS.get_or_init(|| {
        let home = tempfile::tempdir().unwrap();
        findings(&spec(), &home.path().join("out"), "1")
    })
}

fn findings(spec: &Value, out: &Path, threads: &str) -> Findings {
    let done = command::run(spec, out, threads);
    assert_eq!(done.code, Some(0), "{done:?}");
    Findings::of_directory(out)
}

#[test]
fn threads_do_not_matter() {
    let home = tempfile::tempdir().unwrap();
    let two = findings(&spec(), &home.path().join("two"), "2");
    undisturbed().assert_same(&two, "two threads");
    assert!(two.result().p1 > 1_000, "{:?}", two.result());

    // Enough robots in one arena that threads share them.
    let crowd = json!({
        "arena": {
            "name": "hall", "width_m": 8.0, "height_m": 8.0, "walls_m": [],
            "starts": [{ "x_m": 4.0, "y_m": 4.0, "heading_rad": 0.0 }]
        },
        "robots": 2_000, "placement": "random", "episodes": "continue",
        "controller": { "method": "im" }, "epochs": 2, "steps_per_epoch": 100
    });
    let one = findings(&crowd, &home.path().join("crowd-1"), "1");
    let two = findings(&crowd, &home.path().join("crowd-2"), "2");
    one.assert_same(&two, "a crowd on two threads");
    assert!(one.result().collisions > 0);
}

#[test]
fn a_killed_server_goes_on() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut base = spec();
    let seed = base.as_object_mut().unwrap().remove("seed").unwrap();
    let job = server.submit(&json!({ "base": base, "seeds": [seed] }));
    let id = server.only_run(&job).id;
    let checkpoints = home.path().join("data/checkpoints");
    let saved = wait::until("a checkpoint in the middle", || {
        let fraction = server.only_run(&job).progress?.fraction;
        assert!(fraction < 1.0, "it was done before it could be killed");
        let saved = holds_file(&checkpoints);
        // On a machine so fast that none is due before the end, the run starts over.
        (fraction > 0.3 && saved || fraction > 0.8).then_some(saved)
    });
    server.kill();

    let server = Server::start(home.path());
    let first = wait::until("the run", || server.only_run(&job).progress);
    assert!(!saved || first.robot_steps_done > 0, "{first:?}");
    server.wait_for(&job);
    undisturbed().assert_same(&Findings::of_run(&server, &id), "a killed server");
}

fn holds_file(directory: &Path) -> bool {
    fs::read_dir(directory).is_ok_and(|entries| {
        entries.flatten().any(|entry| {
            entry
                .metadata()
                .is_ok_and(|data| data.is_file() && data.len() > 0)
        })
    })
}

#[test]
fn a_stopped_and_a_killed_command_go_on() {
    let home = tempfile::tempdir().unwrap();
    let (file, out) = (home.path().join("spec.json"), home.path().join("out"));
    fs::write(&file, spec().to_string()).unwrap();
    let start = || {
        let arguments = [
            "run",
            file.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ];
        command::start(&arguments, home.path())
    };
    let wait_until_begun = |child: &mut Child| {
        wait::until("the run to begin", || {
            home.path().join("out.partial").is_dir().then_some(())
        });
        std::thread::sleep(Duration::from_millis(200));
        assert!(child.try_wait().unwrap().is_none(), "it was done too soon");
        assert!(!out.exists(), "all files or none");
    };

    let mut child = start();
    wait_until_begun(&mut child);
    // As process groups, Slurm and container inits do: several within milliseconds.
    for asked in [Signal::INT, Signal::TERM, Signal::INT] {
        signal(&child, asked);
        std::thread::sleep(Duration::from_millis(2));
    }
    let stopped = command::finish(child);
    assert_eq!(stopped.code, Some(1));
    assert!(stopped.stderr.contains("goes on from here"), "{stopped:?}");

    let mut child = start();
    wait_until_begun(&mut child);
    let second = command::finish(start());
    assert_eq!(second.code, Some(1));
    assert!(second.stderr.contains("another process"), "{second:?}");
    child.kill().unwrap();
    let killed = command::finish(child);
    assert_eq!(killed.code, None);
    assert!(killed.stderr.contains("going on at"), "{killed:?}");

    let done: Done = command::finish(start());
    assert_eq!(done.code, Some(0), "{done:?}");
    assert!(done.stderr.contains("going on at"), "{done:?}");
    undisturbed().assert_same(&Findings::of_directory(&out), "a killed command");
    assert!(!home.path().join("out.partial").exists());

    let complete = command::finish(start());
    assert_eq!(complete.code, Some(0));
    assert!(complete.stdout.contains("already complete"), "{complete:?}");
}
