//! Requests that are wrong in form, or at the wrong time.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;

use api::{ProblemCode, State};
use serde_json::{Value, json};
use tests::command::evswarm;
use tests::http::Answer;
use tests::refusals::row;
use tests::server::Server;
use tests::{job, small_spec, wait};

#[test]
fn wrong_requests_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let as_json = ("content-type", "application/json");
    let post = |headers: &[(&str, &str)], body: &[u8]| -> Answer {
        server.send("POST", "/v1/jobs", headers, body)
    };
    let not_json = "text that is not JSON";
    for text in ["{", "", "nonsense", "{\"a\": 1,}", "{\u{feff}}"] {
        let out = home.path().join("out");
        let done = evswarm(&["run", "-", "--out", out.to_str().unwrap()], text);
        assert_eq!(
            done.code,
            row(not_json).exit.map(i32::from),
            "{text:?}: {done:?}"
        );
        assert!(done.stderr.starts_with("(document): not JSON"), "{done:?}");
        let problem = post(&[as_json], text.as_bytes()).refused(not_json);
        assert_eq!(problem.errors.len(), 1, "{text:?}");
    }
    post(&[as_json], b"\xff\xfe").refused(not_json);
    let key = "a key that stands in its object twice";
    let twice = r#"{"arena": "easy", "epochs": 1, "epochs": 2}"#;
    let out = home.path().join("out");
    let done = evswarm(&["run", "-", "--out", out.to_str().unwrap()], twice);
    assert_eq!(done.code, row(key).exit.map(i32::from), "{done:?}");
    assert!(done.stderr.starts_with("/epochs: the key"), "{done:?}");
    let twice = r#"{"base": {}, "matrix": {"epochs": [1], "epochs": [2]}}"#;
    let problem = post(&[as_json], twice.as_bytes()).refused(key);
    assert_eq!(problem.errors[0].pointer, "/matrix/epochs");
    let many: Vec<String> = (0..300_000).map(|n| format!("\"x{n}\":0")).collect();
    let many = format!("{{{}}}", many.join(","));
    let answer = post(&[as_json], many.as_bytes());
    assert!(answer.body.len() < 100_000, "{} bytes", answer.body.len());
    let errors = answer
        .refused("a field that does not exist (the nearest name is told)")
        .errors;
    assert_eq!(errors.len(), 101);
    assert_eq!(errors[100].message, "and 299900 wrong fields more");
    post(&[as_json], "[".repeat(100_000).as_bytes()).refused(not_json);
    let large = vec![b' '; (4 << 20) + 1];
    post(&[as_json], &large).refused("a body of more than 4 MiB");
    post(&[("content-type", "text/plain")], b"{}").refused("a body that is not said to be JSON");
    post(&[as_json, ("origin", "http://example.org")], b"{}")
        .refused("a change asked for by another site's page");
    post(&[as_json, ("host", "example.org")], b"{}")
        .refused("another host's name, where there is no token");
    let own = server.url().to_owned();
    assert_eq!(post(&[as_json, ("origin", &own)], b"[]").status, 422);
    let long = "k".repeat(201);
    post(&[as_json, ("idempotency-key", &long)], b"{}")
        .refused("an idempotency key that is empty or too long");

    for query in ["limit=0", "limit=many", "cursor=-1"] {
        server
            .get(&format!("/v1/jobs?{query}"))
            .refused("a page size or cursor that makes no sense");
    }
    let unknown = [
        ("/v1/jobs/7", "an unknown job"),
        ("/v1/jobs/x/runs", "an unknown job"),
        ("/v1/jobs/%2e%2e", "an unknown job"),
        ("/v1/runs/0123", "an unknown run"),
        ("/v1/runs/0123/coverage.png", "an unknown run"),
        ("/v1/arenas/nowhere", "an unknown arena"),
        ("/v1/arenas/nowhere.svg", "an unknown arena"),
        ("/v2", "an unknown route"),
        ("/problems/none", "an unknown route"),
        ("/v1/runs/%ff", "a path that is not UTF-8"),
    ];
    for (path, row) in unknown {
        server.get(path).refused(row);
    }
    for (method, path) in [("PUT", "/v1/jobs"), ("POST", "/v1/runs/7")] {
        let answer = server.send(method, path, &[as_json], b"{}");
        answer.refused("a method that a route does not have");
        assert!(answer.headers.contains_key("allow"));
    }
}

#[test]
fn every_code_says_what_it_means() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let all: Value = server.read("/problems");
    assert_eq!(
        all["items"].as_array().unwrap().len(),
        ProblemCode::ALL.len()
    );
    for code in ProblemCode::ALL {
        let told: Value = server.read(code.uri());
        assert_eq!(
            (&told["code"], &told["status"]),
            (&json!(code.code()), &json!(code.status()))
        );
        assert_eq!(told["meaning"], code.meaning());
    }
}

