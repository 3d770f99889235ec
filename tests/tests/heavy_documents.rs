//! Documents that are short to say and long to work on: many at once take turns, cost the memory of
//! a few, give it back, and shut nobody else out.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::Write;
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tests::http::Client;
use tests::server::Server;
use tests::{job, small_spec, wait};

/// Requests at once: more than may wait for their turn.
const CLIENTS: usize = 40;
/// Most that the server may hold meanwhile; without turns it is over twice that.
const MOST_BYTES: f64 = 0.8e9;
/// What it may keep afterwards; without giving back it is hundreds of megabytes.
const KEPT_BYTES: f64 = 150e6;

fn resident_bytes(server: &Server) -> f64 {
    let text = server.get("/metrics");
    let mut lines = text.text().lines();
    let value = lines.find_map(|line| line.strip_prefix("evswarm_memory_resident_bytes "));
    value.unwrap().parse().unwrap()
}

#[test]
fn many_heavy_documents_at_once_cost_the_memory_of_a_few_and_shut_nobody_out() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    // 23,000 walls in each of 10 runs.
    let heavy = json!({
        "base": {
            "arena": {
                "name": "long", "width_m": 1_000.0, "height_m": 0.5,
                "generate": { "kind": "rooms", "seed": 0 }
            },
            "controller": { "method": "brownian" }
        },
        "matrix": { "epochs": (1..=10).collect::<Vec<u32>>() }
    });
    let ended = AtomicBool::new(false);
    let (mut most_bytes, mut quickest) = (0.0_f64, Duration::MAX);
    let statuses: Vec<u16> = std::thread::scope(|scope| {
        let post = || {
            let client = Client::new(server.url());
            client.post("/v1/checks/job", &heavy).status
        };
        let clients: Vec<_> = (0..CLIENTS).map(|_| scope.spawn(post)).collect();
        let other = scope.spawn(|| {
            server.wait_for(&server.submit(&job(small_spec(), 2)));
            // Whatever the machine does, not after all of them.
            assert!(!ended.load(Ordering::SeqCst), "it had to wait");
        });
        while !clients.iter().all(|client| client.is_finished()) {
            let start = Instant::now();
            assert_eq!(Client::new(server.url()).get("/healthz").status, 200);
            quickest = quickest.min(start.elapsed());
            most_bytes = most_bytes.max(resident_bytes(&server));
            std::thread::sleep(Duration::from_millis(20));
        }
        ended.store(true, Ordering::SeqCst);
        other.join().unwrap();
        clients.into_iter().map(|c| c.join().unwrap()).collect()
    });
    assert!(quickest < Duration::from_millis(100), "{quickest:?}");
    assert!(most_bytes < MOST_BYTES, "{most_bytes}");
    assert!(statuses.iter().all(|status| [200, 503].contains(status)));
    assert!(statuses.iter().filter(|status| **status == 200).count() > CLIENTS / 2);
    assert!(
        statuses.contains(&503),
        "more waited than may: {statuses:?}"
    );
    wait::until("memory to be given back", || {
        (resident_bytes(&server) < KEPT_BYTES).then_some(())
    });
}

/// A job of one run with 10 MB of walls.
fn large() -> Value {
    json!({
        "base": {
            "arena": {
                "name": "large", "width_m": 50, "height_m": 50,
                "generate": { "kind": "maze", "seed": 1 }
            },
            "controller": { "method": "brownian" }, "epochs": 1, "steps_per_epoch": 1
        }
    })
}

#[test]
fn answers_that_nobody_reads_cost_the_memory_of_some_and_shut_nobody_out() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let posted = server.submit(&large());
    server.wait_for(&posted);
    let path = format!("/v1/runs/{}/spec", server.only_run(&posted).id);
    let address = server.url().strip_prefix("http://").unwrap();
    // All of it, and parts that are small enough not to be counted.
    let request = |number: usize| {
        let part = if number.is_multiple_of(2) {
            ""
        } else {
            "Range: bytes=0-65000\r\n"
        };
        format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{part}\r\n")
    };
    let mut most_bytes = 0.0_f64;
    let mut unread = Vec::new();
    for number in 0..200 {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(request(number).as_bytes()).unwrap();
        unread.push(stream);
        most_bytes = most_bytes.max(resident_bytes(&server));
    }
    let start = Instant::now();
    assert_eq!(server.get("/v1/jobs").status, 200);
    let took = start.elapsed();
    assert!(took < Duration::from_secs(5), "{took:?}");
    // Those that are still make room, so that others are answered.
    let part = [("range", "bytes=0-7999999")];
    let length = wait::until("an answer", || {
        most_bytes = most_bytes.max(resident_bytes(&server));
        let answer = server.send("GET", &path, &part, b"");
        (answer.status == 206).then(|| answer.text().len())
    });
    assert_eq!(length, 8_000_000);
    assert!(most_bytes < MOST_BYTES, "{most_bytes}");
}

#[test]
fn many_looks_at_a_run_with_a_large_spec_cost_the_memory_of_a_few() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    // Read again for each look.
    let posted = server.submit(&large());
    let small = server.submit(&job(small_spec(), 1));
    server.wait_for(&posted);
    server.wait_for(&small);
    let path = format!("/v1/runs/{}/curve", server.only_run(&posted).id);
    let (mut most_bytes, mut quickest) = (0.0_f64, Duration::MAX);
    let statuses: Vec<u16> = std::thread::scope(|scope| {
        let look = || Client::new(server.url()).get(&path).status;
        let clients: Vec<_> = (0..CLIENTS).map(|_| scope.spawn(look)).collect();
        while !clients.iter().all(|client| client.is_finished()) {
            let start = Instant::now();
            let summary = format!("/v1/jobs/{}/summary", small.id);
            assert_eq!(Client::new(server.url()).get(&summary).status, 200);
            quickest = quickest.min(start.elapsed());
            most_bytes = most_bytes.max(resident_bytes(&server));
            std::thread::sleep(Duration::from_millis(20));
        }
        clients.into_iter().map(|c| c.join().unwrap()).collect()
    });
    assert!(quickest < Duration::from_millis(500), "{quickest:?}");
    assert!(most_bytes < MOST_BYTES, "{most_bytes}");
    assert!(statuses.iter().all(|status| [200, 503].contains(status)));
    assert!(statuses.contains(&200), "{statuses:?}");
}

#[test]
fn a_text_that_would_take_a_hundred_times_its_length_is_refused_early() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let text = format!("{{\"base\": [{}]}}", vec![r#"{"a":1}"#; 500_000].join(","));
    let headers = [("content-type", "application/json")];
    let answer = server.send("POST", "/v1/jobs", &headers, text.as_bytes());
    let errors = answer.problem(400).errors;
    assert!(errors[0].message.contains("take more than"), "{errors:?}");
    assert!(resident_bytes(&server) < MOST_BYTES);
}
