//! The README's table of what is refused and how: every row, over HTTP and by `evswarm run`.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use api::{FieldError, Problem};
use serde_json::{Value, json};
use tests::command::evswarm;
use tests::server::Server;
use tests::{job, readme, small_spec};

/// Run specs that are wrong: the row of the table, the field to set (as a JSON pointer), its value,
/// the pointer that the error must have, and words of its message.
type Wrong = (
    &'static str,
    &'static str,
    Value,
    &'static str,
    &'static str,
);

fn wrong_specs() -> Vec<Wrong> {
    let unknown = "a field that does not exist (the nearest name is told)";
    let range = "a number out of range or a value of the wrong kind";
    let name = "an unknown arena, method, preset, engine or placement";
    let arena = "an arena with a wall outside it or a start inside a wall";
    let later = "memory budgets, sharing, recording (not built yet)";
    let room = |wall: Value, x_m: f64| {
        json!({
            "name": "room", "width_m": 0.6, "height_m": 0.6, "walls_m": [wall],
            "starts": [{ "x_m": x_m, "y_m": 0.3, "heading_rad": 0.0 }]
        })
    };
    vec![
        (
            unknown,
            "/epcohs",
            json!(1),
            "/epcohs",
            "did you mean \"epochs\"?",
        ),
        (
            unknown,
            "/controller/alhpa",
            json!(1),
            "/controller/alhpa",
            "\"alpha\"?",
        ),
        (
            unknown,
            "/robot/axel_m",
            json!(1),
            "/robot/axel_m",
            "\"axle_m\"?",
        ),
        (
            unknown,
            "/arena",
            json!({ "nmae": "x" }),
            "/arena/nmae",
            "\"name\"?",
        ),
        (range, "/epochs", json!(0), "/epochs", "0 is not"),
        (range, "/epochs", json!(-3), "/epochs", "-3 is not"),
        (range, "/epochs", json!(1e300), "/epochs", "is not"),
        (
            range,
            "/steps_per_epoch",
            json!(2.5),
            "/steps_per_epoch",
            "2.5 is not",
        ),
        (range, "/robots", json!(100_001), "/robots", "100001 is not"),
        (range, "/robots", json!("two"), "/robots", "not a string"),
        (
            range,
            "/seed",
            json!(9_007_199_254_740_993_u64),
            "/seed",
            "is not",
        ),
        (range, "/seed", json!(null), "/seed", "not null"),
        (range, "/schema", json!(2), "/schema", "2 is not"),
        (
            range,
            "/controller",
            json!([]),
            "/controller",
            "not an array",
        ),
        (
            range,
            "/controller/alpha",
            json!(1.5),
            "/controller/alpha",
            "",
        ),
        (
            range,
            "/controller/lambda",
            json!(true),
            "/controller/lambda",
            "truth value",
        ),
        (
            range,
            "/robot/body_radius_m",
            json!(-1),
            "/robot/body_radius_m",
            "",
        ),
        (
            range,
            "/channels",
            json!("yes"),
            "/channels",
            "not a string",
        ),
        (
            name,
            "/arena",
            json!("mase"),
            "/arena",
            "did you mean \"maze\"?",
        ),
        (
            name,
            "/arena",
            json!("../easy"),
            "/arena",
            "there is no arena",
        ),
        (
            name,
            "/controller/method",
            json!("browian"),
            "/controller/method",
            "\"brownian\"?",
        ),
        (
            name,
            "/robot/preset",
            json!("e-puck3"),
            "/robot/preset",
            "there is no preset",
        ),
        (
            name,
            "/engine",
            json!("box2d"),
            "/engine",
            "there is no engine",
        ),
        (
            name,
            "/placement",
            json!("circle"),
            "/placement",
            "there is no placement",
        ),
        (
            name,
            "/episodes",
            json!(""),
            "/episodes",
            "there is no episodes",
        ),
        (
            arena,
            "/arena",
            room(json!([0.1, 0.1, 0.7, 0.1]), 0.3),
            "/arena/walls_m/0",
            "leaves",
        ),
        (
            arena,
            "/arena",
            room(json!([0.1, 0.1, 0.1, 0.1]), 0.3),
            "/arena/walls_m/0",
            "0 m long",
        ),
        (
            arena,
            "/arena",
            room(json!([0.3, 0.0, 0.3, 0.6]), 0.31),
            "/arena/starts/0",
            "",
        ),
        (
            arena,
            "/arena",
            room(json!([0.3, 0.0, 0.3, 0.6]), 0.61),
            "/arena/starts/0",
            "outside",
        ),
        (
            arena,
            "/arena",
            room(json!([0.1, 0.1, 0.1]), 0.3),
            "/arena/walls_m/0",
            "",
        ),
        (
            "more robots than the arena has start poses",
            "/robots",
            json!(5),
            "/robots",
            "1 start poses for 5 robots",
        ),
        (
            "a robot that moves too far in a step for its size",
            "/robot/body_radius_m",
            json!(0.005),
            "/robot/max_wheel_speed_rad_s",
            "too far",
        ),
        (
            "training for a method that has none",
            "/controller/train",
            json!({ "epochs": 3 }),
            "/controller/train",
            "brownian has no training",
        ),
        (
            later,
            "/memory_budget_bytes",
            json!(8_192),
            "/memory_budget_bytes",
            "not supported",
        ),
        (
            later,
            "/sharing",
            json!({ "mode": "radio" }),
            "/sharing/mode",
            "not supported",
        ),
        (
            later,
            "/record",
            json!({ "every_steps": 5 }),
            "/record/every_steps",
            "not supported",
        ),
    ]
}

