//! Checkpoints over HTTP: taken, downloaded, uploaded, forked from.

use sha2::{Digest, Sha256};

use super::*;

/// The only run of a job, by its route.
async fn run_of(service: &Service, job: &str) -> String {
    let run = service.runs(job).await.remove(0);
    format!("/v1/runs/{}", run["id"].as_str().unwrap())
}

async fn made(service: &Service, answer: &Answer) -> Value {
    assert_eq!(answer.status, 201, "{:?}", answer.body);
    let job = answer.headers[LOCATION].to_str().unwrap();
    service.wait_until(job, "done").await;
    service.runs(job).await.remove(0)
}

async fn put(service: &Service, path: &str, bytes: Vec<u8>) -> Answer {
    service.send(request("PUT", path), bytes).await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_checkpoint_goes_to_another_server_and_on_from_there() {
    let here = Service::start(None);
    let path = here.job(&job(1_000_000, 1)).await;
    let run = run_of(&here, &path).await;
    here.wait_until(&run, "running").await;
    let taken = here.ask("POST", &format!("{run}/checkpoint")).await;
    assert_eq!(taken.status, 200, "{:?}", taken.body);
    assert_eq!(here.ask("POST", &format!("{run}/pause")).await.status, 200);
    here.wait_until(&run, "paused").await;
    let taken = here.ask("POST", &format!("{run}/checkpoint")).await.json();
    let file = here.get(&format!("{run}/checkpoint")).await;
    assert_eq!(
        (file.status, file.media_type()),
        (200, "application/octet-stream")
    );

    let epochs = taken["epochs_done"].as_u64().unwrap() + 2;
    let fork = json!({ "changes": { "epochs": epochs } });
    let forked = here.post(&format!("{run}/fork"), &fork).await;
    let forked = made(&here, &forked).await;
    assert_eq!(
        forked["origin"]["checkpoint_sha256"],
        taken["checkpoint_sha256"]
    );
    assert_eq!(forked["origin"]["uploaded"], false);

    // The other one has the run by its spec alone.
    let there = Service::start(None);
    let other = there.job(&job(1_000_000, 1)).await;
    assert_eq!(run_of(&there, &other).await, run);
    assert_eq!(
        there.ask("POST", &format!("{other}/pause")).await.status,
        200
    );
    let uploaded = put(&there, &format!("{run}/checkpoint"), file.body.to_vec()).await;
    assert_eq!(uploaded.status, 201, "{:?}", uploaded.body);
    let shown = there
        .runs(uploaded.headers[LOCATION].to_str().unwrap())
        .await
        .remove(0);
    assert_eq!(shown["origin"]["uploaded"], true);
    assert_ne!(format!("/v1/runs/{}", shown["id"].as_str().unwrap()), run);
    let theirs = format!("/v1/runs/{}", shown["id"].as_str().unwrap());
    there.wait_until(&theirs, "running").await;
    assert_eq!(
        there.ask("POST", &format!("{theirs}/cancel")).await.status,
        200
    );
}

/// Jobs of forks were stored without saying that they are one group, and taken for damaged.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_job_of_a_fork_has_a_summary() {
    let service = Service::start(None);
    let path = service.job(&job(3, 1)).await;
    service.wait_until(&path, "done").await;
    let run = run_of(&service, &path).await;
    let fork = json!({ "changes": { "epochs": 5 } });
    let forked = service.post(&format!("{run}/fork"), &fork).await;
    made(&service, &forked).await;
    let job = forked.headers[LOCATION].to_str().unwrap();
    for route in ["summary", "curves", "comparison", "coverage"] {
        let answer = service.get(&format!("{job}/{route}")).await;
        assert_eq!(answer.status, 200, "{route}: {:?}", answer.body);
    }
    let summary = service.get(&format!("{job}/summary")).await.json();
    assert_eq!(summary["groups"][0]["runs_done"], 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_foreign_or_altered_checkpoint_is_refused() {
    let service = Service::start(None);
    let path = service.job(&job(3, 2)).await;
    service.wait_until(&path, "done").await;
    let ids: Vec<String> = service
        .runs(&path)
        .await
        .iter()
        .map(|run| run["id"].as_str().unwrap().to_owned())
        .collect();
    let route = |id: &str| format!("/v1/runs/{id}/checkpoint");
    for wrong in ["application/json", "text/plain", "é"] {
        let said = request("PUT", &route(&ids[0])).header(CONTENT_TYPE, wrong);
        let answer = service.send(said, b"{}".to_vec()).await;
        let what = "a checkpoint that is said to be something else than bytes";
        assert_refused(&answer, what);
    }
    let said = request("PUT", &route(&ids[0])).header(CONTENT_TYPE, "Application/Octet-Stream");
    assert_eq!(service.send(said, b"{}".to_vec()).await.status, 422);
    let whole = service.get(&route(&ids[0])).await.body.to_vec();
    let refused = "a checkpoint that is foreign, altered or of another version";
    let foreign = put(&service, &route(&ids[1]), whole.clone()).await;
    assert_refused(&foreign, refused);
    assert_refused(
        &put(&service, &route(&ids[0]), b"EVSWCP04".to_vec()).await,
        refused,
    );
    assert_refused(&put(&service, &route(&ids[0]), Vec::new()).await, refused);
    for place in (0..whole.len()).step_by(whole.len() / 40) {
        let mut altered = whole.clone();
        altered[place] ^= 0x20;
        assert_refused(&put(&service, &route(&ids[0]), altered).await, refused);
        let cut = whole[..place].to_vec();
        assert_refused(&put(&service, &route(&ids[0]), cut).await, refused);
    }
    // Altered with digests that fit: never a panic, and never taken for what the run itself did.
    let state_at = whole
        .windows(8)
        .rposition(|bytes| bytes == b"evswarm4")
        .unwrap();
    let state = &whole[state_at..];
    // Magic, digest and state; behind it what came later, with a length at its end.
    let later = u64::from_le_bytes(state[state.len() - 16..state.len() - 8].try_into().unwrap());
    let end = state.len() - 48 - later as usize;
    for place in (40..end).step_by(end / 60) {
        let mut altered = state.to_vec();
        altered[place] ^= 0x11;
        let digest = Sha256::digest(&altered[40..end]);
        altered[8..40].copy_from_slice(&digest);
        let mut file = whole[..state_at - 40].to_vec();
        file.extend_from_slice(&Sha256::digest(&altered));
        file.extend_from_slice(&(altered.len() as u64).to_le_bytes());
        file.extend_from_slice(&altered);
        let answer = put(&service, &route(&ids[0]), file).await;
        assert!(
            [201, 422].contains(&answer.status),
            "{place}: {:?}",
            answer.body
        );
    }
    assert_eq!(service.get("/health/livez").await.status, 200);
}

#[tokio::test]
async fn a_run_without_a_state_says_so() {
    let service = Service::start(None);
    let path = service.job(&job(1_000_000, 2)).await;
    let waiting = service.runs(&path).await.remove(1);
    let run = format!("/v1/runs/{}", waiting["id"].as_str().unwrap());
    let what = "the state of a run of which none is kept";
    assert_refused(&service.get(&format!("{run}/checkpoint")).await, what);
    let asked = service.ask("POST", &format!("{run}/checkpoint")).await;
    assert_refused(&asked, what);
    let fork = json!({ "changes": { "epochs": 5 } });
    assert_refused(&service.post(&format!("{run}/fork"), &fork).await, what);
    let wrong = json!({ "changes": { "robots": 2 } });
    let refused = service.post(&format!("{run}/fork"), &wrong).await;
    assert_refused(&refused, "a fork that changes what its state was made with");
    assert_eq!(refused.json()["errors"][0]["pointer"], "/changes/robots");
    for wrong in [
        json!({ "epok": 1 }),
        json!({ "epoch": -1 }),
        json!({ "changes": 3 }),
    ] {
        assert_problem(&service.post(&format!("{run}/fork"), &wrong).await, 422);
    }
}
