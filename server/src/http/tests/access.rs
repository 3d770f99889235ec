//! What is refused, and who is let in.

use super::*;

#[tokio::test]
async fn wrong_bodies_are_told_apart() {
    let service = Service::start(None);
    let wrong = json!({ "base": { "epochs": -1, "arena": "nowhere" }, "nmae": "x" });
    let answer = service.post("/v1/jobs", &wrong).await;
    assert_problem(&answer, 422);
    let errors = answer.json()["errors"].as_array().unwrap().clone();
    let pointers: Vec<&str> = errors
        .iter()
        .map(|e| e["pointer"].as_str().unwrap())
        .collect();
    for pointer in ["/base/epochs", "/base/arena", "/nmae"] {
        assert!(pointers.contains(&pointer), "{pointers:?}");
    }
    let post = |media_type: &str| request("POST", "/v1/jobs").header(CONTENT_TYPE, media_type);
    assert_problem(&service.send(post("application/json"), "{").await, 400);
    assert_problem(
        &service
            .send(post("application/json"), vec![0xff, 0xfe])
            .await,
        400,
    );
    assert_problem(&service.send(post("text/plain"), "{}").await, 415);
    assert_problem(&service.send(request("POST", "/v1/jobs"), "{}").await, 415);
    let large = vec![b' '; body::MAX_BODY_BYTES + 1];
    assert_problem(&service.send(post("application/json"), large).await, 413);
    let deep = "[".repeat(100_000);
    assert_problem(&service.send(post("application/json"), deep).await, 400);
    assert_eq!(service.get("/v1/jobs").await.json()["items"], json!([]));
}

#[tokio::test]
async fn unknown_things_are_problems() {
    let service = Service::start(None);
    let long = "x".repeat(5_000);
    let paths = [
        "/v1",
        "/nothing",
        "/v1/jobs/",
        "/v1/jobs/7",
        "/v1/jobs/x",
        "/v1/runs/x/coverage.gif",
    ];
    for path in paths {
        assert_problem(&service.get(path).await, 404);
    }
    for path in [
        "/v1/jobs/-1/runs",
        "/v1/runs/%2e%2e",
        "/v1/arenas/none.svg",
        "/v1/runs/x/result",
    ] {
        assert_problem(&service.get(path).await, 404);
    }
    assert_problem(&service.get(&format!("/v1/runs/{long}")).await, 404);
    assert_problem(&service.get("/v1/runs/%ff").await, 400);
    let not_allowed = service.ask("PUT", "/v1/jobs").await;
    assert_problem(&not_allowed, 405);
    assert!(not_allowed.headers.contains_key("allow"));
    assert_problem(&service.ask("DELETE", "/v1/jobs/7").await, 404);
    assert_problem(&service.ask("POST", "/v1/jobs/7/cancel").await, 404);
}

#[tokio::test]
async fn the_page_and_the_catalogue_are_there() {
    let service = Service::start(None);
    for (path, media_type) in [
        ("/", "text/html; charset=utf-8"),
        ("/dashboard.css", "text/css; charset=utf-8"),
        ("/dashboard.js", "text/javascript; charset=utf-8"),
        ("/health/livez", "application/json"),
        ("/health/readyz", "application/json"),
        ("/v1/controllers", "application/json"),
        ("/v1/templates", "application/json"),
    ] {
        let answer = service.get(path).await;
        assert_eq!(
            (answer.status, answer.media_type()),
            (200, media_type),
            "{path}"
        );
        assert_eq!(answer.headers["x-content-type-options"], "nosniff");
    }
    assert_eq!(service.ask("HEAD", "/").await.status, 200);
}