/// Sets a field, whose parent is made if it is missing.
fn set(document: &mut Value, pointer: &str, value: Value) {
    let mut place = document;
    for name in pointer.split('/').skip(1) {
        place = &mut place[name];
    }
    *place = value;
}

fn has(errors: &[FieldError], pointer: &str, words: &str) -> bool {
    errors.iter().any(|error| {
        error.pointer == pointer && error.message.contains(words) && !error.allowed.is_empty()
    })
}

#[test]
fn wrong_specs_are_refused_by_the_service_and_by_the_command() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    for (row, field, value, pointer, words) in wrong_specs() {
        let mut spec = small_spec();
        set(&mut spec, field, value);
        let told = format!("{row}: {spec}");

        let out = home.path().join("out");
        let done = evswarm(
            &["run", "-", "--out", out.to_str().unwrap()],
            &spec.to_string(),
        );
        assert_eq!(done.code, Some(2), "{told}: {done:?}");
        let line = format!("{pointer}: ");
        let found = done
            .stderr
            .lines()
            .any(|l| l.starts_with(&line) && l.contains(words));
        assert!(found, "{told}: {done:?}");
        assert!(
            !out.exists() && !home.path().join("out.partial").exists(),
            "{told}"
        );

        let seed = spec.as_object_mut().unwrap().remove("seed").unwrap();
        let posted = if field == "/seed" {
            json!({ "base": { "seed": seed } })
        } else {
            job(spec, 1)
        };
        let problem = server.post("/v1/jobs", &posted).problem(422);
        assert!(
            has(&problem.errors, &format!("/base{pointer}"), words),
            "{told}: {problem:?}"
        );
    }
    let jobs: Value = server.read("/v1/jobs");
    assert_eq!(jobs["items"], json!([]));
}

#[test]
fn all_wrong_fields_are_told_at_once() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let wrong = json!({
        "nmae": "x",
        "base": { "epochs": -1, "arena": "nowhere", "controller": { "alpha": 7 } },
        "matrix": { "robots": [1, 0] }, "seeds": { "first": 1, "count": 0 }
    });
    let problem = server.post("/v1/jobs", &wrong).problem(422);
    let first = ["/nmae", "/seeds/count"];
    assert!(
        first
            .iter()
            .all(|pointer| has(&problem.errors, pointer, "")),
        "{problem:?}"
    );
    let mut rest = wrong;
    rest["seeds"]["count"] = json!(1);
    let problem = server.post("/v1/jobs", &rest).problem(422);
    for pointer in [
        "/nmae",
        "/base/epochs",
        "/base/arena",
        "/base/controller/alpha",
        "/matrix/robots/1",
    ] {
        assert!(has(&problem.errors, pointer, ""), "{pointer}: {problem:?}");
    }
}

#[test]
fn wrong_jobs_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let cases = [
        (
            json!({ "matrix": { "controller..alpha": [1] } }),
            "/matrix/controller..alpha",
        ),
        (
            json!({ "matrix": { "epochs.x": [1] }, "base": { "epochs": 3 } }),
            "/matrix/epochs.x",
        ),
        (json!({ "matrix": { "epohcs": [1] } }), "/matrix/epohcs/0"),
        (json!({ "matrix": { "epochs": [] } }), "/matrix/epochs"),
        (json!({ "matrix": { "epochs": 3 } }), "/matrix/epochs"),
        (
            json!({ "matrix": { "epochs": [3, 3] } }),
            "/matrix/epochs/1",
        ),
        (json!({ "matrix": { "seed": [1, 2] } }), "/matrix/seed"),
        (json!({ "seeds": [1, 2, 1] }), "/seeds/2"),
        (json!({ "seeds": [] }), "/seeds"),
        (json!({ "seeds": 3 }), "/seeds"),
        (json!({ "seeds": [1], "base": { "seed": 1 } }), "/base/seed"),
        (
            json!({ "seeds": { "first": 1, "count": 100_001 } }),
            "/seeds/count",
        ),
        (
            json!({ "seeds": { "first": 1, "count": 100_000 }, "matrix": { "epochs": [1, 2] } }),
            "",
        ),
        (json!({ "template": "chapter-55" }), "/template"),
        (json!({ "name": "x".repeat(201) }), "/name"),
        (json!([]), ""),
    ];
    for (wrong, pointer) in cases {
        let problem = server.post("/v1/jobs", &wrong).problem(422);
        assert!(has(&problem.errors, pointer, ""), "{wrong}: {problem:?}");
    }

    let keyed = |body: &Value| {
        let headers = [
            ("content-type", "application/json"),
            ("idempotency-key", "a key"),
        ];
        server.send("POST", "/v1/jobs", &headers, body.to_string().as_bytes())
    };
    let first = keyed(&job(small_spec(), 1));
    assert_eq!(first.status, 201);
    let again = keyed(&job(small_spec(), 1));
    assert_eq!(again.header("location"), first.header("location"));
    keyed(&job(small_spec(), 2)).problem(422);
}

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
        "name": "inline", "width_m": 0.5, "height_m": 0.5,
        "starts": [{ "x_m": 0.2, "y_m": 0.2, "heading_rad": 1.0 }]
    });
    let arena = long["arena"].clone();
    let running = server.submit(&job(long, 1));
    let run = server.only_run(&running).id;
    server.get(&format!("/v1/runs/{run}/result")).problem(409);
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

