//! `/v1/jobs/{id}/report`: what a job of the template `chapter-5` says of the thesis's claims.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::Response;

use super::App;
use super::jobs::{found, text};
use super::refusal::Refusal;
use crate::reproduce::{Plan, Report};
use crate::store::JobSeq;

/// `GET /v1/jobs/{id}/report`: the claims with their tests.
pub async fn claims(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Refusal> {
    text(app, id, "application/json", |app, job| {
        Ok(of_job(app, job)?.claims_json.clone())
    })
    .await
}

/// `GET /v1/jobs/{id}/report.html`: all of it, one page.
pub async fn html(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Refusal> {
    text(app, id, "text/html; charset=utf-8", |app, job| {
        Ok(of_job(app, job)?.html.clone())
    })
    .await
}

/// `GET /v1/jobs/{id}/report.md`.
pub async fn markdown(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Refusal> {
    text(app, id, "text/markdown; charset=utf-8", |app, job| {
        Ok(of_job(app, job)?.markdown.clone())
    })
    .await
}

/// `GET /v1/jobs/{id}/report.csv`: one line a run.
pub async fn csv(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Refusal> {
    text(app, id, "text/csv; charset=utf-8", |app, job| {
        Ok(of_job(app, job)?.runs_csv.clone())
    })
    .await
}

fn of_job(app: &App, seq: JobSeq) -> Result<Arc<Report>, Refusal> {
    let counts = found(app, seq)?.counts;
    app.pictures.report(seq, || {
        let failed = |error: anyhow::Error| Refusal::internal(&format!("{error:#}"));
        let runs = app.store.all_runs(seq)?;
        let Some(plan) = Plan::of_job(&runs, &app.store).map_err(failed)? else {
            let detail = format!(
                "job {seq} has no report: its runs are not those of the template chapter-5, with \
                 epochs, steps, arenas and seeds from 1 on of your choice and nothing else changed"
            );
            return Err(Refusal::new(StatusCode::NOT_FOUND, detail));
        };
        if counts.done < counts.total {
            return Err(Refusal::conflict(format!(
                "{} of {} runs are done; the report is made of all of them",
                counts.done, counts.total
            )));
        }
        Report::new(&plan, &app.store).map_err(failed)
    })
}
