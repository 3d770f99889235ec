//! What is watched while the load goes on: health, how long progress stands still, steps done.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use tokio::sync::watch;

use crate::client::Client;

/// Health asked again and again, on a connection of its own each time.
#[derive(Debug, Default)]
pub struct Health {
    /// Times of the answers.
    pub took: Vec<Duration>,
    /// Answers that were not 200, or did not come.
    pub failed: u64,
}

/// Asks for health every 50 ms until told to stop.
pub async fn health(address: SocketAddr, mut stop: watch::Receiver<bool>) -> Health {
    let mut seen = Health::default();
    while !*stop.borrow_and_update() {
        match Client::new(address).get("/health/livez").await {
            Ok(answer) if answer.status == 200 => seen.took.push(answer.took),
            _ => seen.failed += 1,
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    seen
}

/// Robot-steps that the runs of a job have done, and the longest that any running one stood still.
#[derive(Clone, Copy, Debug, Default)]
pub struct Progress {
    /// Robot-steps done when it was first and last asked.
    pub robot_steps: [u64; 2],
    /// Time between the two.
    pub over: Duration,
    /// Longest time in which the progress shown of a run did not change.
    pub stood_still: Duration,
}

impl Progress {
    /// Robot-steps a second.
    pub fn rate(&self) -> f64 {
        (self.robot_steps[1] - self.robot_steps[0]) as f64 / self.over.as_secs_f64()
    }
}

/// Looks at the running runs of a job every 100 ms until told to stop.
pub async fn progress(
    address: SocketAddr,
    job: u64,
    mut stop: watch::Receiver<bool>,
) -> Result<Progress> {
    let mut client = Client::new(address);
    let path = format!("/v1/jobs/{job}/runs?limit=20");
    let started = Instant::now();
    let mut last: Vec<(u64, Instant)> = Vec::new();
    let mut seen = Progress::default();
    let mut first = true;
    while !*stop.borrow_and_update() {
        let answer = client.get(&path).await?;
        if answer.status == 503 {
            // Beyond the limit of clients: the next look tells more.
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        }
        let page = answer.json()?;
        let now = Instant::now();
        let steps: Vec<u64> = page["items"]
            .as_array()
            .context("a page of runs")?
            .iter()
            .map(|run| run["progress"]["robot_steps_done"].as_u64().unwrap_or(0))
            .collect();
        last.resize(steps.len(), (0, now));
        for (last, &steps) in last.iter_mut().zip(&steps) {
            if last.0 != steps {
                if last.0 != 0 {
                    seen.stood_still = seen.stood_still.max(now - last.1);
                }
                *last = (steps, now);
            }
        }
        let sum = steps.iter().sum();
        if std::mem::take(&mut first) {
            seen.robot_steps[0] = sum;
        }
        seen.robot_steps[1] = sum;
        seen.over = started.elapsed();
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    Ok(seen)
}
