//! Runs looked at on the way, documents looked at before they are posted, groups laid over each
//! other.

use futures_util::StreamExt;

use super::*;
use crate::documents::{BuiltinArenas, resolve};

/// The messages of a stream as they come, split by their lengths.
struct Messages {
    parts: axum::body::BodyDataStream,
    held: Vec<u8>,
}

impl Messages {
    async fn of(service: &Service, run: &str) -> Self {
        let request = request("GET", &format!("{run}/frames"));
        let request = request.body(Body::empty()).unwrap();
        let response = service.routes.clone().oneshot(request).await.unwrap();
        assert_eq!(response.status(), 200);
        assert_eq!(response.headers()[CONTENT_TYPE], "application/octet-stream");
        Self {
            parts: response.into_body().into_data_stream(),
            held: Vec::new(),
        }
    }

    /// Kind and body of the next; `None` at the end.
    async fn next(&mut self) -> Option<(u32, Vec<u8>)> {
        let number = |bytes: &[u8]| u32::from_le_bytes(bytes[..4].try_into().unwrap());
        loop {
            if self.held.len() >= 8 {
                let end = 4 + number(&self.held) as usize;
                if self.held.len() >= end {
                    let rest = self.held.split_off(end);
                    let message = std::mem::replace(&mut self.held, rest);
                    return Some((number(&message[4..]), message[8..].to_vec()));
                }
            }
            let wait = tokio::time::timeout(Duration::from_secs(60), self.parts.next());
            let part = wait.await.unwrap()?.unwrap();
            self.held.extend_from_slice(&part);
        }
    }
}

fn learner(epochs: u32) -> Value {
    json!({ "base": {
        "arena": "easy", "seed": 5, "robots": 3, "placement": "grid",
        "controller": { "method": "im", "babbling_epochs": 1 },
        "epochs": epochs, "steps_per_epoch": 200,
    }})
}

