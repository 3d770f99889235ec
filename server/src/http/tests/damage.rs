//! Stored data that cannot be used is told as such, never as numbers.

use super::*;

const DAMAGED: &str = "a stored spec or checkpoint that is damaged";

#[tokio::test]
async fn a_summary_counts_no_broken_spec_as_one_robot() {
    let service = Service::start(None);
    let mut body = job(1, 2);
    body["base"]["robots"] = json!(3);
    body["base"]["placement"] = json!("grid");
    let path = service.job(&body).await;
    service.wait_until(&path, "done").await;
    let summary = service.get(&format!("{path}/summary")).await.json();
    assert_eq!(summary["groups"][0]["robots"], 3);
    let database = rusqlite::Connection::open(service.dir.path().join("evswarm.sqlite3")).unwrap();
    for broken in [
        "json_remove(spec, '$.robots')",
        "'{'",
        "'{\"robots\": 0.5}'",
    ] {
        database
            .execute(&format!("UPDATE runs SET spec = {broken}"), [])
            .unwrap();
        let refused = service.get(&format!("{path}/summary")).await;
        assert_refused(&refused, DAMAGED);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_damaged_checkpoint_is_not_shown_as_zeros() {
    let service = Service::start(None);
    let path = service.job(&job(1_000_000, 1)).await;
    let run = service.runs(&path).await[0]["id"].clone();
    let coverage = format!("/v1/runs/{}/coverage", run.as_str().unwrap());
    let start = Instant::now();
    let visited = |answer: &Answer| answer.status == 200 && answer.json()["p1"] != 0;
    while !visited(&service.get(&coverage).await) {
        assert!(start.elapsed() < Duration::from_secs(60));
    }
    service.post(&format!("{path}/pause"), &json!({})).await;
    // The checkpoint is written just after the state.
    let checkpoints = service.dir.path().join("checkpoints");
    let refused = loop {
        for file in std::fs::read_dir(&checkpoints).unwrap() {
            let file = file.unwrap().path();
            if file.to_string_lossy().contains(run.as_str().unwrap()) {
                std::fs::write(&file, b"nonsense").unwrap();
            }
        }
        let answer = service.get(&coverage).await;
        if answer.status != 200 {
            break answer;
        }
        assert!(start.elapsed() < Duration::from_secs(60));
        tokio::time::sleep(Duration::from_millis(10)).await;
    };
    assert_refused(&refused, DAMAGED);
}
