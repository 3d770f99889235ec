//! What operators look at: `/metrics`, workers, request ids.

use std::collections::BTreeSet;

use super::*;

/// Names of samples in OpenMetrics text.
fn names(text: &str) -> BTreeSet<&str> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines
        .filter_map(|line| line.split(['{', ' ']).next())
        .collect()
}

/// The value of a sample.
fn sample(text: &str, name: &str) -> f64 {
    let line = text.lines().find_map(|line| line.strip_prefix(name));
    let value = line.unwrap_or_else(|| panic!("{name} in {text}"));
    value.trim().parse().unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn metrics_tell_what_was_done() {
    let service = Service::start(None);
    let path = service.job(&job(3, 2)).await;
    service.wait_until(&path, "done").await;
    assert_eq!(service.get("/v1/jobs/77").await.status, 404);
    assert_eq!(service.get("/nowhere").await.status, 404);
    let answer = service.get("/metrics").await;
    assert!(
        answer
            .media_type()
            .starts_with("application/openmetrics-text")
    );
    let text = String::from_utf8(answer.body.to_vec()).unwrap();
    assert_eq!(sample(&text, "evswarm_robot_steps_total"), 1_200.0);
    assert_eq!(sample(&text, "evswarm_runs{state=\"done\"}"), 2.0);
    assert_eq!(sample(&text, "evswarm_runs{state=\"failed\"}"), 0.0);
    assert_eq!(sample(&text, "evswarm_threads"), 1.0);
    assert_eq!(sample(&text, "evswarm_queued_runs"), 0.0);
    for whom in ["lossless_readers", "controllers", "store"] {
        let name = format!("evswarm_waiting_runs{{for=\"{whom}\"}}");
        assert_eq!(sample(&text, &name), 0.0);
    }
    assert!(sample(&text, "evswarm_memory_resident_bytes") > 1e6);
    assert!(sample(&text, "evswarm_store_room_bytes") > 0.0);
    assert!(sample(&text, "evswarm_store_bytes{part=\"finals\"}") > 1e4);
    for labels in [
        "method=\"GET\",route=\"/v1/jobs/{id}\",status=\"404\"",
        "method=\"POST\",route=\"/v1/jobs\",status=\"201\"",
        "method=\"GET\",route=\"none\",status=\"404\"",
    ] {
        let name = format!("evswarm_http_request_seconds_count{{{labels}}}");
        assert_eq!(sample(&text, &name), 1.0, "{labels}");
    }
    assert!(text.ends_with("# EOF\n"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_dashboard_and_the_list_name_metrics_that_there_are() {
    let service = Service::start(None);
    service.job(&job(1, 1)).await;
    let text = service.get("/metrics").await.body.to_vec();
    let text = String::from_utf8(text).unwrap();
    // The first scrape counts in the next.
    let again = service.get("/metrics").await.body.to_vec();
    let again = String::from_utf8(again).unwrap();
    let mut known = names(&again);
    known.extend(names(&text));
    let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/operations/");
    for file in ["grafana.json", "README.md"] {
        let text = std::fs::read_to_string(format!("{docs}{file}")).unwrap();
        if file == "grafana.json" {
            let dashboard: Value = serde_json::from_str(&text).unwrap();
            assert!(dashboard["panels"].as_array().unwrap().len() >= 8);
        }
        let mut told = BTreeSet::new();
        for (place, _) in text.match_indices("evswarm_") {
            let is_name = |c: char| c.is_ascii_lowercase() || c == '_' || c.is_ascii_digit();
            let name = text[place..].split(|c: char| !is_name(c)).next().unwrap();
            told.insert(name);
        }
        assert!(told.len() >= 8, "{file}: {told:?}");
        for name in told {
            let is_there = known.contains(name)
                || known
                    .iter()
                    .any(|known| known.strip_prefix(name) == Some("_count"));
            assert!(is_there, "{file} names {name}, which /metrics has not");
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn workers_tell_what_they_are_at() {
    let service = Service::start(None);
    let idle = service.get("/v1/workers").await.json();
    assert_eq!(idle, json!({ "threads": 1, "queued": 0, "items": [] }));
    let path = service.job(&job(1_000_000, 2)).await;
    service.wait_until(&path, "running").await;
    let busy = service.get("/v1/workers").await.json();
    assert_eq!((&busy["threads"], &busy["queued"]), (&json!(1), &json!(1)));
    let run = service.runs(&path).await[0]["id"].clone();
    assert_eq!(busy["items"][0]["run"], run);
    assert_eq!(busy["items"][0]["job_id"], "1");
}

#[tokio::test]
async fn every_answer_has_the_id_of_its_request() {
    let service = Service::start(None);
    let asked = request("GET", "/v1/jobs/77").header("x-request-id", "mine-7");
    let answer = service.send(asked, Body::empty()).await;
    assert_eq!(answer.headers["x-request-id"], "mine-7");
    assert_eq!(answer.json()["request_id"], "mine-7");
    let one = service.get("/v1/jobs/77").await;
    let two = service.get("/v1/version").await;
    assert_ne!(one.headers["x-request-id"], two.headers["x-request-id"]);
    assert_eq!(
        one.json()["request_id"],
        one.headers["x-request-id"].to_str().unwrap()
    );
}