async fn only_run(service: &Service, job: &str) -> String {
    let id = service.runs(job).await[0]["id"].clone();
    format!("/v1/runs/{}", id.as_str().unwrap())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_run_is_seen_and_asked_and_none_the_worse_for_it() {
    let service = Service::start(None);
    let path = service.job(&learner(4_000)).await;
    let run = only_run(&service, &path).await;
    let mut messages = Messages::of(&service, &run).await;
    assert_eq!(messages.next().await.unwrap().0, 0);
    let (mut frames, mut squares, mut last_step) = (0, 0, 0.0);
    let mut asked = false;
    while let Some((kind, body)) = messages.next().await {
        match kind {
            1 => {
                assert_eq!(body.len(), 56 + 3 * 40);
                let step = f64::from_le_bytes(body[..8].try_into().unwrap());
                assert!(step >= last_step, "{step} after {last_step}");
                last_step = step;
                frames += 1;
                if frames == 3 {
                    let learnt = service.get(&format!("{run}/learnt?robot=2")).await;
                    assert_eq!(learnt.status, 200, "{:?}", learnt.body);
                    let learnt = learnt.json();
                    assert_eq!(
                        (&learnt["robot"], &learnt["is_live"]),
                        (&json!(2), &json!(true))
                    );
                    assert!(learnt["bytes"].as_u64() <= learnt["most_bytes"].as_u64());
                    let learning = service.get(&format!("{run}/learning?limit=2")).await.json();
                    assert_eq!(
                        (&learning["is_live"], &learning["next"], &learning["model"]),
                        (&json!(true), &json!("2"), &Value::Null)
                    );
                    let robots = learning["items"].as_array().unwrap();
                    let most = learning["memory"]["plan"]["bytes"].as_u64();
                    let holds = |robot: &Value| robot["bytes"].as_u64() <= most;
                    assert!(robots.len() == 2 && robots.iter().all(holds), "{learning}");
                    asked = true;
                }
            }
            2 => {
                assert_eq!(body.len(), 16 + 2 * 4 * 10_000);
                squares += 1;
            }
            _ => {}
        }
    }
    assert!(frames > 2 && squares > 0 && asked, "{frames} {squares}");
    // The last picture is the last step: one epoch of babbling, then those that count.
    assert_eq!(last_step, 4_001.0 * 200.0);
    let result = service.get(&format!("{run}/result")).await.json();
    let resolved = resolve(&learner(4_000)["base"], &BuiltinArenas).unwrap();
    let mut unseen = swarm::run::Run::new(resolved.run_spec()).unwrap();
    unseen.advance(u64::MAX);
    let unseen = unseen.outcome().unwrap();
    assert_eq!(result["state_sha256"], unseen.state_sha256);

    let arena = service.get(&format!("{run}/arena?of=training")).await;
    assert_eq!(arena.status, 200, "{:?}", arena.body);
    assert_eq!(arena.json()["walls_m"].as_array().unwrap().len(), 8);

    // What has ended has no more pictures, and what was learnt at its end.
    let mut over = Messages::of(&service, &run).await;
    assert_eq!(over.next().await.unwrap().0, 0);
    let (kind, covered) = over.next().await.unwrap();
    let number = |at: usize| u32::from_le_bytes(covered[at..at + 4].try_into().unwrap());
    let entered = (0..10_000)
        .filter(|square| number(16 + 4 * square) > 0)
        .count();
    assert_eq!((kind, json!(entered)), (2, result["p1"].clone()));
    assert_eq!(over.next().await, None);
    let last = service.get(&format!("{run}/learnt?robot=1")).await.json();
    assert_eq!(
        (&last["is_live"], &last["phase"]),
        (&json!(false), &json!("done"))
    );
    assert!(last["table"]["counts"].is_array(), "{last}");
    let page = format!("{run}/learning?limit=2&cursor=1");
    let learning = service.get(&page).await.json();
    let robots = learning["items"].as_array().unwrap();
    let numbers: Vec<&Value> = robots.iter().map(|robot| &robot["robot"]).collect();
    assert_eq!(numbers, [&json!(1), &json!(2)]);
    for field in ["sensor_clusters", "actuator_clusters", "bytes"] {
        assert_eq!(robots[0][field], last[field], "{field}");
    }
    assert_eq!(
        (&learning["phase"], &learning["next"]),
        (&json!("done"), &Value::Null)
    );
    for field in ["model", "memory", "clusters"] {
        assert_eq!(learning[field], result[field], "{field}");
    }
    assert!(learning["model"]["pairs"].as_u64() > Some(0), "{learning}");
    // Once its last state is not kept, what its result tells.
    std::fs::remove_dir_all(service.dir.path().join("finals")).unwrap();
    let rest = service.get(&page).await.json();
    assert_eq!(
        (&rest["items"], &rest["arena_step"]),
        (&json!([]), &Value::Null)
    );
    for field in [
        "run_id",
        "model",
        "memory",
        "clusters",
        "robots",
        "phase",
        "epochs_done",
    ] {
        assert_eq!(rest[field], learning[field], "{field}");
    }
    let reach = service.get(&format!("{run}/reach")).await.json();
    assert_eq!(reach["reachable"], result["reachable"]);
    let rows = reach["reachable_rows"].as_array().unwrap();
    let within = rows
        .iter()
        .map(|row| row.as_str().unwrap().matches('1').count());
    assert_eq!(
        (rows.len(), json!(within.sum::<usize>())),
        (100, result["reachable"].clone())
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_run_covered_that_ended_between_two_looks_is_told() {
    let service = Service::start(None);
    let endless = service.job(&job(1_000_000, 1)).await;
    // As soon as it has the worker it is over.
    let short = service.job(&job(2, 1)).await;
    let run = only_run(&service, &short).await;
    let mut messages = Messages::of(&service, &run).await;
    while messages.next().await.unwrap().0 != 3 {}
    let cancelled = service.ask("POST", &format!("{endless}/cancel")).await;
    assert_eq!(cancelled.status, 200);
    let mut covered = Vec::new();
    while let Some((kind, body)) = messages.next().await {
        if kind == 2 {
            covered = body;
        }
    }
    assert_eq!(covered[..8], 400.0_f64.to_le_bytes());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_was_learnt_is_told_of_a_paused_run_and_refused_where_nothing_is() {
    let service = Service::start(None);
    let path = service.job(&learner(1_000_000)).await;
    let run = only_run(&service, &path).await;
    // Until the first epoch that counts, so that there is a table.
    let start = Instant::now();
    while service.get(&run).await.json()["progress"]["epochs_done"].as_u64() < Some(1) {
        assert!(start.elapsed() < Duration::from_secs(60));
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    assert_eq!(
        service.ask("POST", &format!("{run}/pause")).await.status,
        200
    );
    service.wait_until(&path, "paused").await;
    // The worker lets go at the end of a block; until then the answer may be live.
    let learnt = loop {
        let learnt = service.get(&format!("{run}/learnt?robot=1")).await.json();
        if learnt["is_live"] == false {
            break learnt;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "{learnt}");
    };
    let table = &learnt["table"];
    let (counts, score) = (&table["counts"], &table["score"]);
    let states = learnt["sensor_clusters"].as_u64().unwrap() as usize;
    let actions = learnt["actuator_clusters"].as_u64().unwrap() as usize;
    for list in [counts, score, &table["entropy"]] {
        assert_eq!(list.as_array().unwrap().len(), states);
        assert_eq!(list[0].as_array().unwrap().len(), actions);
    }
    assert!(table["state"].as_u64() < Some(states as u64));
    assert_eq!(table["states"][0].as_array().unwrap().len(), 8);
    let learning = service.get(&format!("{run}/learning")).await.json();
    assert_eq!(
        (
            &learning["is_live"],
            &learning["arena_step"],
            &learning["phase"]
        ),
        (&json!(false), &learnt["arena_step"], &learnt["phase"])
    );
    assert_eq!(learning["items"][1]["bytes"], learnt["bytes"]);
    for (robot, status) in [("3", 409), ("-1", 400), ("x", 400)] {
        let answer = service.get(&format!("{run}/learnt?robot={robot}")).await;
        assert_problem(&answer, status);
    }
    let mut waits = Messages::of(&service, &run).await;
    for kind in [0, 2, 3] {
        assert_eq!(waits.next().await.unwrap().0, kind);
    }

    let walks = service.job(&job(1_000_000, 1)).await;
    let walker = only_run(&service, &walks).await;
    let nothing = "what a robot has learnt by a method that learns nothing";
    for what in ["learnt", "learning"] {
        assert_refused(&service.get(&format!("{walker}/{what}")).await, nothing);
    }
    assert_eq!(
        service
            .ask("POST", &format!("{walker}/cancel"))
            .await
            .status,
        200
    );
    let not_kept = "what a cancelled run covered";
    for what in ["learnt", "learning"] {
        assert_refused(&service.get(&format!("{walker}/{what}")).await, not_kept);
    }
}

#[tokio::test]
async fn arenas_and_jobs_are_checked_without_being_stored() {
    let service = Service::start(None);
    let arena = json!({
        "name": "gates", "width_m": 1.0, "height_m": 0.5, "squares": [20, 10],
        "walls_m": [[0.5, 0.0, 0.5, 0.2], [0.5, 0.27, 0.5, 0.5]],
        "starts": [{ "x_m": 0.2, "y_m": 0.2, "heading_rad": 0.0 }],
    });
    let checked = service.post("/v1/checks/arena", &arena).await;
    assert_eq!(checked.status, 200, "{:?}", checked.body);
    let checked = checked.json();
    let rows = checked["reachable_rows"].as_array().unwrap();
    assert_eq!((rows.len(), rows[0].as_str().unwrap().len()), (10, 20));
    let within: usize = rows
        .iter()
        .map(|row| row.as_str().unwrap().matches('1').count())
        .sum();
    assert_eq!(checked["arena"]["reachable"], within);
    // The gate of 70 mm is too narrow for a robot of 74 mm: the right half cannot be reached.
    assert!(
        rows.iter()
            .all(|row| row.as_str().unwrap().ends_with("000000000"))
    );
    let gate = &checked["gates"][0];
    assert_eq!(gate["is_open"], false);
    assert!(
        (gate["width_m"].as_f64().unwrap() - 0.07).abs() < 1e-9,
        "{gate}"
    );
    assert_eq!(service.get("/v1/arenas/gates").await.status, 404);

    let asked = job(10, 3);
    let checked = service.post("/v1/checks/job", &asked).await;
    assert_eq!(checked.status, 200, "{:?}", checked.body);
    let checked = checked.json();
    assert_eq!(checked["runs"], 3);
    assert_eq!(checked["combinations"], 1);
    assert_eq!(checked["robot_steps"], 3 * 10 * 200);
    assert_eq!(checked["is_measured"], false);
    let stored = service.job(&asked).await;
    service.wait_until(&stored, "done").await;
    let again = service.post("/v1/checks/job", &asked).await.json();
    assert_eq!(again["is_measured"], true);
    assert!(again["time_s"].as_f64().unwrap() > 0.0);
    let all = service.get("/v1/jobs").await.json();
    assert_eq!(all["items"].as_array().unwrap().len(), 1);

    let wrong = "a check of an arena or a job that is not valid";
    let mut outside = arena.clone();
    outside["walls_m"][0][0] = json!(3.0);
    let refused = service.post("/v1/checks/arena", &outside).await;
    assert_refused(&refused, wrong);
    assert_eq!(refused.json()["errors"][0]["pointer"], "/walls_m/0");
    let refused = service.post("/v1/checks/job", &job(0, 1)).await;
    assert_refused(&refused, wrong);
    assert_eq!(refused.json()["errors"][0]["pointer"], "/base/epochs");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_runs_of_a_group_are_laid_over_each_other() {
    let service = Service::start(None);
    let mut asked = job(3, 3);
    asked["matrix"] = json!({ "controller.method": ["brownian", "levy"] });
    let path = service.job(&asked).await;
    service.wait_until(&path, "done").await;
    let runs = service.runs(&path).await;
    let mut entered = vec![0; 10_000];
    for run in &runs[3..6] {
        let id = run["id"].as_str().unwrap();
        let coverage = service.get(&format!("/v1/runs/{id}/coverage")).await.json();
        let rows = coverage["visits"].as_array().unwrap();
        let visits = rows.iter().flat_map(|row| row.as_array().unwrap());
        for (count, visits) in entered.iter_mut().zip(visits) {
            *count += u64::from(visits.as_u64() > Some(0));
        }
    }
    let pooled = service
        .get(&format!("{path}/coverage?group=1"))
        .await
        .json();
    assert_eq!((&pooled["n"], &pooled["groups"]), (&json!(3), &json!(2)));
    let rows = pooled["runs"].as_array().unwrap();
    let told: Vec<u64> = rows
        .iter()
        .flat_map(|row| row.as_array().unwrap())
        .map(|runs| runs.as_u64().unwrap())
        .collect();
    assert_eq!(told, entered);
    let union = entered.iter().filter(|&&runs| runs > 0).count();
    assert_eq!(pooled["union_squares"], union);
    let by = service
        .get(&format!("{path}/coverage?by=controller.method"))
        .await;
    assert_eq!(by.json()["label"], "brownian");
    for wrong in ["group=2", "group=-1", "by=seed"] {
        assert_problem(&service.get(&format!("{path}/coverage?{wrong}")).await, 400);
    }
}
