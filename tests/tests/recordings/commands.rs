//! `evswarm replay`, `video` and `explain`, of files and of runs of a server.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use tests::command::{self, Done, evswarm, evswarm_in};
use tests::server::Server;

use super::{one_run, recorded_afterwards};

fn spec() -> Value {
    json!({
        "arena": "easy", "robots": 2, "placement": "grid", "epochs": 3, "steps_per_epoch": 200,
        "controller": { "method": "im", "babbling_epochs": 1 },
    })
}

/// The recording that a command leaves.
fn recorded(home: &Path) -> String {
    let mut spec = spec();
    spec["seed"] = json!(1);
    spec["record"] = json!({ "every_steps": 1 });
    let out = home.join("out");
    let done = command::run(&spec, &out, "1");
    assert_eq!(done.code, Some(0), "{done:?}");
    out.join("recording.evrec").to_str().unwrap().to_owned()
}

fn done(arguments: &[&str]) -> Done {
    let done = evswarm(arguments, "");
    assert_eq!(done.code, Some(0), "{arguments:?}: {done:?}");
    done
}

/// The number of pictures of a GIF, and its size.
fn pictures(path: &Path) -> (usize, [u16; 2]) {
    let mut decoder = gif::Decoder::new(fs::File::open(path).unwrap()).unwrap();
    let size = [decoder.width(), decoder.height()];
    let mut count = 0;
    while decoder.read_next_frame().unwrap().is_some() {
        count += 1;
    }
    (count, size)
}

#[test]
fn a_recording_is_played_as_text_and_as_a_film() {
    let home = tempfile::tempdir().unwrap();
    let file = recorded(home.path());
    let shown = done(&["replay", &file, "--every", "100"]).stdout;
    // Epochs of 200 steps, with their ends: 0, 100, 200 of each, learning included.
    let titles: Vec<&str> = shown
        .lines()
        .filter(|line| line.starts_with("step "))
        .collect();
    let epochs = titles.len() / 3;
    assert!(epochs >= 4 && titles.len() == 3 * epochs, "{titles:?}");
    assert!(
        titles[1].starts_with("step 100  epoch 0 (babbling 0)  step 100 of 200"),
        "{titles:?}"
    );
    assert!(
        shown.contains("robot 1  at (") && shown.contains("wheels "),
        "{shown}"
    );
    assert!(shown.contains("#"), "no wall is drawn");
    let part = done(&[
        "replay",
        &file,
        "--every",
        "10",
        "--from-step",
        "400",
        "--steps",
        "21",
    ]);
    assert_eq!(
        part.stdout.matches("\nrobot 0").count(),
        3,
        "{}",
        part.stdout
    );

    let film = home.path().join("run.gif");
    let film_name = film.to_str().unwrap();
    let said = done(&[
        "video", &file, "--out", film_name, "--every", "20", "--pixels", "200",
    ]);
    assert!(said.stdout.contains("pictures"), "{said:?}");
    let (count, size) = pictures(&film);
    assert_eq!(count, 11 * epochs);
    assert_eq!(size[0].max(size[1]), 200);

    // What cannot be is said, and leaves no file behind.
    let refused = |arguments: &[&str], words: &str| {
        let done = evswarm(arguments, "");
        assert_eq!(done.code, Some(1), "{arguments:?}: {done:?}");
        assert!(done.stderr.contains(words), "{arguments:?}: {done:?}");
    };
    let other = home.path().join("run.avi");
    refused(
        &["video", &file, "--out", other.to_str().unwrap()],
        "neither .gif, .mp4 nor .webm",
    );
    refused(
        &["replay", "nowhere.evrec"],
        "nowhere.evrec is no file and no run's id",
    );
    let late = home.path().join("late.gif");
    refused(
        &[
            "video",
            &file,
            "--out",
            late.to_str().unwrap(),
            "--from-step",
            "9999999",
        ],
        "the recording ends at step",
    );
    assert!(!late.exists());
    refused(
        &["replay", &file, "--from-step", "9999999"],
        "the recording ends at step",
    );
    let broken = home.path().join("broken.evrec");
    fs::write(&broken, b"not a recording").unwrap();
    refused(&["replay", broken.to_str().unwrap()], "is no recording");
    // Without ffmpeg, what it is for is told.
    let mp4 = home.path().join("run.mp4");
    let alone = [("PATH", home.path().to_str().unwrap())];
    let done = evswarm_in(
        &["video", &file, "--out", mp4.to_str().unwrap()],
        "",
        &alone,
    );
    assert_eq!(done.code, Some(1), "{done:?}");
    assert!(done.stderr.contains("needs the program ffmpeg"), "{done:?}");
    assert!(done.stderr.contains(".gif needs nothing"), "{done:?}");
    // A recording that was cut is played as far as it goes.
    let bytes = fs::read(&file).unwrap();
    fs::write(&broken, &bytes[..bytes.len() - 30]).unwrap();
    evswarm(&["replay", broken.to_str().unwrap()], "");
}

#[test]
fn a_run_of_a_server_is_played_and_explained() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let job = server.submit(&one_run(&spec()));
    server.wait_for(&job);
    let run = server.only_run(&job).id;
    let at = ["--server", server.url()];
    let ask = |arguments: &[&str]| evswarm(&[arguments, &at].concat(), "");
    let missing = ask(&["replay", &run]);
    assert_eq!(missing.code, Some(1), "{missing:?}");
    assert!(
        missing.stderr.contains("/recordings"),
        "what to do is not told: {missing:?}"
    );
    recorded_afterwards(&server, &run, &json!({ "from_epoch": 1, "epochs": 1 }));
    let shown = ask(&["replay", &run, "--recording", "1", "--every", "200"]);
    assert_eq!(shown.code, Some(0), "{shown:?}");
    assert!(shown.stdout.starts_with("step 200  epoch 1"), "{shown:?}");
    let film = home.path().join("run.gif");
    let name = film.to_str().unwrap();
    let made = ask(&[
        "video",
        &run,
        "--recording",
        "1",
        "--every",
        "50",
        "--out",
        name,
    ]);
    assert_eq!(made.code, Some(0), "{made:?}");
    assert_eq!(pictures(&film).0, 5);

    // By the server and from the spec: the same explanation.
    let explained = ask(&["explain", &run, "--json"]);
    assert_eq!(explained.code, Some(0), "{explained:?}");
    let by_server: Value = serde_json::from_str(&explained.stdout).unwrap();
    let file = home.path().join("spec.json");
    let mut seeded = spec();
    seeded["seed"] = json!(1);
    fs::write(&file, seeded.to_string()).unwrap();
    let by_command = done(&["explain", file.to_str().unwrap(), "--json"]).stdout;
    assert_eq!(
        serde_json::from_str::<Value>(&by_command).unwrap(),
        by_server
    );
    let text = done(&["explain", file.to_str().unwrap()]).stdout;
    assert!(
        text.starts_with(by_server["sentence"].as_str().unwrap()),
        "{text}"
    );
    // Nobody steers it here.
    let mut steered = seeded;
    steered["controller"] = json!({ "method": "external" });
    fs::write(&file, steered.to_string()).unwrap();
    let refused = evswarm(&["explain", file.to_str().unwrap()], "");
    assert_eq!(refused.code, Some(1), "{refused:?}");
    assert!(refused.stderr.contains("a program outside"), "{refused:?}");
}
