//! `/v1/jobs/{id}/comparison` and `/curves`: a job's groups against each other by one measure, and
//! over epochs.

use api::comparison::Comparison;
use api::curves::{GroupCoverage, JobCurves};
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use super::App;
use super::extract::JobId;
use super::operation::{JSON, Operation, camel};
use super::query::{Parameter, Query};
use super::refusal::Refusal;
use super::routes::Routes;
use super::turns::{MANY_FINDINGS, MANY_RUNS};
use crate::store::JobView;
use crate::summary::comparison::{DEFAULT_MEASURE, csv, markdown};
use crate::summary::curves::{MEASURES, Wanted};

/// Formats of a comparison beside JSON, by the end of the route.
type ComparisonText = (&'static str, &'static str, fn(&Comparison) -> String);

const TEXTS: [ComparisonText; 2] = [
    ("csv", "text/csv; charset=utf-8", csv),
    ("md", "text/markdown; charset=utf-8", markdown),
];

const MEASURE: Parameter = Parameter::text(
    "measure",
    "What is compared: `p1_fraction` unless it says otherwise, or another measure of the summary.",
);
const BY: Parameter = Parameter::text(
    "by",
    "Dotted path of the run spec whose values are the groups; else each combination is one.",
);
/// What curves show.
const LEVEL: Parameter = Parameter::word(
    "measure",
    &MEASURES,
    "Squares entered at least so often; `_fraction`: over those that can be reached. Slivers along \
     walls, which can just be entered, do not count as reachable, so a share may end a little above \
     the result's.",
);
const X: Parameter = Parameter::word("x", &["epoch"], "What curves run over.");
const POINTS: Parameter = Parameter::whole("points", (2, 500), "Most points of a curve.").or(200);
const GROUP: Parameter = Parameter::whole(
    "group",
    (0, 199),
    "Place of the group among those of the job or of `by`, from 0.",
)
.or(0);
const RUNS: Parameter = Parameter::word(
    "runs",
    &["false", "true"],
    "Whether the curves of single runs come too.",
);

pub fn routes() -> Routes {
    let mut routes = Routes::new()
        .get(
            "/jobs/{id}/comparison",
            comparison,
            Operation::new(
                "compareJob",
                "A job's groups against each other, and which is best",
            )
            .query(&[MEASURE, BY])
            .shows::<Comparison>("The comparison of what is done."),
        )
        .get(
            "/jobs/{id}/curves",
            curves,
            Operation::new("getJobCurves", "Coverage over epochs, pooled by group")
                .query(&[LEVEL, X, BY, POINTS, RUNS])
                .shows::<JobCurves>("The curves of what is done."),
        )
        .get(
            "/jobs/{id}/coverage",
            coverage,
            Operation::new("getJobCoverage", "Where the runs of a group went, pooled")
                .query(&[GROUP, BY])
                .shows::<GroupCoverage>("The coverage of what is done."),
        );
    for (end, media_type, text) in TEXTS {
        let show = async move |State(app): State<App>, id: JobId, query: Query| {
            compared(app, id, &query, media_type, move |found| {
                Ok(text(found).into())
            })
            .await
        };
        let told = Operation::new(
            format!("compareJob{}", camel(end)),
            "A job's groups against each other, as text",
        );
        let told = told.query(&[MEASURE, BY]);
        let told = told.answers(200, "The comparison of what is done.", media_type, None);
        routes = routes.get(&format!("/jobs/{{id}}/comparison.{end}"), show, told);
    }
    routes
}

/// `GET /v1/jobs/{id}/comparison`.
async fn comparison(State(app): State<App>, id: JobId, query: Query) -> Result<Response, Refusal> {
    compared(app, id, &query, JSON, json).await
}

async fn compared(
    app: App,
    id: JobId,
    query: &Query,
    media_type: &'static str,
    text: impl FnOnce(&Comparison) -> Result<Vec<u8>, Refusal> + Send + 'static,
) -> Result<Response, Refusal> {
    let (measure, by) = (query.text(&MEASURE)?, query.text(&BY)?);
    app.with_job(id, move |app, job| {
        let measure = measure.as_deref().unwrap_or(DEFAULT_MEASURE);
        let asked = format!("comparison {media_type} {measure:?} {by:?}");
        pooled(app, &job, &asked, (MANY_RUNS, media_type), || {
            text(&app.findings.comparison(&job, measure, by.as_deref())?)
        })
    })
    .await
}

/// `GET /v1/jobs/{id}/curves`.
async fn curves(State(app): State<App>, id: JobId, query: Query) -> Result<Response, Refusal> {
    let measure = query.word(&LEVEL)?.unwrap_or("p1");
    query.word(&X)?;
    let by = query.text(&BY)?;
    let points = query.number(&POINTS)?;
    let runs = query.word(&RUNS)? == Some("true");
    app.with_job(id, move |app, job| {
        let wanted = Wanted {
            measure,
            by: by.as_deref(),
            points: points
                .and_then(|points| points.try_into().ok())
                .unwrap_or(usize::MAX),
            runs,
        };
        let asked = format!("{wanted:?}");
        pooled(app, &job, &asked, (MANY_FINDINGS, JSON), || {
            json(&app.findings.curves(&job, wanted)?)
        })
    })
    .await
}

/// `GET /v1/jobs/{id}/coverage`.
async fn coverage(State(app): State<App>, id: JobId, query: Query) -> Result<Response, Refusal> {
    let by = query.text(&BY)?;
    let group = query
        .number(&GROUP)?
        .and_then(|group| group.try_into().ok())
        .unwrap_or(0);
    app.with_job(id, move |app, job| {
        let asked = format!("coverage {group} {by:?}");
        pooled(app, &job, &asked, (MANY_FINDINGS, JSON), || {
            let found = app.findings.group_coverage(&job, group, by.as_deref());
            json(&found?)
        })
    })
    .await
}

/// What is pooled of a job's finished runs: in a turn where they are many, and once for all who ask it.
fn pooled(
    app: &App,
    job: &JobView,
    asked: &str,
    (many, media_type): (u64, &'static str),
    pool: impl FnOnce() -> Result<Vec<u8>, Refusal>,
) -> Result<Response, Refusal> {
    let body = app.findings.pooled(job, asked, || {
        let _turn = app.turn_to_pool(job, many)?;
        pool()
    })?;
    Ok(([(CONTENT_TYPE, media_type)], body).into_response())
}

fn json(value: &impl Serialize) -> Result<Vec<u8>, Refusal> {
    serde_json::to_vec(value).map_err(|error| Refusal::internal(&error))
}
