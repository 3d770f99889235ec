//! What may happen to recordings: crashes, damage, a full disk, wrong questions.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;

use api::recording::{RecordingList, RecordingSlice, RecordingState};
use serde_json::{Value, json};
use tests::server::Server;
use tests::wait;

use super::{one_run, recorded_afterwards, wait_for_recording, with};

fn swarm() -> Value {
    json!({
        "arena": "easy", "robots": 3, "placement": "grid", "sharing": { "mode": "arena" },
        "controller": { "method": "ev-iter-c", "train": { "arena": "easy", "epochs": 20 } },
        "epochs": 1_500, "steps_per_epoch": 1_000,
    })
}

#[test]
fn a_recording_that_is_asked_for_survives_a_crash_and_goes_with_its_run() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let job = server.submit(&one_run(&with(swarm(), "epochs", json!(200))));
    server.wait_for(&job);
    let id = server.only_run(&job).id;
    let path = format!("/v1/runs/{id}/recordings");
    let asked = server.post(
        &path,
        &json!({ "every_steps": 1, "robots": [2], "epochs": 100 }),
    );
    assert_eq!(asked.status, 201, "{}", asked.text());
    let location = asked.header("location").to_owned();
    server.kill();
    let server = Server::start(home.path());
    let made = wait_for_recording(&server, &path);
    assert_eq!((made.state, made.epochs), (RecordingState::Done, 100));
    let slice: RecordingSlice = server.read(&format!("{location}.json?steps=3"));
    assert_eq!(slice.step, [0, 1, 2]);
    assert_eq!(slice.robots[0].robot, 2);
    let wrong = [
        (json!({ "from_epoch": 2_000 }), "/from_epoch"),
        (json!({ "robots": [3] }), "/robots/0"),
        (json!({ "every_steps": 0 }), "/every_steps"),
        (json!({ "every_step": 1 }), "/every_step"),
    ];
    for (document, pointer) in wrong {
        let problem = server.post(&path, &document).problem(422);
        assert_eq!(problem.errors[0].pointer, pointer, "{problem:?}");
    }
    assert_eq!(
        server
            .send("DELETE", &format!("/v1/runs/{id}"), &[], b"")
            .status,
        204
    );
    let folder = home.path().join(format!("data/recordings/{id}"));
    wait::until("the folder to go", || (!folder.exists()).then_some(()));
}

/// A run of a few robots that is done, with all of it recorded.
fn recorded(server: &Server, home: &std::path::Path) -> (String, PathBuf) {
    let spec = json!({
        "arena": "easy", "robots": 3, "placement": "grid", "controller": { "method": "brownian" },
        "epochs": 45, "steps_per_epoch": 1_000,
    });
    let job = server.submit(&one_run(&spec));
    server.wait_for(&job);
    let run = server.only_run(&job).id;
    let location = recorded_afterwards(server, &run, &json!({ "fields": ["pose"] }));
    let file = home.join("data/recordings").join(&run).join("1.evrec");
    assert!(file.is_file());
    (location, file)
}

#[test]
fn odd_questions_are_answered_or_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let (location, _) = recorded(&server, home.path());
    let slice =
        |query: &str| -> RecordingSlice { server.read(&format!("{location}.json?{query}")) };
    // Beyond the end there is nothing.
    for query in [
        "from_step=45001",
        "from_step=9223372036854775807",
        "from_step=9223372036854775807&steps=9223372036854775807",
        "from_step=45001&every=9223372036854775807",
    ] {
        let beyond = slice(query);
        assert_eq!((beyond.step.len(), beyond.next_step), (0, None), "{query}");
        assert_eq!(beyond.recording.to_step, 45_001);
    }
    assert_eq!(slice("from_step=45000").step, [45_000]);
    assert_eq!(slice("every=9223372036854775807").step, [0]);
    let many = vec!["2"; 1_000].join(",");
    assert_eq!(slice(&format!("steps=2&robots={many}")).robots.len(), 1_000);
    let too_many = vec!["2"; 1_001].join(",");
    for query in [
        "robots=",
        "robots=1,",
        "robots=-1",
        "robots=3",
        "robots=0x1",
        "robots=4294967296",
        "robots=all",
        &format!("robots={too_many}"),
        "steps=0",
        "every=0",
        "from_step=-1",
        "from_step=1e3",
        "robot=1",
    ] {
        let problem = server.get(&format!("{location}.json?{query}")).problem(400);
        assert_eq!(problem.code, "invalid-query", "{query}: {problem:?}");
    }
    for name in [
        "live",
        "2",
        "0",
        "-1",
        "1e0",
        "18446744073709551616",
        "1.evrec",
        "..",
        "1.jsonx",
    ] {
        let path = format!("{}/{name}", location.strip_suffix("/1").unwrap());
        let answer = server.get(&path);
        assert_eq!(answer.status, 404, "{path}: {}", answer.text());
    }
    // Lists of robots of odd kinds.
    let path = location.strip_suffix("/1").unwrap();
    for robots in [
        json!([]),
        json!([1, 1]),
        json!([[1]]),
        json!([-1]),
        json!([0.5]),
        json!(["1"]),
        json!([4_294_967_296_u64]),
        json!({ "first": 1 }),
        json!("some"),
        json!(0),
        json!(4),
        json!(-1),
        json!(1.5),
        json!(true),
        json!(null),
        json!(vec![0; 100_000]),
    ] {
        let problem = server.post(path, &json!({ "robots": robots })).problem(422);
        let pointer = &problem.errors[0].pointer;
        assert!(pointer.starts_with("/robots"), "{robots}: {problem:?}");
        assert!(problem.errors.len() <= 101);
    }
    // Out of order is in order.
    let location = recorded_afterwards(&server, run_of(path), &json!({ "robots": [2, 0] }));
    let slice: RecordingSlice = server.read(&format!("{location}.json?steps=1"));
    assert_eq!(slice.recording.robot_numbers, Some(vec![0, 2]));
}

