//! `/v1/jobs/{id}/comparison`: a job's groups against each other by one measure.

use api::ProblemCode;
use api::comparison::Comparison;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde::Deserialize;

use super::App;
use super::extract::FoundJob;
use super::refusal::Refusal;
use crate::store::JobView;
use crate::summary::comparison::{DEFAULT_MEASURE, csv, markdown};

/// What is to be compared.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    /// Name of a measure of the summary.
    measure: Option<String>,
    /// A field that the job varies: its values are the groups, all else is pooled.
    by: Option<String>,
}

type AskedQuery = Result<Query<Asked>, QueryRejection>;

/// Formats beside JSON, by the end of the route.
type ComparisonText = (&'static str, &'static str, fn(&Comparison) -> String);

const TEXTS: [ComparisonText; 2] = [
    ("csv", "text/csv; charset=utf-8", csv),
    ("md", "text/markdown; charset=utf-8", markdown),
];

pub fn routes() -> Router<App> {
    let mut router = Router::new().route("/jobs/{id}/comparison", get(show));
    for (end, media_type, text) in TEXTS {
        let show = async move |State(app): State<App>, FoundJob(job), asked: AskedQuery| {
            let comparison = compared(app, job, asked).await?;
            let text = text(&comparison);
            Ok::<Response, Refusal>(([(CONTENT_TYPE, media_type)], text).into_response())
        };
        router = router.route(&format!("/jobs/{{id}}/comparison.{end}"), get(show));
    }
    router
}

/// `GET /v1/jobs/{id}/comparison`.
async fn show(
    State(app): State<App>,
    FoundJob(job): FoundJob,
    asked: AskedQuery,
) -> Result<Json<Comparison>, Refusal> {
    Ok(Json(compared(app, job, asked).await?))
}

async fn compared(app: App, job: JobView, asked: AskedQuery) -> Result<Comparison, Refusal> {
    let Query(asked) =
        asked.map_err(|error| Refusal::new(ProblemCode::InvalidQuery, error.body_text()))?;
    app.blocking(move |app| {
        let measure = asked.measure.as_deref().unwrap_or(DEFAULT_MEASURE);
        Ok(app
            .findings
            .comparison(&job, measure, asked.by.as_deref())?)
    })
    .await
}
