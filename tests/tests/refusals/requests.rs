//! Requests that are wrong in form, or at the wrong time.

use api::Problem;
use serde_json::json;
use tests::command::evswarm;
use tests::server::Server;
use tests::{job, small_spec};

#[test]
fn wrong_requests_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let as_json = ("content-type", "application/json");
    let post = |headers: &[(&str, &str)], body: &[u8]| -> Problem {
        let answer = server.send("POST", "/v1/jobs", headers, body);
        answer.problem(answer.status)
    };
    for text in ["{", "", "nonsense", "{\"a\": 1,}", "\u{feff}{}"] {
        let out = home.path().join("out");
        let done = evswarm(&["run", "-", "--out", out.to_str().unwrap()], text);
        assert_eq!(done.code, Some(2), "{text:?}: {done:?}");
        assert!(done.stderr.starts_with("(document): not JSON"), "{done:?}");
        let problem = post(&[as_json], text.as_bytes());
        assert_eq!((problem.status, problem.errors.len()), (400, 1), "{text:?}");
    }
    assert_eq!(post(&[as_json], b"\xff\xfe").status, 400);
    assert_eq!(post(&[as_json], "[".repeat(100_000).as_bytes()).status, 400);
    assert_eq!(post(&[as_json], &vec![b' '; (4 << 20) + 1]).status, 413);
    assert_eq!(post(&[("content-type", "text/plain")], b"{}").status, 415);
    assert_eq!(
        post(&[as_json, ("origin", "http://example.org")], b"{}").status,
        403
    );
    assert_eq!(post(&[as_json, ("host", "example.org")], b"{}").status, 403);
    let own = server.url().to_owned();
    assert_eq!(post(&[as_json, ("origin", &own)], b"[]").status, 422);

    for query in ["limit=0", "limit=many", "cursor=-1"] {
        server.get(&format!("/v1/jobs?{query}")).problem(400);
    }
    let unknown = [
        "/v1/jobs/7",
        "/v1/jobs/x/runs",
        "/v1/runs/0123",
        "/v1/runs/0123/coverage.png",
        "/v1/arenas/nowhere",
        "/v1/arenas/nowhere.svg",
        "/v2",
        "/v1/jobs/%2e%2e",
    ];
    for path in unknown {
        server.get(path).problem(404);
    }
    server
        .send("PUT", "/v1/jobs", &[as_json], b"{}")
        .problem(405);
    server
        .send("POST", "/v1/runs/7", &[as_json], b"{}")
        .problem(405);
}

#[test]
fn what_contradicts_the_state_of_things_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut long = small_spec();
    long["epochs"] = json!(1_000_000);
    long["arena"] = json!({
        "name": "inline", "width_m": 0.5, "height_m": 0.5, "walls_m": [],
        "starts": [{ "x_m": 0.2, "y_m": 0.2, "heading_rad": 1.0 }]
    });
    let arena = long["arena"].clone();
    let running = server.submit(&job(long, 1));
    let run = server.only_run(&running).id;
    server.get(&format!("/v1/runs/{run}/result")).problem(409);
    let retry = format!("/v1/jobs/{}/retry", running.id);
    server.send("POST", &retry, &[], b"").problem(409);
    let long_chapter = json!({
        "base": { "epochs": 1_000_000, "arena": "easy" },
        "matrix": { "controller.method": server.methods() }
    });
    let chapter = server.submit(&long_chapter);
    server
        .get(&format!("/v1/jobs/{}/report.html", chapter.id))
        .problem(409);
    let path = format!("/v1/jobs/{}", chapter.id);
    assert_eq!(server.send("DELETE", &path, &[], b"").status, 204);
    let no_chapter = format!("/v1/jobs/{}/report", running.id);
    server.get(&no_chapter).problem(404);
    let done = server.wait_for(&server.submit(&job(small_spec(), 1)));
    server
        .send("POST", &format!("/v1/jobs/{}/cancel", done.id), &[], b"")
        .problem(409);
    let run = server.only_run(&done).id;
    server
        .send("POST", &format!("/v1/runs/{run}/cancel"), &[], b"")
        .problem(409);

    let mut room = arena;
    room["name"] = json!("room");
    assert_eq!(server.post("/v1/arenas", &room).status, 201);
    room["width_m"] = json!(0.7);
    server.post("/v1/arenas", &room).problem(409);
    room["name"] = json!("maze");
    server.post("/v1/arenas", &room).problem(409);
    let mut user = small_spec();
    user["arena"] = json!("room");
    server.wait_for(&server.submit(&job(user, 1)));
    server
        .send("DELETE", "/v1/arenas/room", &[], b"")
        .problem(409);
    server
        .send("DELETE", "/v1/arenas/maze", &[], b"")
        .problem(409);
}

#[test]
fn a_server_with_a_token_asks_for_it() {
    let home = tempfile::tempdir().unwrap();
    let token = "sixteen characters or more";
    let server = Server::start_with(home.path(), &["--token", token]);
    server.get("/v1/jobs").problem(401);
    let with = |value: &str| server.send("GET", "/v1/jobs", &[("authorization", value)], b"");
    with("Bearer wrong").problem(401);
    assert_eq!(with(&format!("Bearer {token}")).status, 200);
    assert_eq!(server.get("/health/livez").status, 200);
}
