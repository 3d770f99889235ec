//! Jobs, runs and arenas from their first request to their last.

use super::*;

#[tokio::test]
async fn a_job_from_post_to_pictures() {
    let service = Service::start(None);
    let answer = service.post("/v1/jobs", &job(3, 2)).await;
    assert_eq!(answer.status, 201);
    let path = answer.headers[LOCATION].to_str().unwrap().to_owned();
    let posted = answer.json();
    assert_eq!(path, format!("/v1/jobs/{}", posted["id"].as_str().unwrap()));
    assert_eq!(
        (&posted["name"], &posted["runs"]["total"]),
        (&json!("a job"), &json!(2))
    );

    let done = service.wait_until(&path, "done").await;
    assert_eq!(
        (&done["progress"], &done["eta_s"]),
        (&json!(1.0), &Value::Null)
    );
    let runs = service.runs(&path).await;
    assert_eq!(runs.len(), 2);
    let run = format!("/v1/runs/{}", runs[0]["id"].as_str().unwrap());
    assert_eq!(service.get(&run).await.json(), runs[0]);
    let result = service.get(&format!("{run}/result")).await.json();
    assert_eq!(result, runs[0]["result"]);
    assert_eq!(
        service.get(&format!("{run}/spec")).await.json()["epochs"],
        3
    );
    let channels = service.get(&format!("{run}/channels")).await.json();
    let channels = channels.as_array().unwrap();
    assert!(!channels.is_empty() && channels.iter().all(|channel| channel["is_open"] == false));
    let curve = service.get(&format!("{run}/curve")).await.json();
    assert_eq!(curve.as_array().unwrap().len(), 3);
    assert_eq!(curve[2]["p1"], result["p1"]);
    let thin = service.get(&format!("{run}/curve?points=2")).await.json();
    assert_eq!(thin, json!([curve[0], curve[2]]));
    let coverage = service.get(&format!("{run}/coverage")).await.json();
    assert_eq!(
        (&coverage["p10"], &coverage["arena"]),
        (&result["p10"], &json!("easy"))
    );

    let kinds = [
        ("curve.csv", "text/csv; charset=utf-8", &b"epoch,p1"[..]),
        ("coverage.csv", "text/csv; charset=utf-8", b"column,row"),
        ("coverage.png", "image/png", b"\x89PNG"),
        ("coverage.svg", "image/svg+xml", b"<"),
        ("coverage.npy", "application/octet-stream", b"\x93NUMPY"),
        ("dwell.npy", "application/octet-stream", b"\x93NUMPY"),
    ];
    for (suffix, media_type, start) in kinds {
        let path = format!("{run}/{suffix}");
        let answer = service.get(&path).await;
        assert_eq!(
            (answer.status, answer.media_type()),
            (200, media_type),
            "{suffix}"
        );
        assert!(answer.body.starts_with(start), "{suffix}");
        let again = request("GET", &path).header(IF_NONE_MATCH, &answer.headers[ETAG]);
        let again = service.send(again, Body::empty()).await;
        assert_eq!((again.status, again.body.len()), (304, 0), "{suffix}");
    }
    assert_problem(&service.ask("POST", &format!("{path}/cancel")).await, 409);
    assert_problem(&service.ask("POST", &format!("{run}/cancel")).await, 409);
    assert_eq!(service.ask("DELETE", &path).await.status, 204);
    assert_problem(&service.get(&path).await, 404);
    assert_problem(&service.get(&run).await, 404);
}