/// The run whose recordings are at a path.
fn run_of(path: &str) -> &str {
    path.split('/').nth(3).unwrap()
}

#[test]
fn a_recording_that_was_damaged_or_cut_is_read_as_far_as_it_goes() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let (location, file) = recorded(&server, home.path());
    let whole = fs::read(&file).unwrap();
    let all = server.get(&format!("{location}.csv")).body;
    let reader = recording::Reader::open(fs::File::open(&file).unwrap()).unwrap();
    let offsets = reader.blocks().0.to_vec();
    assert!(offsets.len() >= 3);
    let slice = |query: &str| server.get(&format!("{location}.json?{query}"));

    // A byte in the middle block: its stretch is refused, the rest is read.
    let mut flipped = whole.clone();
    flipped[offsets[1] as usize + 500] ^= 0x10;
    fs::write(&file, &flipped).unwrap();
    slice("steps=10").json::<RecordingSlice>();
    slice("from_step=44990").json::<RecordingSlice>();
    assert_eq!(
        slice("from_step=30000&steps=10").problem(500).code,
        "damaged"
    );
    // A table breaks off: a client is not told that it was whole.
    let (answer, ended) = raw(&server, &format!("{location}.csv"));
    assert!(!ended && answer.len() < all.len(), "{} bytes", answer.len());

    // Cut anywhere, it is read up to its last whole block, in every form.
    for length in [
        offsets[2] as usize + 10,
        offsets[1] as usize,
        whole.len() - 1,
    ] {
        fs::write(&file, &whole[..length]).unwrap();
        let begun: RecordingSlice = slice("steps=10").json();
        assert_eq!(begun.step.len(), 10, "{length}");
        let part = server.get(&format!("{location}.csv")).body;
        assert!(all.starts_with(&part) && part.len() > 1_000, "{length}");
        assert!(
            server
                .get(&format!("{location}.parquet"))
                .body
                .ends_with(b"PAR1")
        );
    }
    let (mcap, ended) = raw(&server, &format!("{location}.mcap"));
    assert!(ended && mcap.starts_with(b"HTTP/1.1 200 OK"));
    // Without a whole header, or with a changed one, it is damaged and nothing else.
    for bytes in [
        &whole[..0],
        &whole[..7],
        &whole[..40],
        &b"EVSWREC2\xff\xff\xff\xff"[..],
    ] {
        fs::write(&file, bytes).unwrap();
        for end in [".json", ".csv", ".parquet", ".mcap"] {
            let problem = server.get(&format!("{location}{end}")).problem(500);
            assert_eq!(problem.code, "damaged");
        }
        assert_eq!(server.get(&location).body, bytes);
    }
    assert_eq!(server.get("/health/livez").status, 200);
}

/// What a server answers, byte for byte, and whether it said that this is the end.
fn raw(server: &Server, path: &str) -> (Vec<u8>, bool) {
    let host = server.url().strip_prefix("http://").unwrap();
    let mut stream = TcpStream::connect(host).unwrap();
    write!(
        stream,
        "GET {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n"
    )
    .unwrap();
    let mut answer = Vec::new();
    // A connection that is reset has not ended well either.
    let closed = stream.read_to_end(&mut answer);
    let ended = closed.is_ok() && answer.ends_with(b"0\r\n\r\n");
    (answer, ended)
}

