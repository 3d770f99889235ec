//! Control of runs and jobs over HTTP: what is asked for, what is refused.

use super::*;

/// The only run of a new job without end, begun.
async fn begun(service: &Service) -> (String, String) {
    let path = service.job(&job(1_000_000, 1)).await;
    service.wait_until(&path, "running").await;
    let id = service.runs(&path).await[0]["id"]
        .as_str()
        .unwrap()
        .to_owned();
    (path, format!("/v1/runs/{id}"))
}

#[tokio::test]
async fn a_run_is_paused_stepped_resumed_and_deleted() {
    let service = Service::start(None);
    let (job_path, run) = begun(&service).await;
    let steps = json!({ "epochs": 2 });
    assert_problem(&service.post(&format!("{run}/step"), &steps).await, 409);
    let paused = service.ask("POST", &format!("{run}/pause")).await;
    assert_eq!(
        (paused.status, &paused.json()["state"]),
        (200, &json!("paused"))
    );
    service.wait_until(&job_path, "paused").await;

    let stepped = service.post(&format!("{run}/step"), &steps).await;
    assert_eq!(stepped.status, 200, "{:?}", stepped.body);
    service.wait_until(&run, "paused").await;
    for (body, pointer) in [
        (json!({ "epochs": 0 }), "/epochs"),
        (json!({}), "/epochs"),
        (json!({ "epoch": 1, "epochs": 1 }), "/epoch"),
    ] {
        let refused = service.post(&format!("{run}/step"), &body).await;
        assert_problem(&refused, 422);
        assert_eq!(refused.json()["errors"][0]["pointer"], pointer);
    }
    assert_eq!(
        service.ask("POST", &format!("{run}/resume")).await.status,
        200
    );
    service.wait_until(&run, "running").await;
    let log = service.get(&format!("{run}/log")).await.json();
    let said: Vec<&str> = (log["items"].as_array().unwrap().iter())
        .map(|entry| entry["what"].as_str().unwrap())
        .collect();
    assert_eq!(said[..2], ["paused", "steps 2 epochs"]);
    assert_eq!(said.last(), Some(&"resumed"));

    assert_problem(&service.ask("POST", &format!("{run}/retry")).await, 409);
    assert_eq!(
        service.ask("POST", &format!("{run}/cancel")).await.status,
        200
    );
    assert_problem(&service.ask("POST", &format!("{run}/pause")).await, 409);
    let retried = service.ask("POST", &format!("{run}/retry")).await;
    assert_eq!(retried.status, 200, "{:?}", retried.body);
    assert_eq!(service.ask("DELETE", &run).await.status, 204);
    assert_problem(&service.get(&run).await, 404);
    assert_eq!(service.get(&job_path).await.json()["runs"]["total"], 0);
}

#[tokio::test]
async fn what_is_done_is_extended_but_not_tried_again() {
    let service = Service::start(None);
    let document = job(3, 2);
    let path = service.job(&document).await;
    service.wait_until(&path, "done").await;
    for what in ["retry", "resume", "pause", "cancel"] {
        assert_problem(&service.ask("POST", &format!("{path}/{what}")).await, 409);
    }
    let before = service.runs(&path).await;
    assert_eq!(
        service.get(&format!("{path}/document")).await.json(),
        document
    );
    let extended = service
        .post(&format!("{path}/extend"), &json!({ "seeds": 2 }))
        .await;
    assert_eq!(extended.status, 200, "{:?}", extended.body);
    assert_eq!(extended.json()["runs"]["total"], 4);
    service.wait_until(&path, "done").await;
    assert_eq!(service.runs(&path).await[..2], before[..]);
    let now = service.get(&format!("{path}/document")).await.json();
    assert_eq!(
        now["seeds"]["count"],
        document["seeds"]["count"].as_u64().unwrap() + 2
    );

    let run = format!("/v1/runs/{}", before[0]["id"].as_str().unwrap());
    for what in ["retry", "resume", "pause"] {
        assert_problem(&service.ask("POST", &format!("{run}/{what}")).await, 409);
    }
    let longer = service
        .post(&format!("{run}/extend"), &json!({ "epochs": 4 }))
        .await;
    assert_eq!(longer.status, 201, "{:?}", longer.body);
    let path = longer.headers[LOCATION].to_str().unwrap().to_owned();
    service.wait_until(&path, "done").await;
    let long = service.runs(&path).await.remove(0);
    let long = format!("/v1/runs/{}", long["id"].as_str().unwrap());
    let curve = |run: String| {
        let service = &service;
        async move { service.get(&format!("{run}/curve")).await.json() }
    };
    let (short, long) = (curve(run).await, curve(long).await);
    assert_eq!(
        (
            short.as_array().unwrap().len(),
            long.as_array().unwrap().len()
        ),
        (3, 7)
    );
    assert_eq!(short.as_array().unwrap()[..], long.as_array().unwrap()[..3]);
}

#[tokio::test]
async fn a_priority_is_a_small_number() {
    let service = Service::start(None);
    let (path, _) = begun(&service).await;
    let ask = |priority: Value| {
        let (service, path) = (&service, format!("{path}/priority"));
        async move { service.post(&path, &json!({ "priority": priority })).await }
    };
    let answer = ask(json!(-7)).await;
    assert_eq!(
        (answer.status, &answer.json()["priority"]),
        (200, &json!(-7))
    );
    assert_eq!(service.get(&path).await.json()["priority"], -7);
    for wrong in [json!(1_001), json!("high"), json!(0.5)] {
        assert_problem(&ask(wrong).await, 422);
    }
}
