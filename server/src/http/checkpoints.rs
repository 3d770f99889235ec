//! `/v1/runs/{id}/checkpoint`: take, download and upload states of a run; `/fork`: go on from one with
//! other parameters.

use api::ProblemCode::{
    CheckpointNotKept, InvalidDocument, JobTooLarge, KeyReused, KeyUnderWay, QueueFull,
};
use api::{CheckpointInfo, Fork, Job, ProblemCode};
use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;

use super::App;
use super::extract::RunId;
use super::operation::{Operation, Shape};
use super::partial;
use super::refusal::Refusal;
use super::request::{BYTES, said_to_be_bytes, said_to_be_json};
use super::routes::Routes;
use crate::documents::fork;

pub fn routes() -> Routes {
    let path = "/runs/{id}/checkpoint";
    let made = [KeyUnderWay, KeyReused, JobTooLarge, QueueFull];
    Routes::new()
        .get(
            path,
            download,
            Operation::new("getRunCheckpoint", "The newest state of a run that is kept")
                .details("Of one that is done, its last state, while there is room for that.")
                .answers(200, "The checkpoint.", BYTES, None)
                .refuses(&[CheckpointNotKept]),
        )
        .post(
            path,
            take,
            Operation::new("takeRunCheckpoint", "Take a checkpoint of a run now")
                .details("Of a run that is not being stepped, what is kept is told.")
                .shows::<CheckpointInfo>("What is kept.")
                .refuses(&[CheckpointNotKept]),
        )
        .put(
            path,
            upload,
            Operation::new(
                "putRunCheckpoint",
                "A job of one run that goes on from a state of this run made elsewhere",
            )
            .details("The new run's id is made of the spec and of the digest of the state.")
            .takes_bytes()
            .creates::<Job>(201, "The job.")
            .refuses(&made)
            .refuses(&[InvalidDocument]),
        )
        .post(
            "/runs/{id}/fork",
            fork_run,
            Operation::new(
                "forkRun",
                "A job of one run that goes on from this one's newest state, with changes",
            )
            .details(
                "What may change is told where something else is asked for. The new run's id is \
                 made of its spec and of the digest of the state.",
            )
            .takes(Shape::of::<Fork>())
            .creates::<Job>(201, "The job.")
            .refuses(&made)
            .refuses(&[CheckpointNotKept]),
        )
}

/// Where the body of a request may be larger than elsewhere.
pub fn is_upload(method: &axum::http::Method, path: &str) -> bool {
    *method == axum::http::Method::PUT && path.ends_with("/checkpoint")
}

/// `GET /v1/runs/{id}/checkpoint`.
async fn download(
    State(app): State<App>,
    id: RunId,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    app.with_run(id, move |app, run| {
        let unreadable = |error: crate::store::CheckpointError| Refusal::damaged(&error);
        let file = app.store.checkpoints().file(&run.id).map_err(unreadable)?;
        let file = match file {
            Some(file) => Some(file),
            None => app.store.finals().file(&run.id).map_err(unreadable)?,
        };
        let Some(file) = file else {
            let detail = format!("no state of the run is kept: it is {}", run.state.state());
            return Err(Refusal::new(ProblemCode::CheckpointNotKept, detail));
        };
        let name = format!("{}.checkpoint", run.id);
        partial::file(file, "checkpoint", (BYTES, &name), &headers, ())
    })
    .await
}

/// `POST /v1/runs/{id}/checkpoint`.
async fn take(State(app): State<App>, id: RunId) -> Result<Json<CheckpointInfo>, Refusal> {
    app.with_run(id, move |app, run| {
        Ok(Json(app.scheduler.take_checkpoint(&run)?))
    })
    .await
}

/// `PUT /v1/runs/{id}/checkpoint`.
async fn upload(
    State(app): State<App>,
    id: RunId,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Refusal> {
    said_to_be_bytes(&headers)?;
    app.with_run(id, move |app, run| {
        app.created(app.scheduler.upload_checkpoint(&run, &body)?)
    })
    .await
}

/// `POST /v1/runs/{id}/fork`.
async fn fork_run(
    State(app): State<App>,
    id: RunId,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Refusal> {
    said_to_be_json(&headers)?;
    app.with_run(id, move |app, run| {
        let wanted = fork(&*app.read(&body)?).map_err(Refusal::fields)?;
        let _turn = app.turn_for_spec(&run)?;
        app.created(app.scheduler.fork_run(&run, &wanted)?)
    })
    .await
}
