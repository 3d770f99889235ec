//! `/v1/jobs/{id}/summary` and `/report`: what a job has found, in every format.

use api::JobSummary;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};

use super::App;
use super::extract::FoundJob;
use super::refusal::Refusal;
use crate::reproduce::Report;
use crate::summary::{csv, markdown};

/// Formats of a summary, by the end of the route.
type SummaryText = (&'static str, &'static str, fn(&JobSummary) -> String);

const SUMMARIES: [SummaryText; 2] = [
    ("summary.csv", "text/csv; charset=utf-8", csv),
    ("summary.md", "text/markdown; charset=utf-8", markdown),
];

/// Formats of a report, by the end of the route.
type ReportText = (&'static str, &'static str, fn(&Report) -> &str);

const REPORTS: [ReportText; 4] = [
    ("report", "application/json", |report| &report.claims_json),
    ("report.html", "text/html; charset=utf-8", |report| {
        &report.html
    }),
    ("report.md", "text/markdown; charset=utf-8", |report| {
        &report.markdown
    }),
    ("report.csv", "text/csv; charset=utf-8", |report| {
        &report.runs_csv
    }),
];

pub fn routes() -> Router<App> {
    let mut router = Router::new().route("/jobs/{id}/summary", get(summary));
    for (end, media_type, text) in SUMMARIES {
        let show = async move |State(app): State<App>, FoundJob(job)| {
            app.blocking(move |app| {
                let summary = app.findings.summary(&job)?;
                Ok(([(CONTENT_TYPE, media_type)], text(&summary)).into_response())
            })
            .await
        };
        router = router.route(&format!("/jobs/{{id}}/{end}"), get(show));
    }
    for (end, media_type, text) in REPORTS {
        let show =
            async move |State(app): State<App>, FoundJob(job)| -> Result<Response, Refusal> {
                app.blocking(move |app| {
                    let report = app.findings.report(&job)?;
                    let text = text(&report).to_owned();
                    Ok(([(CONTENT_TYPE, media_type)], text).into_response())
                })
                .await
            };
        router = router.route(&format!("/jobs/{{id}}/{end}"), get(show));
    }
    router
}

/// `GET /v1/jobs/{id}/summary`.
async fn summary(
    State(app): State<App>,
    FoundJob(job): FoundJob,
) -> Result<Json<JobSummary>, Refusal> {
    app.blocking(move |app| Ok(Json(app.findings.summary(&job)?)))
        .await
}