#[tokio::test]
async fn other_hosts_and_other_sites_stay_out() {
    let service = Service::start(None);
    let foreign = |method: &str| Request::builder().method(method).uri("/v1/jobs");
    let rebound = foreign("GET").header(HOST, "evil.example:8080");
    assert_problem(&service.send(rebound, Body::empty()).await, 403);
    assert_problem(&service.send(foreign("GET"), Body::empty()).await, 400);
    for origin in ["http://evil.example", "null", "http://127.0.0.1:9999"] {
        let posted = request("POST", "/v1/jobs/1/cancel").header(ORIGIN, origin);
        assert_problem(&service.send(posted, Body::empty()).await, 403);
    }
    let own = request("POST", "/v1/jobs/1/cancel").header(ORIGIN, "http://127.0.0.1:8080");
    assert_problem(&service.send(own, Body::empty()).await, 404);
}

#[tokio::test]
async fn a_token_is_asked_for_wherever_jobs_are_told_of() {
    let service = Service::start(Some("a long enough secret"));
    let with = |value: &str| {
        Request::builder()
            .uri("/v1/jobs")
            .header(HOST, "swarm.example")
            .header(AUTHORIZATION, value)
    };
    let refused = service.get("/v1/jobs").await;
    assert_problem(&refused, 401);
    assert_eq!(refused.headers["www-authenticate"], "Bearer");
    for wrong in ["Bearer wrong", "Basic a long enough secret", "Bearer", ""] {
        assert_problem(&service.send(with(wrong), Body::empty()).await, 401);
    }
    let right = service
        .send(with("Bearer a long enough secret"), Body::empty())
        .await;
    assert_eq!(right.status, 200);
    for open in ["/", "/dashboard.js", "/health/livez"] {
        assert_eq!(service.get(open).await.status, 200, "{open}");
    }
}

#[tokio::test]
async fn a_token_that_only_reads_changes_nothing() {
    let lines = [
        (Right::Read, "the reader's secret"),
        (Right::Write, "the writer's secret"),
    ];
    let lines = lines.map(|(right, secret)| super::super::token_line("name", right, secret));
    let service = Service::start_with(Tokens::parse(&lines.join("\n")).unwrap());
    let ask = async |method: &str, path: &str, who: &str| {
        let asked = request(method, path)
            .header(AUTHORIZATION, format!("Bearer the {who}'s secret"))
            .header(CONTENT_TYPE, "application/json");
        service.send(asked, job(1, 1).to_string()).await
    };
    for method in ["GET", "HEAD"] {
        assert_eq!(ask(method, "/v1/jobs", "reader").await.status, 200);
    }
    let only_reads = "a change asked for with a token that only reads";
    for (method, path) in [
        ("POST", "/v1/jobs"),
        ("POST", "/v1/jobs/1/cancel"),
        ("DELETE", "/v1/jobs/1"),
    ] {
        assert_refused(&ask(method, path, "reader").await, only_reads);
    }
    // A document may be looked at before somebody else posts it.
    assert_eq!(ask("POST", "/v1/checks/job", "reader").await.status, 200);
    assert_eq!(ask("POST", "/v1/jobs", "writer").await.status, 201);
    assert_problem(&ask("GET", "/v1/jobs", "nobody").await, 401);
}

#[tokio::test]
async fn every_answer_says_what_a_browser_may_do_with_it() {
    let service = Service::start(None);
    let mut paths = vec![
        "/",
        "/v1/arenas/maze.svg",
        "/v1/jobs/7",
        "/nothing",
        "/health/livez",
    ];
    let job = service.job(&job(1, 1)).await;
    service.wait_until(&job, "done").await;
    let run = service.runs(&job).await[0]["id"].clone();
    let run = format!("/v1/runs/{}", run.as_str().unwrap());
    let pictures = ["coverage.svg", "coverage.png"].map(|name| format!("{run}/{name}"));
    paths.extend(pictures.iter().map(String::as_str));
    for path in paths {
        let answer = service.get(path).await;
        let policy = answer.headers["content-security-policy"].to_str().unwrap();
        assert!(policy.starts_with("default-src 'none'"), "{path}: {policy}");
        assert!(
            policy.contains("frame-ancestors 'none'"),
            "{path}: {policy}"
        );
        assert_eq!(answer.headers["x-content-type-options"], "nosniff");
    }
}