#[test]
fn recordings_that_cannot_be_made_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let small = [
        "--run-recordings-bytes",
        "1500000",
        "--job-recordings-bytes",
        "4500000",
    ];
    let server = Server::start_with(home.path(), &small);
    let mut steered = small_spec();
    steered["controller"] = json!({ "method": "external" });
    let steered = server.only_run(&server.submit(&job(steered, 1))).id;
    let recordings = format!("/v1/runs/{steered}/recordings");
    let explain = format!("/v1/runs/{steered}/explain");
    for answer in [server.post(&recordings, &json!({})), server.get(&explain)] {
        let what = "recording or explaining what a program outside steered";
        let detail = answer.refused(what).detail.unwrap();
        assert!(detail.contains("say `record` in the spec"), "{detail}");
    }

    let too_many = "more bytes of recordings than a run or a job may have";
    let mut spec = small_spec();
    spec["epochs"] = json!(1_000);
    // 17 bytes a sample: 3.3 MiB.
    let recorded = |spec: &Value, every: u32| {
        let mut spec = spec.clone();
        spec["record"] = json!({ "every_steps": every });
        spec
    };
    let posted = job(recorded(&spec, 1), 1);
    for path in ["/v1/jobs", "/v1/checks/job"] {
        let error = &server.post(path, &posted).refused(too_many).errors[0];
        assert_eq!(error.pointer, "/base/record");
        assert!(error.message.contains("3.3 MiB"), "{error}");
        assert!(
            error.allowed.contains("every_steps of at least 3"),
            "{error}"
        );
    }
    // Three runs fit into a job, as what is told says; a fourth does not, also not as an extension.
    let error = &server
        .post("/v1/jobs", &job(recorded(&spec, 3), 4))
        .refused(too_many)
        .errors[0];
    assert!(error.allowed.contains("about 3 runs"), "{error}");
    let fits = server.submit(&job(recorded(&spec, 3), 3));
    server
        .post(
            &format!("/v1/jobs/{}/extend", fits.id),
            &json!({ "seeds": 1 }),
        )
        .refused(too_many);
    server.wait_for(&fits);

    // Afterwards: what a run has counts.
    let plain = server.submit(&job(spec, 1));
    server.wait_for(&plain);
    let run = server.only_run(&plain).id;
    let recordings = format!("/v1/runs/{run}/recordings");
    let error = &server
        .post(&recordings, &json!({}))
        .refused(too_many)
        .errors[0];
    assert!(
        error.allowed.contains("every_steps of at least 3"),
        "{error}"
    );
    let asked = json!({ "every_steps": 3 });
    assert_eq!(server.post(&recordings, &asked).status, 201);
    let more = json!({ "every_steps": 4 });
    let error = &server.post(&recordings, &more).refused(too_many).errors[0];
    assert!(
        error.message.contains("recordings of the run may take"),
        "{error}"
    );
    wait::until("the recording", || {
        let list: Value = server.read(&recordings);
        (list["items"][0]["state"] == "done").then_some(())
    });
    let made = format!("{recordings}/1");
    assert_eq!(server.send("DELETE", &made, &[], b"").status, 204);
    assert_eq!(server.post(&recordings, &more).status, 201);
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
    server
        .get(&format!("/v1/runs/{run}/result"))
        .refused("the result or the explanation of an unfinished run");
    server
        .get(&format!("/v1/runs/{run}/explain"))
        .refused("the result or the explanation of an unfinished run");
    let retry = format!("/v1/jobs/{}/retry", running.id);
    server
        .send("POST", &retry, &[], b"")
        .refused("trying again a job that has not ended");
    wait::until("a worker", || {
        (server.only_run(&running).state == State::Running).then_some(())
    });
    let step = |epochs: i32| {
        server.post(
            &format!("/v1/runs/{run}/step"),
            &json!({ "epochs": epochs }),
        )
    };
    step(3).refused("stepping a run that is not paused");
    step(0).refused("a control that is not one whole number in its range");
    let ask = |path: String| server.send("POST", &path, &[], b"");
    let job_path = format!("/v1/jobs/{}", running.id);
    let recordings = format!("/v1/runs/{run}/recordings");
    server
        .get(&format!("{recordings}/live"))
        .refused("a recording that is not there");
    let ask_from = |from_epoch: u32| {
        let asked = json!({ "from_epoch": from_epoch, "epochs": 1 });
        server.post(&recordings, &asked)
    };
    let refused = (0..200).map(ask_from).find(|answer| answer.status != 201);
    refused
        .unwrap()
        .refused("more than 100 recordings of a run, or 64 that wait");
    assert_eq!(ask(format!("{job_path}/pause")).status, 200);
    ask(format!("/v1/runs/{run}/resume")).refused("resuming a run whose job is paused");
    assert_eq!(ask(format!("{job_path}/resume")).status, 200);
    let mut recorded = small_spec();
    recorded["epochs"] = json!(1_000_000);
    recorded["record"] = json!({ "every_steps": 200, "fields": ["pose"] });
    let recording = server.submit(&job(recorded, 1));
    let live = format!(
        "/v1/runs/{}/recordings/live",
        server.only_run(&recording).id
    );
    wait::until("a recording", || {
        (server.get(&live).status == 200).then_some(())
    });
    server
        .send("DELETE", &live, &[], b"")
        .refused("deleting the recording of a run that is to record more");
    // It would keep a worker.
    assert_eq!(ask(format!("/v1/jobs/{}/cancel", recording.id)).status, 200);
    let long_chapter = json!({
        "base": { "epochs": 1_000_000, "arena": "easy" },
        "matrix": { "controller.method": server.chapter_5_methods() }
    });
    let chapter = server.submit(&long_chapter);
    server
        .get(&format!("/v1/jobs/{}/report.html", chapter.id))
        .refused("the report of an unfinished job");
    let path = format!("/v1/jobs/{}", chapter.id);
    assert_eq!(server.send("DELETE", &path, &[], b"").status, 204);
    let no_chapter = format!("/v1/jobs/{}/report", running.id);
    server
        .get(&no_chapter)
        .refused("the report of another job than chapter 5");
    let done = server.wait_for(&server.submit(&job(small_spec(), 1)));
    server
        .send("POST", &format!("/v1/jobs/{}/cancel", done.id), &[], b"")
        .refused("cancelling what is done or failed");
    for what in ["resume", "retry"] {
        server
            .send("POST", &format!("/v1/jobs/{}/{what}", done.id), &[], b"")
            .refused("resuming or trying again what is done");
    }
    let run = server.only_run(&done).id;
    server
        .send("POST", &format!("/v1/runs/{run}/cancel"), &[], b"")
        .refused("cancelling what is done or failed");
    server
        .post(
            &format!("/v1/runs/{run}/channels"),
            &json!({ "frames": true }),
        )
        .refused("opening channels of a run that has ended");
    let cancel = format!("/v1/jobs/{}/cancel", running.id);
    assert_eq!(server.send("POST", &cancel, &[], b"").status, 200);
    let run = server.only_run(&running).id;
    server
        .get(&format!("/v1/runs/{run}/coverage"))
        .refused("what a cancelled run covered");

    let mut room = arena;
    room["name"] = json!("room");
    assert_eq!(server.post("/v1/arenas", &room).status, 201);
    room["width_m"] = json!(0.7);
    server
        .post("/v1/arenas", &room)
        .refused("an arena whose name is taken");
    room["name"] = json!("maze");
    server
        .post("/v1/arenas", &room)
        .refused("an arena whose name is taken");
    let mut user = small_spec();
    user["arena"] = json!("room");
    server.wait_for(&server.submit(&job(user, 1)));
    server
        .send("DELETE", "/v1/arenas/room", &[], b"")
        .refused("deleting an arena in use");
    server
        .send("DELETE", "/v1/arenas/maze", &[], b"")
        .refused("deleting a built-in arena");
}

