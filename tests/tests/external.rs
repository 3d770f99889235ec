//! Robots that programs outside the simulator steer: the same bits as the same controller built in,
//! whoever is killed on the way; what cannot be used is said.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use api::controller::Controller;
use api::recording::{RecordingSlice, RecordingState};
use api::{Job, State};
use serde_json::{Value, json};
use tests::http::Client;
use tests::server::Server;
use tests::{program, wait};

/// Many robots in one arena, so that they share controllers; long enough to be killed in the middle.
fn spec(method: Value) -> Value {
    json!({
        "base": {
            "arena": { "from": "easy", "tile": [2, 2] }, "robots": 7, "placement": "grid",
            "controller": method, "epochs": 30, "steps_per_epoch": 200,
        },
        "seeds": [5],
    })
}

/// What a run found, but for its learners' state, which differs between methods.
fn findings(server: &Client, job: &Job) -> Vec<Vec<u8>> {
    let id = server.only_run(job).id;
    ["curve.csv", "metrics.csv", "coverage.npy", "dwell.npy"]
        .map(|file| {
            let answer = server.get(&format!("/v1/runs/{id}/{file}"));
            assert_eq!(answer.status, 200, "{file}");
            answer.body
        })
        .to_vec()
}

fn built_in(server: &Client) -> Vec<Vec<u8>> {
    let job = server.submit(&spec(json!({ "method": "braitenberg" })));
    server.wait_for(&job);
    findings(server, &job)
}

/// The example program, steering a run.
struct Steering(Child);

impl Steering {
    fn start(home: &Path, run: &str, number: usize) -> Self {
        let child = Command::new(program("examples/braitenberg"))
            .args([run, &number.to_string()])
            .env("XDG_RUNTIME_DIR", home)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        Self(child)
    }
}

impl Drop for Steering {
    fn drop(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

fn wait_for_state(server: &Client, job: &Job, state: State) -> Option<String> {
    wait::until(&format!("{state}"), || {
        let run = server.only_run(job);
        (run.state == state).then_some(run.error)
    })
}

#[test]
fn controllers_that_are_killed_and_come_back_give_the_bits_of_the_one_built_in() {
    let home = tempfile::tempdir().unwrap();
    let mut server = Server::start(home.path());
    let expected = built_in(&server);
    let method = json!({ "method": "external", "controllers": 2, "deadline_ms": 20_000 });
    let job = server.submit(&spec(method));
    let run = server.only_run(&job).id;
    // Nobody is there: the run holds no worker, and says what it waits for.
    let waits = wait_for_state(&server, &job, State::Paused).unwrap();
    assert!(waits.contains("controller 0 is not there"), "{waits}");

    let _first = Steering::start(home.path(), &run, 0);
    for round in 0..3 {
        let second = Steering::start(home.path(), &run, 1);
        let before = wait::until("steps", || {
            let run = server.only_run(&job);
            let steps = run.progress.map_or(0, |progress| progress.robot_steps_done);
            (run.state == State::Running && steps > 0 || run.state == State::Done).then_some(steps)
        });
        assert!(before > 0 || round > 0);
        std::thread::sleep(Duration::from_millis(100 * round));
        drop(second);
        if server.only_run(&job).state == State::Done {
            break;
        }
        let waits = wait_for_state(&server, &job, State::Paused).unwrap();
        assert!(waits.contains("controller 1"), "{waits}");
        if round == 1 {
            server.kill();
            server = Server::start(home.path());
        }
    }
    let _second = Steering::start(home.path(), &run, 1);
    server.wait_for(&job);
    assert!(findings(&server, &job) == expected, "other bits");
}

#[test]
fn answers_that_cannot_be_used_pause_the_run_until_somebody_says_so() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let expected = built_in(&server);
    let method = json!({ "method": "external", "deadline_ms": 20_000 });
    let job = server.submit(&spec(method));
    let run = server.only_run(&job).id;
    let root = home.path().join("evswarm");
    let mut wrong = Controller::open(&root, &run, 0).unwrap();
    // A second controller of the same robots is refused.
    assert!(Controller::open(&root, &run, 0).is_err());
    wait::until("a question", || {
        let asked = wrong.answer(Duration::from_secs(1), |asked, robots, commands| {
            assert_eq!((asked.arena_step, asked.epoch_step), (0, 0));
            assert_eq!((robots.len(), commands.len()), (7, 7));
            commands[3].left = f32::NAN;
        });
        asked.unwrap().then_some(())
    });
    let waits = wait_for_state(&server, &job, State::Paused).unwrap();
    assert!(
        waits.contains("left of command 3 is NaN (allowed: -1 to 1)"),
        "{waits}"
    );
    drop(wrong);
    let _right = Steering::start(home.path(), &run, 0);
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(server.only_run(&job).state, State::Paused, "nobody said so");
    let answer = server.send("POST", &format!("/v1/runs/{run}/resume"), &[], b"");
    assert_eq!(answer.status, 200);
    server.wait_for(&job);
    assert!(findings(&server, &job) == expected, "other bits");
    assert_eq!(server.only_run(&job).error, None);
}

#[test]
fn a_slow_controller_is_waited_for_until_its_deadline_and_tried_again() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let job = server.submit(&spec(json!({ "method": "external", "deadline_ms": 20 })));
    let run = server.only_run(&job).id;
    let mut slow = Controller::open(&home.path().join("evswarm"), &run, 0).unwrap();
    let mut steps = 0;
    // The third step takes longer than is allowed; then it is quick again, and the run goes on by
    // itself. The log has both.
    wait::until("the run to pause and go on", || {
        for _ in 0..100 {
            let answered = slow.answer(Duration::from_millis(20), |_, _, _| {
                steps += 1;
                std::thread::sleep(Duration::from_millis(if steps == 3 { 300 } else { 0 }));
            });
            answered.unwrap();
        }
        let log: Value = server.read(&format!("/v1/runs/{run}/log"));
        let log = log.to_string();
        let has = |what| log.contains(what);
        (has("did not answer within 20 ms") && has("its controllers are there")).then_some(())
    });
}