#[test]
fn a_recording_that_is_deleted_while_it_is_read_is_read_to_its_end() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let (location, file) = recorded(&server, home.path());
    let all = server.get(&format!("{location}.csv")).body;
    let host = server.url().strip_prefix("http://").unwrap().to_owned();
    let mut stream = TcpStream::connect(&host).unwrap();
    write!(
        stream,
        "GET {location}.csv HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n"
    )
    .unwrap();
    let mut begin = vec![0; 1_000];
    stream.read_exact(&mut begin).unwrap();
    assert_eq!(server.send("DELETE", &location, &[], b"").status, 204);
    assert!(!file.exists());
    let mut rest = Vec::new();
    stream.read_to_end(&mut rest).unwrap();
    assert!(rest.ends_with(b"0\r\n\r\n") && begin.len() + rest.len() > all.len());
    server
        .get(&location)
        .refused("a recording that is not there");
    // One that is being made is given up.
    let path = location.strip_suffix("/1").unwrap();
    let long = server.submit(&one_run(&with(swarm(), "epochs", json!(3_000))));
    let run = server.only_run(&long).id;
    let path = path.replace(run_of(path), &run);
    assert_eq!(
        server.post(&path, &json!({ "every_steps": 10 })).status,
        201
    );
    wait::until("it is being made", || {
        let list: RecordingList = server.read(&path);
        (list.items[0].state == RecordingState::Recording).then_some(())
    });
    let made = format!("{path}/1");
    assert_eq!(server.send("DELETE", &made, &[], b"").status, 204);
    let list: RecordingList = server.read(&path);
    assert!(list.items.is_empty());
    let folder = home.path().join("data/recordings").join(&run);
    assert_eq!(fs::read_dir(folder).unwrap().count(), 0);
}

#[test]
fn a_run_goes_on_whose_recording_was_given_up_and_deleted() {
    let home = tempfile::tempdir().unwrap();
    // The limit is lowered while the run is under way.
    let small = ["--run-recordings-bytes", "1000000"];
    let server = Server::start(home.path());
    let spec = json!({
        "arena": "easy", "robots": 4, "placement": "grid", "controller": { "method": "brownian" },
        "epochs": 300_000, "steps_per_epoch": 10, "record": { "every_steps": 10, "fields": ["pose"] },
    });
    let job = server.submit(&one_run(&spec));
    let run = server.only_run(&job).id;
    let live = format!("/v1/runs/{run}/recordings/live");
    let list = format!("/v1/runs/{run}/recordings");
    let is_cut = |server: &Server| {
        let list: RecordingList = server.read(&list);
        list.items
            .first()
            .is_some_and(|first| first.state == RecordingState::Cut)
    };
    wait::until("the run to begin", || {
        (server.only_run(&job).state == api::State::Running).then_some(())
    });
    assert!(server.terminate().success());
    let server = Server::start_with(home.path(), &small);
    wait::until("the recording to be given up", || {
        is_cut(&server).then_some(())
    });
    let steps = |server: &Server| {
        let run = server.only_run(&job);
        run.progress
            .map_or(u64::MAX, |progress| progress.robot_steps_done)
    };
    let before = steps(&server);
    assert!(before > 0);
    assert_eq!(server.send("DELETE", &live, &[], b"").status, 204);
    server.get(&live).refused("a recording that is not there");
    assert!(server.terminate().success());
    let server = Server::start_with(home.path(), &small);
    wait::until("a worker", || {
        (server.only_run(&job).state != api::State::Queued).then_some(())
    });
    // It goes on from its checkpoint, and does not record again.
    assert!(steps(&server) >= before, "it began again");
    server.wait_for(&job);
    server.get(&live).refused("a recording that is not there");
}

#[test]
fn a_recording_does_not_fill_the_disk_that_results_are_stored_on() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_on_a_small_disk(home.path(), 16 << 20);
    // About 20 MB, of which 14 fit.
    let spec = json!({
        "arena": "easy", "robots": 10, "placement": "grid", "controller": { "method": "brownian" },
        "epochs": 220, "steps_per_epoch": 1_000, "record": { "every_steps": 1 },
    });
    let job = server.submit(&one_run(&spec));
    server.wait_for(&job);
    let run = server.only_run(&job);
    assert_eq!(run.state, api::State::Done, "{run:?}");
    let slice: RecordingSlice = server.read(&format!("/v1/runs/{}/recording.json?steps=3", run.id));
    assert_eq!(slice.recording.state, RecordingState::Cut);
    assert_eq!(slice.step, [0, 1, 2]);
    let log = fs::read_to_string(home.path().join("server.log")).unwrap();
    assert!(log.contains("the disk has hardly any room left"), "{log}");
}
