//! What handlers share, and how they reach it without blocking.

use std::sync::Arc;

use api::ProblemCode;
use axum::Json;
use axum::http::StatusCode;
use axum::http::header::LOCATION;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use tokio::sync::Semaphore;

use super::metrics::Metrics;
use super::refusal::Refusal;
use super::table_lengths::Lengths;
use crate::asked::Asked;
use crate::events::Hub;
use crate::findings::{Assembler, views};
use crate::recording::Maker;
use crate::scheduler::Scheduler;
use crate::store::{JobKey, JobView, RunView, Store};
use crate::turns::Turns;

/// What handlers share.
#[derive(Clone)]
pub(super) struct App {
    pub(super) store: Arc<Store>,
    pub(super) scheduler: Arc<Scheduler>,
    pub(super) findings: Arc<Assembler>,
    pub(super) events: Arc<Hub>,
    /// What `/metrics` tells.
    pub(super) metrics: Arc<Metrics>,
    /// Recordings that are made afterwards.
    pub(super) recordings: Arc<Maker>,
    /// Turns of documents that are much work, and of pooling many runs.
    pub(super) turns: Turns,
    pub(super) pooling: Turns,
    /// Places for tables that are being made.
    pub(super) exports: Arc<Semaphore>,
    /// How long tables are that were made.
    pub(super) lengths: Arc<Lengths>,
    /// Places for streams of frames.
    pub(super) viewers: Arc<Semaphore>,
    /// Places for checkpoints that are opened.
    pub(super) opened: Arc<Semaphore>,
    /// The OpenAPI document as text.
    pub(super) openapi: Bytes,
}

impl App {
    /// Does what blocks on a thread made for that. Once nobody waits for it any more it may end early.
    pub(super) async fn blocking<T: Send + 'static>(
        &self,
        task: impl FnOnce(&App) -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        let app = self.clone();
        // What is logged there is of this request too.
        let span = tracing::Span::current();
        let asked = Asked::default();
        let work = asked.work();
        tokio::task::spawn_blocking(move || span.in_scope(|| work.run(|| task(&app))))
            .await
            .unwrap_or_else(|error| Err(Refusal::internal(&error)))
    }

    /// The job of this key.
    pub(super) fn job(&self, seq: JobKey) -> Result<JobView, Refusal> {
        self.store
            .job(seq)?
            .ok_or_else(|| Refusal::not_found(ProblemCode::JobNotFound, "job", &seq.to_string()))
    }

    /// The answer to whoever has made a job of another run.
    pub(super) fn created(&self, job: JobKey) -> Result<Response, Refusal> {
        let shown = views::job(&self.job(job)?, &self.scheduler);
        let location = [(LOCATION, format!("/v1/jobs/{}", shown.id))];
        Ok((StatusCode::CREATED, location, Json(shown)).into_response())
    }

    /// The run of this id.
    pub(super) fn run(&self, id: &str) -> Result<RunView, Refusal> {
        self.store
            .run(id)?
            .ok_or_else(|| Refusal::not_found(ProblemCode::RunNotFound, "run", id))
    }
}
