//! `/v1/jobs/{id}/curves`: a job's coverage over epochs, pooled by group.

use api::ProblemCode;
use api::curves::JobCurves;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::routing::get;
use axum::{Json, Router};
use serde::Deserialize;

use super::App;
use super::extract::FoundJob;
use super::refusal::Refusal;
use crate::summary::curves::Wanted;

const POINTS: usize = 200;
const MOST_POINTS: usize = 500;
const MEASURES: [&str; 4] = ["p1", "p2", "p5", "p10"];

/// Which curves are wanted.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    /// Squares entered at least so often.
    #[serde(default)]
    measure: Option<String>,
    /// What they run over: `epoch` alone.
    #[serde(default)]
    x: Option<String>,
    /// A field that the job varies: its values are the groups, all else is pooled.
    #[serde(default)]
    by: Option<String>,
    /// Most abscissae.
    #[serde(default)]
    points: Option<usize>,
    /// Whether single runs are shown too.
    #[serde(default)]
    runs: bool,
}

pub fn routes() -> Router<App> {
    Router::new().route("/jobs/{id}/curves", get(show))
}

/// `GET /v1/jobs/{id}/curves`.
async fn show(
    State(app): State<App>,
    FoundJob(job): FoundJob,
    asked: Result<Query<Asked>, QueryRejection>,
) -> Result<Json<JobCurves>, Refusal> {
    let refused = |why: String| Refusal::new(ProblemCode::InvalidQuery, why);
    let Query(asked) = asked.map_err(|error| refused(error.body_text()))?;
    let measure = asked.measure.as_deref().unwrap_or(MEASURES[0]).to_owned();
    if !MEASURES.contains(&measure.as_str()) {
        return Err(refused(format!(
            "measure is one of {}",
            MEASURES.join(", ")
        )));
    }
    if asked.x.as_deref().is_some_and(|x| x != "epoch") {
        return Err(refused("x is epoch".to_owned()));
    }
    let points = asked.points.unwrap_or(POINTS);
    if !(2..=MOST_POINTS).contains(&points) {
        return Err(refused(format!(
            "points is a whole number from 2 to {MOST_POINTS}"
        )));
    }
    app.blocking(move |app| {
        let wanted = Wanted {
            measure: &measure,
            by: asked.by.as_deref(),
            points,
            runs: asked.runs,
        };
        Ok(Json(app.findings.curves(&job, wanted)?))
    })
    .await
}