#[test]
fn commands_that_cannot_work_end_with_1() {
    let home = tempfile::tempdir().unwrap();
    let path = |name: &str| home.path().join(name).to_str().unwrap().to_owned();
    let failed = |arguments: &[&str], input: &str, words: &str| {
        let done = evswarm(arguments, input);
        assert_eq!(done.code, Some(1), "{arguments:?}: {done:?}");
        assert!(done.stderr.contains(words), "{arguments:?}: {done:?}");
    };
    let (spec, out) = (small_spec().to_string(), path("out"));
    failed(
        &["run", &path("missing.json"), "--out", &out],
        "",
        "cannot read",
    );
    failed(&["run", &path(""), "--out", &out], "", "cannot read");
    std::fs::create_dir(path("full")).unwrap();
    std::fs::write(path("full/notes.txt"), "mine").unwrap();
    failed(&["run", "-", "--out", &path("full")], &spec, "not empty");
    assert_eq!(std::fs::read(path("full/notes.txt")).unwrap(), b"mine");
    failed(
        &["run", "-", "--out", &path("full/notes.txt")],
        &spec,
        "directory",
    );
    assert_eq!(evswarm(&["run", "-", "--out", &out], &spec).code, Some(0));
    let mut other = small_spec();
    other["seed"] = json!(2);
    failed(
        &["run", "-", "--out", &out],
        &other.to_string(),
        "another spec",
    );
    failed(&["run"], "", "--out");
    let data = path("data");
    let listen = |at: &'static str| ["serve", "--listen", at, "--data", &data].map(str::to_owned);
    for at in ["0.0.0.0:0", "[::]:0"] {
        let arguments = listen(at);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        failed(&arguments, "", "set a token");
    }
}

#[test]
fn every_row_of_the_readme_is_tested() {
    let here: BTreeSet<&str> = wrong_specs().into_iter().map(|wrong| wrong.0).collect();
    let elsewhere = [
        // The tests of this file.
        ("text that is not JSON", "400", "2"),
        (
            "a matrix with a wrong path, no value or twice the same run",
            "422",
            "",
        ),
        (
            "a seed twice, or seeds beside a seed in the base run",
            "422",
            "",
        ),
        ("a job of more than 100,000 runs", "422", ""),
        ("an idempotency key used for another body", "422", ""),
        ("a body of more than 4 MiB", "413", ""),
        ("a body that is not said to be JSON", "415", ""),
        ("a page size or cursor that makes no sense", "400", ""),
        (
            "a missing or wrong token, where the server has one",
            "401",
            "",
        ),
        (
            "another host's name, or a change asked for by another site's page",
            "403",
            "",
        ),
        ("an unknown job, run, arena or route", "404", ""),
        ("a method that a route does not have", "405", ""),
        (
            "the result of an unfinished run, or cancelling a finished one",
            "409",
            "",
        ),
        (
            "an arena whose name is taken, or deleting one in use",
            "409",
            "",
        ),
        (
            "a spec that cannot be read, or an output directory that holds something else",
            "",
            "1",
        ),
        (
            "listening beyond this machine without a token (`evswarm serve`)",
            "",
            "1",
        ),
        // The service's own tests, with a smaller limit.
        (
            "more than 200,000 unfinished runs (`Retry-After` is given)",
            "429",
            "",
        ),
    ];
    let expected: BTreeSet<(&str, &str, &str)> = here
        .into_iter()
        .map(|row| (row, "422", "2"))
        .chain(elsewhere)
        .collect();
    let table = readme::table("What is refused, and how");
    let told: BTreeSet<(&str, &str, &str)> = table
        .iter()
        .map(|row| (&*row[0], &*row[1], &*row[2]))
        .collect();
    assert_eq!(told, expected);
}
