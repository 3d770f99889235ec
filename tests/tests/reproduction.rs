//! `evswarm reproduce`, killed half way and started again, writes the same report to the byte.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use tests::command;
use tests::wait;

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

/// Runs that are complete: directories named by the whole of a run's key.
fn complete(out: &Path) -> usize {
    fs::read_dir(out.join("runs")).map_or(0, |entries| {
        let names = entries.flatten().map(|entry| entry.file_name());
        names.filter(|name| name.len() == 64).count()
    })
}

#[test]
fn a_killed_reproduction_ends_in_the_same_report() {
    let home = tempfile::tempdir().unwrap();
    let whole = command::finish(start(home.path(), "whole"));
    assert_eq!(whole.code, Some(0), "{whole:?}");
    assert!(whole.stdout.contains("claim 10:"), "{whole:?}");
    let runs = complete(&home.path().join("whole"));

    let out = home.path().join("killed");
    let mut child = start(home.path(), "killed");
    wait::until("some runs", || (complete(&out) >= runs / 2).then_some(()));
    child.kill().unwrap();
    let killed = command::finish(child);
    assert_eq!(killed.code, None, "it was done too soon");
    assert!(complete(&out) < runs && !out.join("report.md").exists());

    let resumed = command::finish(start(home.path(), "killed"));
    assert_eq!(resumed.code, Some(0), "{resumed:?}");
    assert!(resumed.stderr.contains("runs are complete"), "{resumed:?}");
    for name in FILES {
        let of = |out: &str| fs::read(home.path().join(out).join(name)).unwrap();
        assert!(of("whole") == of("killed"), "{name} differs");
    }
}
