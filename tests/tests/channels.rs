//! A program of its own reads a run's frames from shared memory, and the run is none the wiser.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;
use std::process::{Command, Stdio};

use api::State;
use api::channels::ChannelDescription;
use serde_json::json;
use tests::files::Findings;
use tests::server::Server;
use tests::{job, program, small_spec, wait};

/// What the example prints of 30 frames.
fn watch(id: &str, root: &Path) -> String {
    let mut reader = Command::new(program("examples/watch_frames"))
        .args([id, "--frames", "30", "--root"])
        .arg(root)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let status = wait::for_exit(&mut reader);
    let output = reader.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(status.success(), "{text}{errors}");
    text.into_owned()
}

/// Some took it for the id of a run.
#[test]
fn examples_tell_their_usage() {
    for name in ["viewer", "braitenberg", "record_csv", "watch_frames"] {
        for (arguments, code) in [(&["--help"][..], 0), (&[], 2)] {
            let mut example = Command::new(program(&format!("examples/{name}")));
            let output = example.args(arguments).output().unwrap();
            let said = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
            assert_eq!(output.status.code(), Some(code), "{name}: {said:?}");
            let said = if code == 0 { &said[0] } else { &said[1] };
            assert!(
                said.contains("Usage") && said.contains("RUN_ID"),
                "{name}: {said}"
            );
        }
    }
}

#[test]
fn a_reader_gets_frames_while_the_run_goes_on() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut spec = small_spec();
    spec["epochs"] = json!(100_000);
    spec["steps_per_epoch"] = json!(2_000);
    spec["channels"] = json!(true);
    spec["robots"] = json!(4);
    spec["placement"] = json!("grid");
    let posted = server.submit(&job(spec, 1));
    let id = server.only_run(&posted).id;

    let channels: Vec<ChannelDescription> = server.read(&format!("/v1/runs/{id}/channels"));
    assert_eq!(channels[0].name, "frames");
    let root = home.path().join("evswarm");
    assert_eq!(channels[0].root_path, root.to_str().unwrap());
    let text = watch(&id, &root);
    assert!(
        text.contains("exploration") && text.contains("4 robots"),
        "{text}"
    );
    assert!(text.contains("robot 0: x 0."), "{text}");

    assert_eq!(server.only_run(&posted).state, State::Running);
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn a_reader_gets_movable_objects_too() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let spec = include_str!("../../experiments/pushing-boxes.json");
    let mut spec: serde_json::Value = serde_json::from_str(spec).unwrap();
    spec["epochs"] = json!(100_000);
    spec["channels"] = json!(true);
    let posted = server.submit(&job(spec, 1));
    let id = server.only_run(&posted).id;
    let channels: Vec<ChannelDescription> = server.read(&format!("/v1/runs/{id}/channels"));
    let services: Vec<_> = channels[..2]
        .iter()
        .map(|channel| &channel.service)
        .collect();
    let expected = ["frames", "objects"].map(|name| format!("swarm/{id}/{name}"));
    assert_eq!(services, expected.iter().collect::<Vec<_>>());
    let text = watch(&id, &home.path().join("evswarm"));
    assert!(
        text.contains("2 robots") && text.contains("object 2: x 0."),
        "{text}"
    );
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn a_run_with_channels_finds_what_it_finds_without() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut spec = small_spec();
    spec["controller"] = json!({ "method": "im" });
    spec["epochs"] = json!(20);
    let mut findings = Vec::new();
    for channels in [false, true] {
        spec["channels"] = json!(channels);
        let done = server.wait_for(&server.submit(&job(spec.clone(), 1)));
        findings.push(server.only_run(&done));
    }
    assert_ne!(findings[0].id, findings[1].id);
    assert_eq!(findings[0].result, findings[1].result);
    let [without, with] = [0, 1].map(|place| Findings::of_run(&server, &findings[place].id));
    assert_eq!(without.differing(&with), ["spec.json"]);
}

/// A write to shared memory without room ends the process (SIGBUS), and did so again at every start.
#[test]
fn a_full_dev_shm_costs_the_channels_and_nothing_else() {
    let home = tempfile::tempdir().unwrap();
    let mut spec = small_spec();
    spec["channels"] = json!(true);
    spec["arena"] = json!({ "from": "easy", "tile": [8, 8], "squares": 20 });
    spec["robots"] = json!(1_000);
    spec["placement"] = json!("grid");
    std::fs::write(home.path().join("spec.json"), spec.to_string()).unwrap();
    // A file system of its own for /dev/shm: 4 MB, of which `free` stay free.
    let run = |full_kb: u32, out: &str| {
        let script = format!(
            "mount -t tmpfs -o size=4m tmpfs /dev/shm && \
             head -c {full_kb}K /dev/zero >/dev/shm/full && exec \"$1\" run spec.json --out {out}"
        );
        Command::new("unshare")
            .args([
                "--user",
                "--map-root-user",
                "--mount",
                "sh",
                "-c",
                &script,
                "sh",
            ])
            .arg(program("evswarm"))
            .env("XDG_RUNTIME_DIR", home.path())
            .env_remove("RUST_LOG")
            .current_dir(home.path())
            .output()
            .unwrap()
    };
    for (full_kb, out) in [
        (4_096, "full"),
        (4_000, "nearly"),
        (2_000, "half"),
        (0, "free"),
    ] {
        let done = run(full_kb, out);
        let errors = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{out}: {:?} {errors}", done.status);
        assert_eq!(
            errors.contains("/dev/shm has"),
            full_kb > 2_000,
            "{out}: {errors}"
        );
    }
    assert!(
        Findings::of_directory(&home.path().join("full"))
            == Findings::of_directory(&home.path().join("free"))
    );
}
