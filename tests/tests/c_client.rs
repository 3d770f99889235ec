//! Programs in C steer and watch a run, compiled here as the examples say.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tests::{program, wait};

/// Compiles an example of `clients/c`.
fn compiled(home: &Path, name: &str) -> PathBuf {
    let library = program("libevswarm_client.so");
    let folder = library.parent().unwrap();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clients/c");
    let target = home.join(name);
    let output = Command::new("cc")
        .args([
            "-std=c11",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-O2",
            "-ffp-contract=off",
            "-I",
        ])
        .arg(sources.join("include"))
        .arg(sources.join("examples").join(format!("{name}.c")))
        .arg("-o")
        .arg(&target)
        .arg("-L")
        .arg(folder)
        .arg("-levswarm_client")
        .arg(format!("-Wl,-rpath,{}", folder.display()))
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    target
}

fn spec(method: Value) -> Value {
    json!({
        "arena": { "from": "easy", "tile": [2, 2] }, "robots": 7, "placement": "grid", "seed": 5,
        "controller": method, "epochs": 1_000, "steps_per_epoch": 200, "channels": true,
    })
}

/// What a run logs.
fn log(home: &Path, name: &str) -> PathBuf {
    home.join(format!("{name}.log"))
}

/// `evswarm run` of a spec, under a name of its own.
fn start(home: &Path, name: &str, method: Value) -> Child {
    let path = home.join(format!("{name}.json"));
    std::fs::write(&path, spec(method).to_string()).unwrap();
    Command::new(program("evswarm"))
        .args([
            "run",
            path.to_str().unwrap(),
            "--external-name",
            name,
            "--out",
        ])
        .arg(home.join(name))
        .env("XDG_RUNTIME_DIR", home)
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(log(home, name)).unwrap())
        .spawn()
        .unwrap()
}

fn steering(home: &Path, braitenberg: &Path, name: &str) -> Child {
    Command::new(braitenberg)
        .arg(name)
        .env("XDG_RUNTIME_DIR", home)
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn end(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_controller_in_c_that_is_killed_and_started_again_gives_the_bits_of_the_one_built_in() {
    let home = tempfile::tempdir().unwrap();
    let home = home.path();
    let braitenberg = compiled(home, "braitenberg");
    let mut built_in = start(home, "built-in", json!({ "method": "braitenberg" }));
    assert!(wait::for_exit(&mut built_in).success());
    let method = json!({ "method": "external", "deadline_ms": 20_000 });
    let mut outside = start(home, "outside", method);
    for milliseconds in [150, 40, 90] {
        let doomed = steering(home, &braitenberg, "outside");
        std::thread::sleep(Duration::from_millis(milliseconds));
        end(doomed);
        assert!(
            outside.try_wait().unwrap().is_none(),
            "it was killed on the way"
        );
    }
    let last = steering(home, &braitenberg, "outside");
    assert!(wait::for_exit(&mut outside).success());
    end(last);
    for file in ["curve.csv", "metrics.csv", "visits.npy", "robots.csv"] {
        let read = |run: &str| std::fs::read(home.join(run).join(file)).unwrap();
        assert!(read("built-in") == read("outside"), "{file} differs");
    }
}

#[test]
fn a_program_in_c_sees_frames() {
    let home = tempfile::tempdir().unwrap();
    let home = home.path();
    let frames = compiled(home, "frames");
    let helped = Command::new(&frames).arg("--help").output().unwrap();
    let usage = String::from_utf8_lossy(&helped.stdout);
    assert!(helped.status.success() && usage.starts_with("usage: frames RUN_ID"));
    let method = json!({ "method": "external", "deadline_ms": 20_000 });
    // Nobody steers: it stays at its first step for as long as it is watched.
    let run = start(home, "waits", method);
    let key = wait::until("the id of the run", || {
        let log = std::fs::read_to_string(log(home, "waits")).unwrap();
        let (_, rest) = log.split_once("swarm/")?;
        Some(rest.split_once("/frames")?.0.to_owned())
    });
    let seen = wait::until("a frame", || {
        let output = Command::new(&frames)
            .args([&key, "1"])
            .env("XDG_RUNTIME_DIR", home)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        said.starts_with("step 0  0 at (0.").then_some(said)
    });
    assert!(seen.contains("  6 at ("), "{seen}");
    end(run);
}