#[tokio::test]
async fn a_run_can_be_looked_at_while_it_runs_waits_and_after_it_was_cancelled() {
    let service = Service::start(None);
    let path = service.job(&job(1_000_000, 2)).await;
    service.wait_until(&path, "running").await;
    let running = service.runs(&path).await[0]["id"]
        .as_str()
        .unwrap()
        .to_owned();
    let waiting = service.runs(&path).await[1]["id"]
        .as_str()
        .unwrap()
        .to_owned();
    let start = Instant::now();
    loop {
        let run = service.get(&format!("/v1/runs/{running}")).await.json();
        if run["progress"]["epochs_done"]
            .as_u64()
            .is_some_and(|epochs| epochs > 0)
        {
            break;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{run}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    for suffix in [
        "curve",
        "curve.csv",
        "coverage",
        "coverage.png",
        "coverage.npy",
    ] {
        for run in [&running, &waiting] {
            let answer = service.get(&format!("/v1/runs/{run}/{suffix}")).await;
            assert_eq!(answer.status, 200, "{suffix}");
        }
    }
    let empty = service
        .get(&format!("/v1/runs/{waiting}/coverage"))
        .await
        .json();
    assert_eq!(
        (&empty["p1"], empty["visits"].as_array().unwrap().len()),
        (&json!(0), 100)
    );
    assert_problem(
        &service.get(&format!("/v1/runs/{running}/result")).await,
        409,
    );

    assert_eq!(
        service.ask("POST", &format!("{path}/pause")).await.json()["state"],
        "paused"
    );
    assert_eq!(
        service.ask("POST", &format!("{path}/pause")).await.status,
        200
    );
    let resumed = service.ask("POST", &format!("{path}/resume")).await.json();
    assert_ne!(resumed["state"], "paused");
    let one = service
        .ask("POST", &format!("/v1/runs/{waiting}/cancel"))
        .await;
    assert_eq!(
        (one.status, &one.json()["state"]),
        (200, &json!("cancelled"))
    );
    assert_eq!(
        service.ask("POST", &format!("{path}/cancel")).await.json()["state"],
        "cancelled"
    );
    assert_eq!(
        service.ask("POST", &format!("{path}/cancel")).await.status,
        200
    );
    assert_problem(&service.ask("POST", &format!("{path}/resume")).await, 409);
    assert_problem(
        &service
            .get(&format!("/v1/runs/{running}/coverage.png"))
            .await,
        409,
    );
}

#[tokio::test]
async fn a_repeated_request_makes_one_job() {
    let service = Service::start(None);
    let keyed = |key: &str| {
        request("POST", "/v1/jobs")
            .header(CONTENT_TYPE, "application/json; charset=utf-8")
            .header("idempotency-key", key)
    };
    let first = service.send(keyed("k"), job(1, 1).to_string()).await;
    let second = service.send(keyed("k"), job(1, 1).to_string()).await;
    assert_eq!((first.status, second.status), (201, 201));
    assert_eq!(first.headers[LOCATION], second.headers[LOCATION]);
    assert_problem(&service.send(keyed("k"), job(2, 1).to_string()).await, 422);
    assert_problem(&service.send(keyed(""), job(2, 1).to_string()).await, 400);
    assert_eq!(
        service.get("/v1/jobs").await.json()["items"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
}

#[tokio::test]
async fn a_full_queue_says_when_to_come_again() {
    let service = Service::start(None);
    service.job(&job(1_000_000, 6)).await;
    let refused = service.post("/v1/jobs", &job(999_999, 6)).await;
    assert_refused(
        &refused,
        "more than 200,000 unfinished runs (`Retry-After` is given)",
    );
    assert!(refused.headers.contains_key("retry-after"));
    let larger = service.post("/v1/jobs", &job(999_999, 11)).await;
    assert_refused(&larger, "a job of more runs than may be unfinished");
}

#[tokio::test]
async fn lists_come_in_pages() {
    let service = Service::start(None);
    for epochs in 1..=5 {
        service.job(&job(epochs, 1)).await;
    }
    let (mut ids, mut path) = (Vec::new(), "/v1/jobs?limit=2".to_owned());
    loop {
        let page = service.get(&path).await.json();
        ids.extend(
            page["items"]
                .as_array()
                .unwrap()
                .iter()
                .map(|job| job["id"].clone()),
        );
        match page["next"].as_str() {
            Some(next) => path = format!("/v1/jobs?limit=2&cursor={next}"),
            None => break,
        }
    }
    assert_eq!(json!(ids), json!(["5", "4", "3", "2", "1"]));
    let job = service.job(&job(1, 3)).await;
    let page = service.get(&format!("{job}/runs?limit=2")).await.json();
    assert_eq!(
        (page["items"].as_array().unwrap().len(), &page["next"]),
        (2, &json!("2"))
    );
    let rest = service
        .get(&format!("{job}/runs?limit=2&cursor=2"))
        .await
        .json();
    assert_eq!(
        (&rest["items"][0]["index"], &rest["next"]),
        (&json!(2), &Value::Null)
    );
    for query in ["limit=0", "limit=x", "limit=1000", "cursor=x", "cursor=-1"] {
        assert_problem(&service.get(&format!("/v1/jobs?{query}")).await, 400);
    }
}

#[tokio::test]
async fn arenas_come_and_go() {
    let service = Service::start(None);
    let builtin = service.get("/v1/arenas").await.json()["items"].clone();
    assert!(
        builtin
            .as_array()
            .unwrap()
            .iter()
            .any(|arena| arena["name"] == "maze")
    );
    let arena = json!({
        "name": "two-rooms", "width_m": 0.6, "height_m": 0.6,
        "walls_m": [[0.3, 0.0, 0.3, 0.4]],
        "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.0 }],
    });
    let created = service.post("/v1/arenas", &arena).await;
    assert_eq!(
        (created.status, &created.headers[LOCATION]),
        (201, &"/v1/arenas/two-rooms".parse().unwrap())
    );
    assert_eq!(
        (&created.json()["walls"], &created.json()["builtin"]),
        (&json!(1), &json!(false))
    );
    assert_eq!(service.post("/v1/arenas", &arena).await.status, 200);
    let mut other = arena.clone();
    other["walls_m"] = json!([]);
    assert_problem(&service.post("/v1/arenas", &other).await, 409);
    other["name"] = json!("maze");
    assert_problem(&service.post("/v1/arenas", &other).await, 409);
    other["width_m"] = json!(-1);
    other["name"] = json!("No Name");
    let wrong = service.post("/v1/arenas", &other).await;
    assert_problem(&wrong, 422);
    assert_eq!(wrong.json()["errors"].as_array().unwrap().len(), 2);

    assert_eq!(
        service.get("/v1/arenas/two-rooms").await.json()["walls_m"],
        arena["walls_m"]
    );
    let svg = service.get("/v1/arenas/two-rooms.svg").await;
    assert_eq!((svg.status, svg.media_type()), (200, "image/svg+xml"));

    let mut uses = job(1, 1);
    uses["base"]["arena"] = json!("two-rooms");
    let path = service.job(&uses).await;
    service.wait_until(&path, "done").await;
    assert_eq!(service.runs(&path).await[0]["arena"], "two-rooms");
    assert_problem(&service.ask("DELETE", "/v1/arenas/two-rooms").await, 409);
    assert_eq!(service.ask("DELETE", &path).await.status, 204);
    assert_eq!(
        service.ask("DELETE", "/v1/arenas/two-rooms").await.status,
        204
    );
    assert_problem(&service.ask("DELETE", "/v1/arenas/two-rooms").await, 404);
    assert_problem(&service.ask("DELETE", "/v1/arenas/maze").await, 409);
}

#[tokio::test]
async fn runs_are_told_with_what_varies_between_them() {
    let service = Service::start(None);
    let mut sweep = job(1, 2);
    sweep["matrix"] = json!({ "steps_per_epoch": [20, 30] });
    let path = service.job(&sweep).await;
    let runs = service.runs(&path).await;
    let labels: Vec<&Value> = runs.iter().map(|run| &run["label"]).collect();
    let [few, many] = ["steps_per_epoch 20", "steps_per_epoch 30"];
    assert_eq!(labels, [few, few, many, many]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn metrics_and_summary_of_a_job_over_robots() {
    let service = Service::start(None);
    let body = json!({
        "name": "scaling",
        "base": {
            "arena": "easy", "controller": { "method": "brownian" }, "placement": "random",
            "epochs": 2, "steps_per_epoch": 100
        },
        "matrix": { "robots": [1, 4] },
        "seeds": { "first": 1, "count": 3 },
    });
    let job = service.job(&body).await;
    service.wait_until(&job, "done").await;
    let runs = service.runs(&job).await;
    let run = format!("/v1/runs/{}", runs[3]["id"].as_str().unwrap());
    let metrics: api::Metrics =
        serde_json::from_slice(&service.get(&format!("{run}/metrics")).await.body).unwrap();
    let result: api::RunResult =
        serde_json::from_slice(&service.get(&format!("{run}/result")).await.body).unwrap();
    let last = metrics.rows.last().unwrap();
    assert_eq!((last.steps, last.epoch), (200, 2));
    let collisions = last.metrics.0["collisions"].as_ref();
    assert_eq!(
        collisions.and_then(serde_json::Number::as_u64),
        Some(result.collisions)
    );
    assert_eq!(last.fractions, result.fractions);
    let swarm = result.metrics.unwrap();
    for name in ["entropy", "overlap", "distance_m"] {
        assert_eq!(last.metrics.get(name), swarm.get(name));
        assert!(swarm.get(name).is_some(), "{name}");
    }
    assert!(swarm.get("distance_m") > Some(0.0));
    assert_eq!(swarm.get("overlap_robots"), Some(4.0));
    assert!(swarm.get("mean_coverage") < Some(last.fractions.p1));
    let csv = service.get(&format!("{run}/metrics.csv")).await;
    assert_eq!(csv.media_type(), "text/csv; charset=utf-8");
    let lines = String::from_utf8(csv.body.to_vec())
        .unwrap()
        .lines()
        .count();
    assert_eq!(lines, 1 + metrics.rows.len());
    let robots = service.get(&format!("{run}/robots.csv")).await;
    assert_eq!(
        String::from_utf8(robots.body.to_vec())
            .unwrap()
            .lines()
            .count(),
        5
    );

    let summary: api::JobSummary =
        serde_json::from_slice(&service.get(&format!("{job}/summary")).await.body).unwrap();
    assert_eq!((summary.runs, summary.runs_done), (6, 6));
    // Whatever it pools, a finished run has; but perhaps not the times to cover.
    let pooled = summary.groups[1].measures.iter();
    for measure in pooled.filter(|measure| !measure.name.starts_with('t')) {
        assert_eq!(measure.n, 3, "{}", measure.name);
    }
    assert_eq!((summary.groups[0].robots, summary.groups[1].robots), (1, 4));
    let p1 = &summary.groups[1].measures[0];
    let expected: f64 = runs[3..]
        .iter()
        .map(|r| r["result"]["p1"].as_f64().unwrap())
        .sum();
    assert!(p1.name == "p1" && (p1.mean.unwrap() - expected / 3.0).abs() < 1e-9);
    let mut measures = summary.groups[0].measures.iter();
    let cost = measures.find(|measure| measure.name == "cpu_ns_per_robot_step");
    let mean = cost.unwrap().mean.unwrap();
    let costs = runs[..3].iter().map(|run| &run["cpu_ns_per_robot_step"]);
    let sum: f64 = costs.map(|cost| cost.as_f64().unwrap()).sum();
    assert!(
        mean > 0.0 && (sum / 3.0 - mean).abs() < 1e-9 * mean,
        "{sum} {mean}"
    );
    // What a run found says nothing of the machine.
    assert!(
        !runs[0]["result"].to_string().contains("cpu"),
        "{}",
        runs[0]
    );
    assert_eq!(summary.scaling[0].points.len(), 2);
    let csv = service.get(&format!("{job}/summary.csv")).await;
    assert_eq!(csv.media_type(), "text/csv; charset=utf-8");
    let text = service.get(&format!("{job}/summary.md")).await;
    let text = String::from_utf8(text.body.to_vec()).unwrap();
    assert!(
        text.contains("6 of 6 runs done") && text.contains("## Scaling"),
        "{text}"
    );
    assert_problem(&service.get("/v1/jobs/99/summary").await, 404);

    let compared = service.get(&format!("{job}/comparison")).await.json();
    assert_eq!(compared["measure"], "p1_fraction");
    assert_eq!(
        (&compared["pairs"][0]["n"], &compared["pairs"][0]["paired"]),
        (&json!(3), &json!(true))
    );
    let by = service
        .get(&format!("{job}/comparison?measure=t50_steps&by=robots"))
        .await
        .json();
    assert_eq!(
        (&by["groups"][0]["label"], &by["better"]),
        (&json!("1"), &json!("lower"))
    );
    let csv = service
        .get(&format!("{job}/comparison.csv?measure=p10"))
        .await;
    assert_eq!(csv.media_type(), "text/csv; charset=utf-8");
    let text = service.get(&format!("{job}/comparison.md")).await;
    assert!(
        String::from_utf8(text.body.to_vec())
            .unwrap()
            .contains("n = 3 pairs")
    );
    for wrong in [
        "measure=beauty",
        "by=epochs",
        "messure=p1",
        "measure=p1&measure=p2",
    ] {
        assert_problem(
            &service.get(&format!("{job}/comparison?{wrong}")).await,
            400,
        );
    }
    assert_problem(&service.get("/v1/jobs/99/comparison").await, 404);

    let curves = service
        .get(&format!("{job}/curves?measure=p1&points=3&runs=true"))
        .await
        .json();
    let group = &curves["groups"][1];
    let last = curves["at"].as_array().unwrap().len() - 1;
    // The mean at the last epoch is that of the results.
    assert!(
        (group["mean"][last].as_f64().unwrap() - expected / 3.0).abs() < 1e-9,
        "{curves}"
    );
    assert_eq!(
        (
            group["n"][last].as_u64(),
            group["runs"].as_array().unwrap().len()
        ),
        (Some(3), 3)
    );
    // Shares are of what each run can reach.
    let shares = service
        .get(&format!("{job}/curves?measure=p1_fraction&points=3"))
        .await
        .json();
    let result = service.runs(&job).await.remove(0)["result"].clone();
    let share = group["mean"][last].as_f64().unwrap() / result["reachable"].as_f64().unwrap();
    let told = shares["groups"][1]["mean"][last].as_f64().unwrap();
    assert!((told - share).abs() < 1e-12, "{told} for {share}");
    for wrong in [
        "measure=overlap",
        "x=steps",
        "points=1",
        "points=501",
        "by=epochs",
        "run=true",
    ] {
        assert_problem(&service.get(&format!("{job}/curves?{wrong}")).await, 400);
    }
}