#[test]
fn a_run_that_is_steered_from_outside_records_itself_and_nothing_else_does() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let with_recording = |method: Value| {
        let mut job = spec(method);
        job["base"]["record"] = json!({ "every_steps": 4 });
        job
    };
    let built_in = server.submit(&with_recording(json!({ "method": "braitenberg" })));
    server.wait_for(&built_in);
    let method = json!({ "method": "external", "deadline_ms": 20_000 });
    let job = server.submit(&with_recording(method));
    let run = server.only_run(&job).id;
    let _steering = Steering::start(home.path(), &run, 0);
    server.wait_for(&job);
    let slice = |run: &str| -> RecordingSlice {
        server.read(&format!("/v1/runs/{run}/recording.json?every=100"))
    };
    let (steered, other) = (slice(&run), slice(&server.only_run(&built_in).id));
    assert_eq!(steered.recording.state, RecordingState::Done);
    assert_eq!(steered.step, other.step);
    for (a, b) in steered.robots.iter().zip(&other.robots) {
        assert_eq!((&a.poses, &a.left, &a.right), (&b.poses, &b.left, &b.right));
    }
    let recordings = format!("/v1/runs/{run}/recordings");
    let asked = server.post(&recordings, &json!({ "epochs": 1 }));
    let explained = server.get(&format!("/v1/runs/{run}/explain"));
    for answer in [asked, explained] {
        let problem = answer.problem(409);
        assert_eq!(problem.code, "not-repeatable");
        assert!(problem.detail.unwrap().contains("say `record` in the spec"));
    }
    // What was never recorded is said to be so for good.
    let plain = server.submit(&spec(json!({ "method": "external" })));
    let plain = server.only_run(&plain).id;
    let missing = server
        .get(&format!("/v1/runs/{plain}/recording"))
        .problem(404);
    assert!(missing.detail.unwrap().contains("say `record` in the spec"));
}

/// The commands that programs answered are in a recording: it takes their place.
#[test]
fn a_recording_of_the_answers_repeats_the_run_without_the_program() {
    let home = tempfile::tempdir().unwrap();
    let path = |name: &str| home.path().join(name);
    let run = |out: &str, spec: &Value, arguments: &[&str]| {
        std::fs::write(path("spec.json"), spec.to_string()).unwrap();
        Command::new(program("evswarm"))
            .args(["run", "spec.json", "--out", out])
            .args(arguments)
            .env("XDG_RUNTIME_DIR", home.path())
            .current_dir(home.path())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let mut steered = spec(json!({ "method": "external", "deadline_ms": 20_000 }))["base"].take();
    steered["seed"] = json!(5);
    steered["record"] = json!({ "every_steps": 1, "fields": ["command"] });
    let mut first = run("first", &steered, &["--external-name", "first"]);
    let steering = Steering::start(home.path(), "first", 0);
    assert!(wait::for_exit(&mut first).success());
    drop(steering);
    let recording = path("first/recording.evrec");
    let answers = ["--answers", recording.to_str().unwrap()];
    // It may be killed on the way, as any run.
    let mut killed = run("second", &steered, &answers);
    std::thread::sleep(Duration::from_millis(30));
    killed.kill().unwrap();
    killed.wait().unwrap();
    let mut second = run("second", &steered, &answers);
    assert!(wait::for_exit(&mut second).success());
    for entry in std::fs::read_dir(path("first")).unwrap() {
        let name = entry.unwrap().file_name();
        let read = |run: &str| std::fs::read(path(run).join(&name)).unwrap();
        assert!(
            name == "timing.json" || read("first") == read("second"),
            "{name:?} differs"
        );
    }
    // Without asking for a recording too: the answers are of the same run.
    let mut plain = steered.clone();
    plain["record"] = json!({ "every_steps": 0 });
    let mut third = run("third", &plain, &answers);
    assert!(wait::for_exit(&mut third).success());
    let visits = |run: &str| std::fs::read(path(run).join("visits.npy")).unwrap();
    assert!(visits("first") == visits("third"));

    let refused = |out: &str, spec: &Value, why: &str| {
        let ended = run(out, spec, &answers).wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(1), "{said}");
        assert!(said.contains(why), "{said}");
    };
    let mut other = steered.clone();
    other["seed"] = json!(6);
    refused("other", &other, "a recording of another run");
    let mut own = steered.clone();
    own["controller"] = json!({ "method": "braitenberg" });
    refused(
        "own",
        &own,
        "--answers is for runs with the method external",
    );
    // What was added to a recording was taken for what it lacks.
    let file = path("first").join("recording.evrec");
    let mut bytes = std::fs::read(&file).unwrap();
    bytes.extend(*b"12345");
    std::fs::write(&file, &bytes).unwrap();
    let why = "5 bytes that do not belong to it stand after its end";
    refused("longer", &steered, why);
    std::fs::write(&file, &bytes[..bytes.len() - 6]).unwrap();
    let why = "it has every command, but its index at the end of the file is cut";
    refused("shorter", &steered, why);
}
