//! Routes as a client sees them: status, media type, body; no socket in between.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod access;
mod contract;
mod control;
mod damage;
mod deleted_runs;
mod exports;
mod forks;
mod jobs;
mod listeners;
mod objects;
mod openapi;
mod operations;
mod report;
mod watching;

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::{Body, Bytes, to_bytes};
use axum::http::header::{
    AUTHORIZATION, CONTENT_TYPE, ETAG, HOST, IF_NONE_MATCH, LOCATION, ORIGIN,
};
use axum::http::request::Builder;
use axum::http::{HeaderMap, Request};
use serde_json::{Value, json};
use tower::ServiceExt;

use super::access::Tokens;
use super::router::router;
use super::*;
use crate::channels::ChannelSettings;
use crate::scheduler::{Scheduler, SchedulerConfig};
use crate::store::Store;

struct Service {
    routes: Router,
    dir: tempfile::TempDir,
}

struct Answer {
    status: u16,
    headers: HeaderMap,
    body: Bytes,
}

impl Answer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    fn media_type(&self) -> &str {
        self.headers[CONTENT_TYPE].to_str().unwrap()
    }
}

impl Service {
    fn start(token: Option<&str>) -> Self {
        let tokens = token.map_or_else(Tokens::default, |token| {
            Tokens::default().with_secret(token).unwrap()
        });
        Self::start_with(tokens)
    }

    fn start_with(tokens: Tokens) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let store = Arc::new(Store::open(dir.path()).unwrap());
        let config = SchedulerConfig {
            workers: NonZeroUsize::MIN,
            unfinished_limit: 10,
            run_memory_bytes: 1 << 30,
            keep_every_epochs: None,
            recordings: crate::recording::Limits::DEFAULT,
            channels: ChannelSettings::default(),
        };
        let scheduler = Arc::new(Scheduler::start(Arc::clone(&store), config).unwrap());
        Self {
            routes: router(store, scheduler, tokens),
            dir,
        }
    }

    async fn send(&self, request: Builder, body: impl Into<Body>) -> Answer {
        let request = request.body(body.into()).unwrap();
        let response = self.routes.clone().oneshot(request).await.unwrap();
        let (parts, body) = response.into_parts();
        let body = to_bytes(body, usize::MAX).await.unwrap();
        Answer {
            status: parts.status.as_u16(),
            headers: parts.headers,
            body,
        }
    }

    async fn ask(&self, method: &str, path: &str) -> Answer {
        self.send(request(method, path), Body::empty()).await
    }

    async fn get(&self, path: &str) -> Answer {
        self.ask("GET", path).await
    }

    async fn post(&self, path: &str, body: &Value) -> Answer {
        let request = request("POST", path).header(CONTENT_TYPE, "application/json");
        self.send(request, body.to_string()).await
    }

    /// Posts a job and returns its route.
    async fn job(&self, job: &Value) -> String {
        let answer = self.post("/v1/jobs", job).await;
        assert_eq!(answer.status, 201, "{:?}", answer.body);
        answer.headers[LOCATION].to_str().unwrap().to_owned()
    }

    async fn runs(&self, job: &str) -> Vec<Value> {
        self.get(&format!("{job}/runs")).await.json()["items"]
            .as_array()
            .unwrap()
            .clone()
    }

    async fn wait_until(&self, job: &str, state: &str) -> Value {
        let start = Instant::now();
        loop {
            let shown = self.get(job).await.json();
            if shown["state"] == state {
                return shown;
            }
            assert!(start.elapsed() < Duration::from_secs(120), "{shown}");
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }
}

fn request(method: &str, path: &str) -> Builder {
    Request::builder()
        .method(method)
        .uri(path)
        .header(HOST, "127.0.0.1:8080")
}

fn job(epochs: u32, seeds: u32) -> Value {
    json!({
        "name": "a job",
        "base": {
            "arena": "easy", "controller": { "method": "brownian" },
            "epochs": epochs, "steps_per_epoch": 200,
        },
        "seeds": { "first": 1, "count": seeds },
    })
}

/// That the answer is what this row of the table of refusals says.
fn assert_refused(answer: &Answer, what: &str) {
    let code = api::refusals::refused(what).unwrap().problem.unwrap();
    assert_problem(answer, code.status());
    assert_eq!(answer.json()["code"], code.code(), "{what}");
}

fn assert_problem(answer: &Answer, status: u16) {
    let body = String::from_utf8_lossy(&answer.body);
    assert_eq!(
        (answer.status, answer.media_type()),
        (status, "application/problem+json"),
        "{body}"
    );
    let problem: api::Problem = serde_json::from_slice(&answer.body).unwrap();
    assert_eq!(problem.status, status);
    assert!(problem.detail.is_some(), "{body}");
}
