//! `/v1/jobs/{id}/comparison` and `/curves`: a job's groups against each other by one measure, and
//! over epochs.

use api::comparison::Comparison;
use api::curves::JobCurves;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};

use super::App;
use super::extract::FoundJob;
use super::query::Query;
use super::refusal::Refusal;
use crate::store::JobView;
use crate::summary::comparison::{DEFAULT_MEASURE, csv, markdown};
use crate::summary::curves::Wanted;

/// Formats of a comparison beside JSON, by the end of the route.
type ComparisonText = (&'static str, &'static str, fn(&Comparison) -> String);

const TEXTS: [ComparisonText; 2] = [
    ("csv", "text/csv; charset=utf-8", csv),
    ("md", "text/markdown; charset=utf-8", markdown),
];

/// What curves show.
const LEVELS: [(&str, &str); 4] = [("p1", "p1"), ("p2", "p2"), ("p5", "p5"), ("p10", "p10")];
/// Points of a curve unless it is said how many.
const POINTS: i64 = 200;
const MAX_POINTS: i64 = 500;

pub fn routes() -> Router<App> {
    let mut router = Router::new()
        .route("/jobs/{id}/comparison", get(comparison))
        .route("/jobs/{id}/curves", get(curves));
    for (end, media_type, text) in TEXTS {
        let show = async move |State(app): State<App>, FoundJob(job), query: Query| {
            let comparison = compared(app, job, &query).await?;
            let text = text(&comparison);
            Ok::<Response, Refusal>(([(CONTENT_TYPE, media_type)], text).into_response())
        };
        router = router.route(&format!("/jobs/{{id}}/comparison.{end}"), get(show));
    }
    router
}

/// `GET /v1/jobs/{id}/comparison`.
async fn comparison(
    State(app): State<App>,
    FoundJob(job): FoundJob,
    query: Query,
) -> Result<Json<Comparison>, Refusal> {
    Ok(Json(compared(app, job, &query).await?))
}

async fn compared(app: App, job: JobView, query: &Query) -> Result<Comparison, Refusal> {
    let (measure, by) = (query.text("measure")?, query.text("by")?);
    app.blocking(move |app| {
        let measure = measure.as_deref().unwrap_or(DEFAULT_MEASURE);
        Ok(app.findings.comparison(&job, measure, by.as_deref())?)
    })
    .await
}

/// `GET /v1/jobs/{id}/curves`.
async fn curves(
    State(app): State<App>,
    FoundJob(job): FoundJob,
    query: Query,
) -> Result<Json<JobCurves>, Refusal> {
    let measure = query.one_of("measure", &LEVELS)?.unwrap_or("p1");
    query.one_of("x", &[("epoch", ())])?;
    let by = query.text("by")?;
    let points = query.number("points", 2, MAX_POINTS)?.unwrap_or(POINTS);
    let runs = query.one_of("runs", &[("true", true), ("false", false)])?;
    app.blocking(move |app| {
        let wanted = Wanted {
            measure,
            by: by.as_deref(),
            points: usize::try_from(points).unwrap_or(usize::MAX),
            runs: runs.unwrap_or(false),
        };
        Ok(Json(app.findings.curves(&job, wanted)?))
    })
    .await
}
