//! `/v1/runs/{id}`: show, spec, result, memory, cancel.

use api::ProblemCode::{AlreadyEnded, NoResult};
use api::{MemoryPlan, RunPage, RunResult, RunSummary};
use axum::Json;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};

use super::App;
use super::extract::{FoundRun, RunId};
use super::operation::{JSON, Operation, Shape};
use super::query::{CURSOR, LIMIT, ORDER, Parameter, Query, STATE};
use super::refusal::Refusal;
use super::routes::Routes;
use crate::artifacts::memory_plan;
use crate::findings::views;
use crate::store::{JobKey, RunFilter, RunKey, RunState};

const JOB: Parameter = Parameter::whole("job", (0, i64::MAX), "Only those of this job.");
const METHOD: Parameter = Parameter::text("method", "Only those of this method.");
const ARENA: Parameter = Parameter::text("arena", "Only those with this target arena.");

pub fn routes() -> Routes {
    Routes::new()
        .get(
            "/runs",
            list,
            Operation::new("listRuns", "Runs of all jobs, newest first")
                .query(&[LIMIT, CURSOR, JOB, STATE, METHOD, ARENA, ORDER])
                .shows::<RunPage>("A page of runs."),
        )
        .get(
            "/runs/{id}",
            show,
            Operation::new("getRun", "A run").shows::<RunSummary>("The run."),
        )
        .get(
            "/runs/{id}/spec",
            spec,
            Operation::new("getRunSpec", "The run spec with every default filled in").answers(
                200,
                "The spec, byte for byte as `spec.json` has it.",
                JSON,
                Some(Shape::Document("RunSpec")),
            ),
        )
        .get(
            "/runs/{id}/result",
            result,
            Operation::new(
                "getRunResult",
                "What `result.json` holds, once the run is done",
            )
            .shows::<RunResult>("The result.")
            .refuses(&[NoResult]),
        )
        .get(
            "/runs/{id}/memory",
            memory,
            Operation::new("getRunMemory", "What each robot's learner may hold")
                .details("Known before the run starts.")
                .shows::<MemoryPlan>("The plan."),
        )
        .post(
            "/runs/{id}/cancel",
            cancel,
            Operation::new("cancelRun", "End a run in every job that has it")
                .shows::<RunSummary>("The run as it is then.")
                .refuses(&[AlreadyEnded]),
        )
}

/// `GET /v1/runs`: of all jobs, newest first unless it says otherwise, of a job, a state, a method or an arena.
async fn list(State(app): State<App>, query: Query) -> Result<Json<RunPage>, Refusal> {
    let page = query.page()?;
    let filter = RunFilter {
        job: query.number(&JOB)?.map(JobKey),
        state: query.state()?,
        method: query.text(&METHOD)?,
        arena: query.text(&ARENA)?,
        oldest_first: query.word(&ORDER)? == Some("oldest"),
    };
    app.blocking(move |app| {
        let after = page.cursor.map(RunKey);
        let found = app.store.list_runs(&filter, after, page.limit)?;
        let items = found.items.iter();
        Ok(Json(RunPage {
            items: items.map(|run| views::run(run, &app.scheduler)).collect(),
            next: found.next.map(|next| next.0.to_string()),
        }))
    })
    .await
}

/// `GET /v1/runs/{id}`.
async fn show(State(app): State<App>, id: RunId) -> Result<Json<RunSummary>, Refusal> {
    app.with_run(id, move |app, run| {
        Ok(Json(views::run(&run, &app.scheduler)))
    })
    .await
}

/// `GET /v1/runs/{id}/spec`: every default filled in, byte for byte as `spec.json` has it.
async fn spec(State(app): State<App>, id: RunId) -> Result<Response, Refusal> {
    app.with_run(id, move |app, run| {
        let _turn = app.turn_for_spec(&run)?;
        let text = app.findings.spec_text(&run)?;
        Ok(([(CONTENT_TYPE, JSON)], text).into_response())
    })
    .await
}

/// `GET /v1/runs/{id}/result`: what `result.json` holds, once the run is done.
async fn result(FoundRun(run): FoundRun) -> Result<Json<RunResult>, Refusal> {
    let state = run.state.state();
    match run.state {
        RunState::Done(result) => Ok(Json(*result)),
        RunState::Damaged { reason } => Err(Refusal::damaged(&reason)),
        _ => {
            let detail = format!("the run has no result: it is {state}");
            Err(Refusal::new(NoResult, detail))
        }
    }
}

/// `GET /v1/runs/{id}/memory`: what each robot's learner may hold, known before the run starts.
async fn memory(State(app): State<App>, id: RunId) -> Result<Json<MemoryPlan>, Refusal> {
    app.with_run(id, move |app, run| {
        let spec = app.findings.resolved(&run)?.run_spec();
        Ok(Json(memory_plan(spec.memory_plan())))
    })
    .await
}

/// `POST /v1/runs/{id}/cancel`: in every job that has it.
async fn cancel(State(app): State<App>, id: RunId) -> Result<Json<RunSummary>, Refusal> {
    app.with_run(id, move |app, run| {
        let ended = !app.scheduler.cancel_run(run.seq)?;
        let after = app.run(&run.id)?;
        let state = after.state.state();
        if ended && state != api::State::Cancelled {
            let detail = format!("the run is {state} already");
            return Err(Refusal::new(AlreadyEnded, detail));
        }
        Ok(Json(views::run(&after, &app.scheduler)))
    })
    .await
}
