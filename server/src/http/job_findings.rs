//! `/v1/jobs/{id}/summary` and `/report`: what a job has found, in every format.

use api::JobSummary;
use api::ProblemCode::{ReportNotFound, ReportNotReady};
use axum::Json;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};

use super::App;
use super::extract::JobId;
use super::operation::{JSON, Operation, Shape, camel};
use super::refusal::Refusal;
use super::routes::Routes;
use super::turns::MANY_RUNS;
use crate::reproduce::{Claims, Report};
use crate::store::JobView;
use crate::summary::{csv, markdown};

/// Runs of a job that are explained without being asked for, the first of those that stand out.
const MOST_EXPLAINED: usize = 5;
/// Robot-steps of one that is: about a minute.
const MOST_ROBOT_STEPS: u64 = 200_000_000;

/// Formats of a summary, by the end of the route.
type SummaryText = (&'static str, &'static str, fn(&JobSummary) -> String);

const SUMMARIES: [SummaryText; 2] = [
    ("summary.csv", "text/csv; charset=utf-8", csv),
    ("summary.md", "text/markdown; charset=utf-8", markdown),
];

/// Formats of a report, by the end of the route.
type ReportText = (&'static str, &'static str, fn(&Report) -> &str);

const REPORTS: [ReportText; 4] = [
    ("report", JSON, |report| &report.claims_json),
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

pub fn routes() -> Routes {
    let mut routes = Routes::new().get(
        "/jobs/{id}/summary",
        summary,
        Operation::new("getJobSummary", "A job's runs pooled over seeds")
            .shows::<JobSummary>("The summary of what is done."),
    );
    for (end, media_type, text) in SUMMARIES {
        let show = async move |State(app): State<App>, id: JobId| {
            app.with_job(id, move |app, job| {
                let summary = summarised(app, &job)?;
                Ok(([(CONTENT_TYPE, media_type)], text(&summary)).into_response())
            })
            .await
        };
        let told = Operation::new(
            format!("getJob{}", camel(end)),
            "A job's runs pooled over seeds, as text",
        );
        let told = told.answers(200, "The summary of what is done.", media_type, None);
        routes = routes.get(&format!("/jobs/{{id}}/{end}"), show, told);
    }
    for (end, media_type, text) in REPORTS {
        let show = async move |State(app): State<App>, id: JobId| -> Result<Response, Refusal> {
            app.with_job(id, move |app, job| {
                let _turn = app.turn_to_pool(&job, MANY_RUNS)?;
                let report = app.findings.report(&job)?;
                let text = text(&report).to_owned();
                Ok(([(CONTENT_TYPE, media_type)], text).into_response())
            })
            .await
        };
        let shape = (media_type == JSON).then_some(Shape::of::<Claims>());
        let told = Operation::new(
            format!("getJob{}", camel(end)),
            "The report on the thesis's chapter 5",
        );
        let told = told.answers(200, "The report.", media_type, shape);
        let told = told.refuses(&[ReportNotFound, ReportNotReady]);
        routes = routes.get(&format!("/jobs/{{id}}/{end}"), show, told);
    }
    routes
}

/// `GET /v1/jobs/{id}/summary`.
async fn summary(State(app): State<App>, id: JobId) -> Result<Json<JobSummary>, Refusal> {
    app.with_job(id, move |app, job| Ok(Json(summarised(app, &job)?)))
        .await
}

/// The summary of a job. Of runs that covered far too little it is found out why, one after the
/// other, when nobody waits for anything else.
fn summarised(app: &App, job: &JobView) -> Result<JobSummary, Refusal> {
    let _turn = app.turn_to_pool(job, MANY_RUNS)?;
    let summary = app.findings.summary(job)?;
    let few = summary.odd_runs.iter().take(MOST_EXPLAINED);
    let unknown = few.filter(|run| run.explanation.is_none() && run.score.is_some_and(|z| z < 0.0));
    if summary.runs_done == summary.runs {
        for odd in unknown {
            // One that is gone meanwhile needs no reason.
            let Ok(run) = app.run(&odd.run_id) else {
                continue;
            };
            let Ok(spec) = app.findings.resolved(&run) else {
                continue;
            };
            app.recordings.explain_later(&run, &spec, MOST_ROBOT_STEPS);
        }
    }
    Ok(summary)
}
