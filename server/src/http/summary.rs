//! `/v1/jobs/{id}/summary`: a job's finished runs pooled over seeds.

use api::{JobSummary, State as RunStateName};
use axum::Json;
use axum::extract::{Path, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde_json::Value;

use super::App;
use super::jobs::{found, job_seq};
use super::refusal::Refusal;
use crate::spec::Design;
use crate::store::{JobSeq, RunSeq, RunView};
use crate::summary::{FinishedRun, Input, csv, markdown, summary};

/// Runs that are read from the store at once.
const PAGE: u32 = 1_000;

/// `GET /v1/jobs/{id}/summary`.
pub async fn as_json(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<JobSummary>, Refusal> {
    let seq = job_seq(&id)?;
    app.blocking(move |app| Ok(Json(of_job(app, seq)?))).await
}

/// `GET /v1/jobs/{id}/summary.csv`.
pub async fn as_csv(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Refusal> {
    text(app, id, "text/csv; charset=utf-8", csv).await
}

/// `GET /v1/jobs/{id}/summary.md`.
pub async fn as_markdown(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Response, Refusal> {
    text(app, id, "text/markdown; charset=utf-8", markdown).await
}

async fn text(
    app: App,
    id: String,
    media_type: &'static str,
    render: fn(&JobSummary) -> String,
) -> Result<Response, Refusal> {
    let seq = job_seq(&id)?;
    app.blocking(move |app| {
        let body = render(&of_job(app, seq)?);
        Ok(([(CONTENT_TYPE, media_type)], body).into_response())
    })
    .await
}

fn of_job(app: &App, seq: JobSeq) -> Result<JobSummary, Refusal> {
    let job = found(app, seq)?;
    let mut runs: Vec<RunView> = Vec::new();
    loop {
        let from = runs.last().map_or(0, |run| run.ordinal + 1);
        let page = app.store.runs(seq, from, PAGE)?;
        if page.is_empty() {
            break;
        }
        runs.extend(page);
    }
    let design: Option<Design> = app
        .store
        .design(seq)?
        .map(|text| serde_json::from_str(&text))
        .transpose()
        .map_err(|error| Refusal::internal(&error))?;
    // A job that was stored without its design is one group.
    let design = design.unwrap_or_else(|| Design {
        seeds: runs.len(),
        axes: Vec::new(),
    });
    let seeds = design.seeds.max(1);
    let labels = runs.iter().step_by(seeds).map(|run| run.label.clone());
    let input = Input {
        job_id: seq.to_string(),
        name: job.name,
        runs: runs.len() as u64,
        labels: labels.collect(),
        robots: robots(app, runs.first().map(|run| run.seq))?,
        finished: finished(app, &runs)?,
        design,
    };
    Ok(summary(&input, |place| {
        let run = runs.get(place as usize)?;
        let metrics = app.store.coverage(run.seq).ok()??.metrics;
        (!metrics.first_entry.is_empty()).then_some((metrics.first_entry, metrics.reachable))
    }))
}

fn finished(app: &App, runs: &[RunView]) -> Result<Vec<FinishedRun>, Refusal> {
    let mut finished = Vec::new();
    for run in runs {
        let Some(result) = &run.result else { continue };
        if run.state.state() == RunStateName::Done {
            finished.push(FinishedRun {
                place: run.ordinal,
                seed: run.seed,
                result: result.clone(),
                cpu_ns_per_robot_step: app.store.cost(run.seq)?,
            });
        }
    }
    Ok(finished)
}

/// Robots of a run, from its stored spec.
fn robots(app: &App, run: Option<RunSeq>) -> Result<u32, Refusal> {
    let Some(run) = run else { return Ok(1) };
    let text = app.store.spec(run)?.unwrap_or_default();
    let spec: Value = serde_json::from_str(&text).map_err(|error| Refusal::internal(&error))?;
    Ok(spec["robots"].as_u64().unwrap_or(1) as u32)
}
