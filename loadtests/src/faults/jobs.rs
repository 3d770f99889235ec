//! Jobs of all kinds, how one is brought to its end, and what its runs came to.

use std::collections::BTreeMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use crate::client::Client;

/// Digests of what runs came to, by id.
pub type Findings = BTreeMap<String, String>;

/// How many kinds of runs there are.
pub const KINDS: usize = 8;
/// Seeds that the jobs of a generation together use of each kind.
pub const SEEDS: u64 = 8;
/// Longest that a job may take to its end.
const LIMIT: Duration = Duration::from_secs(600);

/// A run of this kind: methods, engines, swarms, objects, sharing, budgets. It takes about half a
/// second, so that most kills hit some that are under way.
fn base(kind: usize) -> Value {
    match kind {
        0 => json!({ "arena": "maze", "controller": { "method": "brownian" }, "epochs": 9_000 }),
        1 => json!({ "arena": "easy", "controller": { "method": "im" }, "epochs": 2_400 }),
        2 => json!({ "arena": "graph", "epochs": 1_800,
            "controller": { "method": "ev-iter-c", "train": { "arena": "easy", "epochs": 60 } } }),
        3 => json!({ "arena": "maze", "epochs": 1_800,
            "controller": { "method": "curiosity", "train": { "arena": "easy" } } }),
        4 => json!({ "arena": "easy", "controller": { "method": "levy" }, "robots": 4,
            "placement": "grid", "episodes": "continue", "epochs": 1_200 }),
        5 => json!({ "arena": { "from": "easy", "tile": [2, 2] }, "robots": 8,
            "placement": "random", "controller": { "method": "im" }, "sharing": { "mode": "arena" },
            "epochs": 240 }),
        6 => json!({ "engine": "rapier", "robots": 2, "epochs": 120, "steps_per_epoch": 500,
            "arena": { "name": "boxes", "width_m": 0.8, "height_m": 0.8, "walls_m": [],
                "starts": [{ "x_m": 0.2, "y_m": 0.2, "heading_rad": 0.7 },
                           { "x_m": 0.6, "y_m": 0.2, "heading_rad": 2.0 }],
                "objects": [{ "kind": "box", "x_m": 0.4, "y_m": 0.5, "width_m": 0.08,
                    "height_m": 0.08, "mass_kg": 0.1 }] },
            "controller": { "method": "brownian" } }),
        _ => json!({ "arena": "maze", "memory_budget_bytes": "e-puck", "epochs": 1_200,
            "controller": { "method": "ev-iter-da", "train": { "arena": "easy", "epochs": 30 } } }),
    }
}

/// All runs of a kind in a generation.
pub fn whole(kind: usize, generation: u64) -> String {
    job(kind, generation, 1, SEEDS)
}

/// A job of `count` runs of a kind, from a place among the seeds of a generation on, counted from 1.
/// A generation has runs of its own, so that there is work to disturb until the last kill.
pub fn job(kind: usize, generation: u64, first: u64, count: u64) -> String {
    json!({ "name": format!("kind {kind}"), "base": base(kind),
        "seeds": { "first": generation * SEEDS + first, "count": count } })
    .to_string()
}

/// Runs of a job: id and state.
pub async fn runs(client: &mut Client, job: u64) -> Result<Vec<(String, String)>> {
    let page = client
        .get(&format!("/v1/jobs/{job}/runs?limit=100"))
        .await?
        .json()?;
    let items = page["items"]
        .as_array()
        .with_context(|| format!("the runs of job {job}: {page}"))?;
    let text = |value: &Value| value.as_str().map(str::to_owned).context("a text");
    items
        .iter()
        .map(|run| Ok((text(&run["id"])?, text(&run["state"])?)))
        .collect()
}

/// Resumes and retries what is held or ended, and waits until all runs are done.
pub async fn bring_to_end(client: &mut Client, job: u64) -> Result<()> {
    let started = Instant::now();
    loop {
        let runs = runs(client, job).await?;
        if runs.iter().all(|(_, state)| state == "done") {
            return Ok(());
        }
        ensure!(
            started.elapsed() < LIMIT,
            "job {job} does not end: {runs:?}"
        );
        for (id, state) in &runs {
            let action = match state.as_str() {
                "paused" => "resume",
                "cancelled" | "failed" => "retry",
                _ => continue,
            };
            client
                .post(&format!("/v1/runs/{id}/{action}"), None)
                .await?;
        }
        // What other jobs hold goes on for this one once it is active.
        for action in ["retry", "resume"] {
            client
                .post(&format!("/v1/jobs/{job}/{action}"), None)
                .await?;
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

/// Digests of everything that the runs of a job found.
pub async fn findings(client: &mut Client, job: u64) -> Result<Findings> {
    let mut found = Findings::new();
    for (id, _) in runs(client, job).await? {
        let mut hasher = DefaultHasher::new();
        for file in [
            "result",
            "curve.csv",
            "metrics.csv",
            "robots.csv",
            "coverage.npy",
            "dwell.npy",
        ] {
            let answer = client.get(&format!("/v1/runs/{id}/{file}")).await?;
            ensure!(answer.status == 200, "{id}/{file}: {}", answer.status);
            answer.body.hash(&mut hasher);
        }
        found.insert(id, format!("{:016x}", hasher.finish()));
    }
    Ok(found)
}
