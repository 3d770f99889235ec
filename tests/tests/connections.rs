//! Clients that keep still: they shut nobody else out, and are sent away in time.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use tests::http::Client;
use tests::refusals::row;
use tests::server::Server;
use tests::{job, small_spec};

/// Time within which the server says that it lives.
const PROMPT: Duration = Duration::from_millis(100);
/// Looks at how long that takes; one of them must be prompt, as the machine has other work too.
const LOOKS: usize = 5;

fn connect(server: &Server) -> TcpStream {
    let address = server.url().strip_prefix("http://").unwrap();
    let stream = TcpStream::connect(address).unwrap();
    let patience = Some(Duration::from_secs(30));
    stream.set_read_timeout(patience).unwrap();
    stream
}

/// What the server sends until it ends the connection; nothing if it breaks it off.
fn rest(mut stream: TcpStream) -> String {
    let mut text = Vec::new();
    match stream.read_to_end(&mut text) {
        Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {
            panic!("the connection stays open")
        }
        _ => String::from_utf8(text).unwrap(),
    }
}

/// The server answers others: that it lives at once, everything else soon, a job to its end.
fn assert_serves_others(server: &Server) {
    let took = |path: &str| {
        let start = Instant::now();
        // A client of its own has a connection of its own.
        assert_eq!(Client::new(server.url()).get(path).status, 200, "{path}");
        start.elapsed()
    };
    for path in ["/health/livez", "/healthz"] {
        let fastest = (0..LOOKS).map(|_| took(path)).min().unwrap();
        assert!(fastest < PROMPT, "{path} takes {fastest:?}");
    }
    for path in ["/health/readyz", "/readyz", "/v1/jobs", "/"] {
        took(path);
    }
    server.wait_for(&server.submit(&job(small_spec(), 2)));
}

#[test]
fn silent_connections_shut_nobody_out() {
    let limits = getrlimit(Resource::Nofile);
    let all = Rlimit {
        current: limits.maximum,
        maximum: limits.maximum,
    };
    setrlimit(Resource::Nofile, all).unwrap();
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut silent: Vec<TcpStream> = (0..1_100).map(|_| connect(&server)).collect();
    assert_serves_others(&server);
    // The first ones gave way.
    assert_eq!(rest(silent.remove(0)), "");
    // Runs are checkpointed with all of them open.
    let mut long = small_spec();
    long["epochs"] = 1_000_000.into();
    let running = server.submit(&job(long, 2));
    let pause = format!("/v1/jobs/{}/pause", running.id);
    assert_eq!(server.send("POST", &pause, &[], b"").status, 200);
    assert_serves_others(&server);
    drop(silent);
    server.terminate();
    let log = std::fs::read_to_string(home.path().join("server.log")).unwrap();
    assert!(!log.contains("cannot be"), "{log}");
}

#[test]
fn half_requests_hold_nobody_up_and_are_sent_away_in_time() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let start = Instant::now();
    let send = |text: &str| {
        let mut stream = connect(&server);
        stream.write_all(text.as_bytes()).unwrap();
        stream
    };
    let half_body = "POST /v1/jobs HTTP/1.1\r\nhost: localhost\r\n\
        content-type: application/json\r\ncontent-length: 1000\r\n\r\n{";
    let mut bodies: Vec<TcpStream> = (0..130).map(|_| send(half_body)).collect();
    let head = send("GET /v1/jobs HTTP/1.1\r\nhost: loc");
    assert_serves_others(&server);
    let answer = rest(bodies.remove(0));
    let code = row("a body that takes too long to come").problem.unwrap();
    let line = format!("HTTP/1.1 {} ", code.status());
    assert!(answer.starts_with(&line), "{answer}");
    assert!(answer.contains(code.code()), "{answer}");
    assert_eq!(rest(head), "");
    let took = start.elapsed();
    assert!(took > Duration::from_secs(9), "{took:?}");
}

#[test]
fn an_announced_length_over_the_limit_is_refused_at_once() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut stream = connect(&server);
    let head = "POST /v1/jobs HTTP/1.1\r\nhost: localhost\r\n\
        content-type: application/json\r\ncontent-length: 4194305\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"HTTP/1.1 413");
}
