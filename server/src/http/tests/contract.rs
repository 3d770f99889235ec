//! What holds for all routes: queries, tags, parts, compression; lists and what they are asked with.

use axum::http::header::{ACCEPT_ENCODING, CONTENT_ENCODING, CONTENT_RANGE, RANGE};

use super::*;

#[tokio::test]
async fn no_route_takes_a_parameter_that_it_does_not_have() {
    let service = Service::start(None);
    let job = service.job(&job(1, 1)).await;
    let run = service.runs(&job).await[0]["id"].clone();
    let run = format!("/v1/runs/{}", run.as_str().unwrap());
    let unknown = "a query parameter that the route does not have, or one given twice";
    for path in [
        "/?x=1",
        "/health/livez?x",
        "/problems?x=1",
        "/v1/version?verbose=1",
        "/v1/controllers?x=1",
        "/v1/arenas?limit=3",
        "/v1/jobs?lmit=3",
        "/v1/jobs?limit=3&limit=4",
        "/v1/runs?q=x",
        &format!("{job}?x=1"),
        &format!("{job}/summary?points=3"),
        &format!("{run}?x=1"),
        &format!("{run}/coverage?points=3"),
        &format!("{run}/curve?point=3"),
    ] {
        assert_refused(&service.get(path).await, unknown);
    }
    let body = json!({});
    assert_refused(&service.post("/v1/jobs?limit=3", &body).await, unknown);
    assert_refused(
        &service.ask("POST", &format!("{job}/cancel?x=1")).await,
        unknown,
    );
    assert_eq!(
        service.get(&format!("{run}/curve?points=3")).await.status,
        200
    );
}

#[tokio::test]
async fn the_version_is_told() {
    let service = Service::start(None);
    let version = service.get("/v1/version").await.json();
    let expected = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "results_version": swarm::RESULTS_VERSION,
        "schema": api::SCHEMA,
    });
    assert_eq!(version, expected);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn runs_of_all_jobs_are_listed_and_filtered() {
    let service = Service::start(None);
    let mut other = job(2, 2);
    other["base"]["arena"] = json!("maze");
    let (first, second) = (service.job(&job(1, 3)).await, service.job(&other).await);
    // A run that two jobs have is one run.
    let again = service.job(&job(1, 4)).await;
    for job in [&first, &second, &again] {
        service.wait_until(job, "done").await;
    }
    let mut ids = Vec::new();
    let mut path = "/v1/runs?limit=2".to_owned();
    loop {
        let page = service.get(&path).await.json();
        let items = page["items"].as_array().unwrap().clone();
        ids.extend(items.into_iter().map(|run| run["id"].clone()));
        match page["next"].as_str() {
            Some(next) => path = format!("/v1/runs?limit=2&cursor={next}"),
            None => break,
        }
    }
    let mut expected = Vec::new();
    for job in [&first, &second, &again] {
        for run in service.runs(job).await {
            if !expected.contains(&run["id"]) {
                expected.push(run["id"].clone());
            }
        }
    }
    expected.reverse();
    assert_eq!((ids.len(), &ids), (6, &expected));
    for (query, count) in [
        ("arena=maze", 2),
        ("arena=maze&state=done", 2),
        ("arena=graph", 0),
        ("method=brownian", 6),
        ("method=im", 0),
        ("state=failed", 0),
        ("job=1", 3),
        ("job=3", 4),
        ("job=3&arena=maze", 0),
        ("job=77", 0),
    ] {
        let page = service.get(&format!("/v1/runs?{query}")).await.json();
        assert_eq!(page["items"].as_array().unwrap().len(), count, "{query}");
    }
    expected.reverse();
    let mut oldest = Vec::new();
    let mut path = "/v1/runs?order=oldest&limit=4".to_owned();
    loop {
        let page = service.get(&path).await.json();
        let items = page["items"].as_array().unwrap().clone();
        oldest.extend(items.into_iter().map(|run| run["id"].clone()));
        match page["next"].as_str() {
            Some(next) => path = format!("/v1/runs?order=oldest&limit=4&cursor={next}"),
            None => break,
        }
    }
    assert_eq!(oldest, expected);
    let of_third = service.get("/v1/runs?job=3&limit=1").await.json();
    assert_eq!(of_third["items"][0]["job_id"], "3");
    for wrong in ["state=gone", "job=x", "cursor=x", "limit=0", "method="] {
        assert_problem(&service.get(&format!("/v1/runs?{wrong}")).await, 400);
    }
}