#[test]
fn a_server_with_a_token_asks_for_it() {
    let home = tempfile::tempdir().unwrap();
    let token = "sixteen characters or more";
    let server = Server::start_with_token(home.path(), token);
    let refused = "a missing or wrong token, where the server has one";
    server.get("/v1/jobs").refused(refused);
    let with = |value: &str| server.send("GET", "/v1/jobs", &[("authorization", value)], b"");
    let right = format!("Bearer {token}");
    for _ in 0..20 {
        with("Bearer wrong").refused(refused);
    }
    let limited = with("Bearer wrong");
    limited.refused("more than 20 wrong tokens a minute from an address");
    assert!(limited.headers.contains_key("retry-after"));
    // Nobody behind the same address is shut out.
    assert_eq!(with(&right).status, 200);
    assert_eq!(server.get("/health/livez").status, 200);
}

#[test]
fn a_token_is_made_kept_as_a_digest_and_asked_for() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("tokens");
    let made = evswarm(&["token", "ann", "--read-only"], "");
    assert_eq!(made.code, Some(0), "{made:?}");
    let (_, token) = made.stderr.trim_end().rsplit_once(' ').unwrap();
    assert!(token.len() > 40 && !made.stdout.contains(token), "{made:?}");
    std::fs::write(&file, &made.stdout).unwrap();
    std::fs::set_permissions(&file, Permissions::from_mode(0o620)).unwrap();
    let server = Server::start_with(home.path(), &["--tokens", file.to_str().unwrap()]);
    let log = server.log();
    assert!(log.contains("others than its owner may write"), "{log}");
    let bearer = format!("Bearer {token}");
    let headers = [
        ("authorization", bearer.as_str()),
        ("content-type", "application/json"),
    ];
    assert_eq!(server.send("GET", "/v1/jobs", &headers, b"").status, 200);
    server
        .send("POST", "/v1/jobs", &headers, b"{}")
        .refused("a change asked for with a token that only reads");
    assert_ne!(evswarm(&["token", "a b"], "").code, Some(0));
    assert_ne!(evswarm(&["status", "--token", token], "").code, Some(0));
}
