//! What a job says of itself once some of its runs were deleted, or others came to it.

use super::*;

const FINDINGS: [&str; 11] = [
    "summary",
    "summary.csv",
    "summary.md",
    "comparison",
    "comparison.csv",
    "comparison.md",
    "curves",
    "runs.csv",
    "runs.parquet",
    "curves.parquet",
    "metrics.parquet",
];

async fn delete(service: &Service, run: &Value) {
    let path = format!("/v1/runs/{}", run["id"].as_str().unwrap());
    assert_eq!(service.ask("DELETE", &path).await.status, 204);
}

async fn all_are_given(service: &Service, job: &str) {
    for name in FINDINGS {
        let answer = service.get(&format!("{job}/{name}")).await;
        let body = String::from_utf8_lossy(&answer.body);
        assert_eq!(answer.status, 200, "{name}: {body}");
    }
}

/// `runs`, `runs_done` and the mean of `p1` of each group, beside what its runs say.
async fn groups(service: &Service, job: &str) -> Vec<(u64, u64, Option<f64>)> {
    all_are_given(service, job).await;
    let runs = service.runs(job).await;
    let summary = service.get(&format!("{job}/summary")).await.json();
    let groups = summary["groups"].as_array().unwrap().iter().enumerate();
    let mut told = Vec::new();
    for (number, group) in groups {
        let own = runs.iter().filter(|run| run["label"] == group["label"]);
        let p1: Vec<f64> = own
            .map(|run| run["result"]["p1"].as_f64().unwrap())
            .collect();
        let mean = (!p1.is_empty()).then(|| p1.iter().sum::<f64>() / p1.len() as f64);
        let measures = group["measures"].as_array().unwrap();
        let shown = measures.iter().find(|measure| measure["name"] == "p1");
        let shown = shown.unwrap()["mean"].as_f64();
        let off = shown.unwrap_or(0.0) - mean.unwrap_or(0.0);
        assert!(
            shown.is_some() == mean.is_some() && off.abs() < 1e-9,
            "{group}"
        );
        let path = format!("{job}/coverage?group={number}");
        let coverage = service.get(&path).await;
        let body = String::from_utf8_lossy(&coverage.body);
        assert_eq!(coverage.status, 200, "{path}: {body}");
        assert_eq!(coverage.json()["n"], group["runs_done"]);
        assert_eq!(group["runs"], p1.len());
        let count = |name: &str| group[name].as_u64().unwrap();
        told.push((count("runs"), count("runs_done"), shown));
    }
    told
}

fn counts(groups: &[(u64, u64, Option<f64>)]) -> Vec<u64> {
    groups.iter().map(|&(runs, ..)| runs).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_job_tells_of_the_runs_that_are_left() {
    let service = Service::start(None);
    let mut body = job(3, 2);
    body["matrix"] = json!({ "epochs": [1, 3], "controller.method": ["brownian", "im"] });
    let path = service.job(&body).await;
    service.wait_until(&path, "done").await;
    let runs = service.runs(&path).await;
    let whole = groups(&service, &path).await;
    assert_eq!(counts(&whole), [2, 2, 2, 2]);
    // The last, then the first, then a whole group.
    for (run, left) in [
        (7, [2, 2, 2, 1]),
        (0, [1, 2, 2, 1]),
        (2, [1, 1, 2, 1]),
        (3, [1, 0, 2, 1]),
    ] {
        delete(&service, &runs[run]).await;
        assert_eq!(counts(&groups(&service, &path).await), left);
    }
    let left = groups(&service, &path).await;
    assert_eq!(left[2], whole[2], "nothing of it was deleted");
    let comparison = service.get(&format!("{path}/comparison")).await.json();
    let compared = comparison["groups"].as_array().unwrap();
    let n: Vec<&Value> = compared.iter().map(|group| &group["n"]).collect();
    assert_eq!(n, [1, 0, 2, 1]);

    // New seeds come to the groups that they belong to, and what was deleted stays away.
    let longer = service
        .post(&format!("{path}/extend"), &json!({ "seeds": 1 }))
        .await;
    assert_eq!(longer.status, 200, "{:?}", longer.body);
    service.wait_until(&path, "done").await;
    assert_eq!(counts(&groups(&service, &path).await), [2, 1, 3, 2]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_longer_job_has_its_runs_in_the_groups_that_they_belong_to() {
    let service = Service::start(None);
    let mut body = job(1, 2);
    body["matrix"] = json!({ "epochs": [1, 6] });
    let path = service.job(&body).await;
    service.wait_until(&path, "done").await;
    service
        .post(&format!("{path}/extend"), &json!({ "seeds": 3 }))
        .await;
    service.wait_until(&path, "done").await;
    assert_eq!(counts(&groups(&service, &path).await), [5, 5]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_job_whose_runs_were_all_deleted_is_empty() {
    let service = Service::start(None);
    let mut body = job(1, 2);
    body["parts"] = json!([{ "name": "one" }, { "name": "two", "base": { "epochs": 2 } }]);
    let path = service.job(&body).await;
    service.wait_until(&path, "done").await;
    let runs = service.runs(&path).await;
    for run in &runs[..2] {
        delete(&service, run).await;
    }
    assert_eq!(counts(&groups(&service, &path).await), [0, 2]);
    for run in &runs[2..] {
        delete(&service, run).await;
    }
    assert_eq!(groups(&service, &path).await, [(0, 0, None); 2]);
}