#[tokio::test]
async fn jobs_are_filtered_and_sorted() {
    let service = Service::start(None);
    for (name, epochs) in [
        ("Levy walks", 1),
        ("brownian", 1),
        ("levy, long", 1_000_000),
    ] {
        let mut body = job(epochs, 1);
        body["name"] = json!(name);
        service.job(&body).await;
    }
    for id in ["1", "2"] {
        service.wait_until(&format!("/v1/jobs/{id}"), "done").await;
    }
    let ids = async |query: &str| {
        let page = service.get(&format!("/v1/jobs?{query}")).await.json();
        let ids = page["items"].as_array().unwrap().iter();
        let ids: Vec<String> = ids
            .map(|job| job["id"].as_str().unwrap().to_owned())
            .collect();
        (ids.join(" "), page["next"].clone())
    };
    for (query, expected) in [
        ("", "3 2 1"),
        ("order=newest", "3 2 1"),
        ("order=oldest", "1 2 3"),
        ("q=LEVY", "3 1"),
        ("q=levy&state=done", "1"),
        ("state=done&order=oldest", "1 2"),
        ("state=failed", ""),
        ("q=%25", ""),
    ] {
        assert_eq!(
            ids(query).await,
            (expected.to_owned(), Value::Null),
            "{query}"
        );
    }
    assert_eq!(
        ids("order=oldest&limit=2").await,
        ("1 2".to_owned(), json!("2"))
    );
    assert_eq!(ids("order=oldest&limit=2&cursor=2").await.0, "3");
    assert_eq!(ids("q=levy&limit=1").await, ("3".to_owned(), json!("3")));
    assert_eq!(ids("q=levy&limit=1&cursor=3").await.0, "1");
    assert_problem(&service.get("/v1/jobs?order=name").await, 400);
}

#[tokio::test]
async fn answers_have_tags_parts_and_short_forms() {
    let service = Service::start(None);
    let job = service.job(&job(2, 1)).await;
    service.wait_until(&job, "done").await;
    let run = service.runs(&job).await[0]["id"].clone();
    let run = format!("/v1/runs/{}", run.as_str().unwrap());
    let npy = format!("{run}/coverage.npy");
    for path in [
        "/",
        "/dashboard.js",
        "/v1/controllers",
        "/v1/arenas",
        "/v1/arenas/maze",
        "/v1/arenas/maze.svg",
        "/v1/version",
        &job,
        &run,
        &npy,
        &format!("{job}/summary.md"),
        &format!("{run}/spec"),
        &format!("{run}/result"),
    ] {
        let answer = service.get(path).await;
        let tag = answer.headers[ETAG].clone();
        let again = request("GET", path).header(IF_NONE_MATCH, &tag);
        let again = service.send(again, Body::empty()).await;
        assert_eq!((again.status, again.body.len()), (304, 0), "{path}");
        assert_eq!(again.headers[ETAG], tag, "{path}");
    }
    let whole = service.get(&npy).await;
    assert_eq!(whole.headers["accept-ranges"], "bytes");
    let part = request("GET", &npy).header(RANGE, "bytes=6-9");
    let part = service.send(part, Body::empty()).await;
    assert_eq!((part.status, &part.body), (206, &whole.body.slice(6..10)));
    let length = whole.body.len();
    assert_eq!(part.headers[CONTENT_RANGE], *format!("bytes 6-9/{length}"));
    let beyond = request("GET", &npy).header(RANGE, format!("bytes={length}-"));
    let beyond = service.send(beyond, Body::empty()).await;
    assert_refused(&beyond, "bytes beyond the end of a file (`Range`)");
    assert_eq!(beyond.headers[CONTENT_RANGE], *format!("bytes */{length}"));

    let short = async |path: &str| {
        let asked = request("GET", path).header(ACCEPT_ENCODING, "gzip");
        service.send(asked, Body::empty()).await
    };
    let long = service.get("/v1/controllers").await;
    let answer = short("/v1/controllers").await;
    assert_eq!(answer.headers[CONTENT_ENCODING], "gzip");
    assert!(answer.body.starts_with(b"\x1f\x8b") && answer.body.len() < long.body.len() / 2);
    let weak = answer.headers[ETAG].to_str().unwrap().to_owned();
    assert_eq!(weak, format!("W/{}", long.headers[ETAG].to_str().unwrap()));
    let again = request("GET", "/v1/controllers").header(IF_NONE_MATCH, &weak);
    assert_eq!(service.send(again, Body::empty()).await.status, 304);
    // Too short, and no text.
    for path in ["/v1/version", &npy] {
        assert!(
            !short(path).await.headers.contains_key(CONTENT_ENCODING),
            "{path}"
        );
    }
}
