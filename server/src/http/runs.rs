//! `/v1/runs/{id}`: show, spec, result, channels, cancel.

use api::{MemoryPlan, RunResult, RunSummary};
use axum::Json;
use axum::extract::{Path, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};

use super::refusal::Refusal;
use super::{App, views};
use crate::artifacts::memory_plan;
use crate::channels::{Extent, describe};
use crate::documents::{ResolvedRun, parse, resolve};
use crate::scheduler::StoredArenas;
use crate::store::RunView;

/// `GET /v1/runs/{id}`.
pub async fn show(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<RunSummary>, Refusal> {
    app.blocking(move |app| Ok(Json(views::run(&found(app, &id)?, &app.scheduler))))
        .await
}

/// `GET /v1/runs/{id}/spec`: every default filled in, byte for byte as `spec.json` has it.
pub async fn spec(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Refusal> {
    app.blocking(move |app| {
        let text = spec_text(app, &found(app, &id)?)?;
        Ok(([(CONTENT_TYPE, "application/json")], text).into_response())
    })
    .await
}

/// `GET /v1/runs/{id}/result`: what `result.json` holds, once the run is done.
pub async fn result(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<RunResult>, Refusal> {
    app.blocking(move |app| {
        let run = found(app, &id)?;
        let state = run.state.state();
        run.result
            .map(Json)
            .ok_or_else(|| Refusal::conflict(format!("the run has no result: it is {state}")))
    })
    .await
}

/// `GET /v1/runs/{id}/memory`: what each robot's learner may hold, known before the run starts.
pub async fn memory(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<MemoryPlan>, Refusal> {
    app.blocking(move |app| {
        let spec = resolved(app, &found(app, &id)?)?.run_spec();
        let plan = swarm::memory::MemoryPlan::of(&spec);
        // Specs whose budget has no plan are refused when they are posted.
        let plan = plan.map_err(|error| Refusal::internal(&error))?;
        Ok(Json(memory_plan(&plan)))
    })
    .await
}

/// `GET /v1/runs/{id}/channels`: what a program needs to open the run's channels; empty when it has
/// none.
pub async fn channels(State(app): State<App>, Path(id): Path<String>) -> Result<Response, Refusal> {
    app.blocking(move |app| {
        let run = resolved(app, &found(app, &id)?)?;
        let channels = if run.channels() {
            describe(app.scheduler.channels(), &id, Extent::of(&run.run_spec()))
                .map_err(|error| Refusal::internal(&error))?
        } else {
            Vec::new()
        };
        Ok(Json(channels).into_response())
    })
    .await
}

/// `POST /v1/runs/{id}/cancel`: in every job that has it.
pub async fn cancel(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<RunSummary>, Refusal> {
    app.blocking(move |app| {
        let run = found(app, &id)?;
        let ended = !app.scheduler.cancel_run(run.seq)?;
        let after = found(app, &id)?;
        let state = after.state.state();
        if ended && state != api::State::Cancelled {
            return Err(Refusal::conflict(format!("the run is {state} already")));
        }
        Ok(Json(views::run(&after, &app.scheduler)))
    })
    .await
}

/// The run of this id.
pub fn found(app: &App, id: &str) -> Result<RunView, Refusal> {
    app.store
        .run(id)?
        .ok_or_else(|| Refusal::not_found("run", id))
}

/// The run's spec, resolved again.
pub fn resolved(app: &App, run: &RunView) -> Result<ResolvedRun, Refusal> {
    let text = spec_text(app, run)?;
    parse(&text)
        .and_then(|value| resolve(&value, &StoredArenas::new(&app.store)))
        .map_err(|errors| Refusal::internal(&format!("the spec of {}: {errors:?}", run.id)))
}

fn spec_text(app: &App, run: &RunView) -> Result<String, Refusal> {
    app.store
        .spec(run.seq)?
        .ok_or_else(|| Refusal::not_found("run", &run.id))
}
