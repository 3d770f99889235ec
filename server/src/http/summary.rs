//! `/v1/jobs/{id}/summary`: a job's finished runs pooled over seeds.

use api::{JobSummary, State as RunStateName};
use axum::Json;
use axum::extract::{Path, State};
use axum::response::Response;
use serde_json::Value;

use super::App;
use super::jobs::{found, job_seq, text};
use super::refusal::Refusal;
use crate::documents::Design;
use crate::store::{JobSeq, RunView};
use crate::summary::{FinishedRun, Input, csv, markdown, summary};

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
    text(app, id, "text/csv; charset=utf-8", |app, job| {
        Ok(csv(&of_job(app, job)?))
    })
    .await
}

/// `GET /v1/jobs/{id}/summary.md`.
pub async fn as_markdown(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Response, Refusal> {
    text(app, id, "text/markdown; charset=utf-8", |app, job| {
        Ok(markdown(&of_job(app, job)?))
    })
    .await
}

fn of_job(app: &App, seq: JobSeq) -> Result<JobSummary, Refusal> {
    let job = found(app, seq)?;
    let runs = app.store.all_runs(seq)?;
    let designs = app
        .store
        .design(seq)?
        .map(|text| Design::parse(&text))
        .transpose()
        .map_err(|error| Refusal::internal(&error))?;
    // A job that was stored without its design is one group.
    let designs = designs.unwrap_or_else(|| {
        vec![Design {
            seeds: runs.len(),
            ..Design::default()
        }]
    });
    let first_runs = first_runs(&designs, &runs);
    let robots = first_runs.iter().map(|part| robots(app, part.first()));
    let input = Input {
        job_id: seq.to_string(),
        name: job.name,
        runs: runs.len() as u64,
        robots: robots.collect::<Result<_, _>>()?,
        labels: first_runs
            .iter()
            .flatten()
            .map(|run| run.label.clone())
            .collect(),
        finished: finished(app, &runs)?,
        designs,
    };
    Ok(summary(&input, |place| {
        let run = runs.get(place as usize)?;
        let metrics = app.store.findings(run.seq).ok()??.metrics;
        (!metrics.first_entry.is_empty()).then_some((metrics.first_entry, metrics.reachable))
    }))
}

/// The first run of every combination, part by part.
fn first_runs<'a>(designs: &[Design], runs: &'a [RunView]) -> Vec<Vec<&'a RunView>> {
    let mut rest = runs;
    let part = |design: &Design| {
        let count = (design.combinations() * design.seeds).min(rest.len());
        let (part, after) = rest.split_at(count);
        rest = after;
        part.iter().step_by(design.seeds.max(1)).collect()
    };
    designs.iter().map(part).collect()
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
fn robots(app: &App, run: Option<&&RunView>) -> Result<u32, Refusal> {
    let Some(run) = run else { return Ok(1) };
    let text = app.store.spec(run.seq)?.unwrap_or_default();
    let spec: Value = serde_json::from_str(&text).map_err(|error| Refusal::internal(&error))?;
    Ok(spec["robots"].as_u64().unwrap_or(1) as u32)
}
