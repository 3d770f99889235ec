//! Control of single runs (pause, resume, retry, step, extend, delete, their log), and of jobs what
//! is beyond posting and stopping them: extend, priority, document.

use api::ProblemCode::{
    AlreadyEnded, CheckpointNotKept, DocumentNotKept, HeldByJob, JobTooLarge, KeyReused,
    KeyUnderWay, NotEnded, NotPaused, QueueFull,
};
use api::control::{MAX_MORE_EPOCHS, MAX_MORE_SEEDS, MAX_PRIORITY};
use api::{Epochs, ExtendJob, Job, Priority, ProblemCode, RunLog, RunLogEntry, RunSummary};
use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};

use super::App;
use super::extract::{JobId, RunId};
use super::operation::{JSON, Operation, Shape};
use super::refusal::Refusal;
use super::request::said_to_be_json;
use super::routes::Routes;
use crate::documents::one_number;
use crate::findings::views;
use crate::scheduler::ControlError;
use crate::store::{JobView, RunView};

pub fn routes() -> Routes {
    Routes::new()
        .post(
            "/jobs/{id}/extend",
            extend_job,
            Operation::new("extendJob", "More seeds in each combination of a job")
                .details("The seeds follow the largest that there is; runs that are there stay.")
                .takes(Shape::of::<ExtendJob>())
                .shows::<Job>("The job as it is then.")
                .refuses(&[
                    AlreadyEnded,
                    DocumentNotKept,
                    KeyUnderWay,
                    JobTooLarge,
                    QueueFull,
                ]),
        )
        .post(
            "/jobs/{id}/priority",
            priority,
            Operation::new("setJobPriority", "Put a job before or behind others")
                .details("Waiting runs of higher priority come first; what runs is not stopped.")
                .takes(Shape::of::<Priority>())
                .shows::<Job>("The job as it is then."),
        )
        .get(
            "/jobs/{id}/document",
            document,
            Operation::new("getJobDocument", "A job as it was posted")
                .details("With the seeds that it was extended by.")
                .answers(200, "The document.", JSON, Some(Shape::Document("JobSpec")))
                .refuses(&[DocumentNotKept]),
        )
        .delete(
            "/runs/{id}",
            delete_run,
            Operation::new("deleteRun", "Delete a run in every job that has it")
                .answers_nothing("It is deleted."),
        )
        .post(
            "/runs/{id}/pause",
            pause_run,
            changes("pauseRun", "Hold a run").refuses(&[AlreadyEnded]),
        )
        .post(
            "/runs/{id}/resume",
            resume_run,
            changes("resumeRun", "Go on with a run that is paused")
                .refuses(&[AlreadyEnded, HeldByJob]),
        )
        .post(
            "/runs/{id}/retry",
            retry_run,
            changes(
                "retryRun",
                "Run a failed or cancelled run again, from its beginning",
            )
            .refuses(&[AlreadyEnded, NotEnded, HeldByJob, QueueFull, JobTooLarge]),
        )
        .post(
            "/runs/{id}/step",
            step_run,
            changes(
                "stepRun",
                "So many epochs of a paused run, which pauses again then",
            )
            .takes(Shape::of::<Epochs>())
            .refuses(&[AlreadyEnded, NotPaused, HeldByJob]),
        )
        .post(
            "/runs/{id}/extend",
            extend_run,
            Operation::new("extendRun", "A job of one run: this one with more epochs")
                .details("Its first epochs are those of the shorter run to the last bit.")
                .takes(Shape::of::<Epochs>())
                .creates::<Job>(201, "The job.")
                .refuses(&[
                    KeyUnderWay,
                    KeyReused,
                    JobTooLarge,
                    QueueFull,
                    CheckpointNotKept,
                ]),
        )
        .get(
            "/runs/{id}/log",
            log,
            Operation::new(
                "getRunLog",
                "What was changed of a run from outside, and when",
            )
            .shows::<RunLog>("The log."),
        )
}

fn changes(id: &str, about: &str) -> Operation {
    Operation::new(id, about).shows::<RunSummary>("The run as it is then.")
}

impl From<ControlError> for Refusal {
    fn from(error: ControlError) -> Self {
        let detail = error.to_string();
        match error {
            ControlError::RunGone(_) => Self::new(ProblemCode::RunNotFound, detail),
            ControlError::JobGone(_) => Self::new(ProblemCode::JobNotFound, detail),
            ControlError::Ended(..) => Self::new(ProblemCode::AlreadyEnded, detail),
            ControlError::NotEnded(..) => Self::new(ProblemCode::NotEnded, detail),
            ControlError::Running => Self::new(ProblemCode::NotPaused, detail),
            ControlError::NotWanted(_) => Self::new(ProblemCode::HeldByJob, detail),
            ControlError::NoDocument => Self::new(ProblemCode::DocumentNotKept, detail),
            ControlError::Invalid(errors) => Self::fields(errors),
            ControlError::NoCheckpoint(_) => Self::new(ProblemCode::CheckpointNotKept, detail),
            ControlError::Checkpoint(_) => Self::damaged(&detail),
            ControlError::NoRoom(error) => error.into(),
            ControlError::Store(error) => error.into(),
        }
    }
}

/// `POST /v1/jobs/{id}/extend` by `{"seeds": 5}`.
async fn extend_job(
    State(app): State<App>,
    id: JobId,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Json<Job>, Refusal> {
    said_to_be_json(&headers)?;
    on_job(app, id, move |app, job| {
        let more = number(app, &body, "seeds", (1, i64::from(MAX_MORE_SEEDS)))?;
        // Its document is expanded anew.
        let _turn = app.turns.take()?;
        app.scheduler.extend_job(job, more as u64)?;
        Ok::<_, Refusal>(())
    })
    .await
}

/// `POST /v1/jobs/{id}/priority` of `{"priority": 10}`.
async fn priority(
    State(app): State<App>,
    id: JobId,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Json<Job>, Refusal> {
    said_to_be_json(&headers)?;
    on_job(app, id, move |app, job| {
        let most = i64::from(MAX_PRIORITY);
        let priority = number(app, &body, "priority", (-most, most))?;
        app.scheduler.set_priority(job.seq, priority as i32)?;
        Ok::<_, Refusal>(())
    })
    .await
}

/// `GET /v1/jobs/{id}/document`: the job as it was posted, with the seeds that it was extended by.
async fn document(State(app): State<App>, id: JobId) -> Result<Response, Refusal> {
    app.with_job(id, move |app, job| {
        let document = app.store.document(job.seq)?;
        let Some(document) = document else {
            // It may have been deleted meanwhile.
            app.job(job.seq)?;
            return Err(ControlError::NoDocument.into());
        };
        Ok(([(CONTENT_TYPE, "application/json")], document).into_response())
    })
    .await
}

/// `POST /v1/runs/{id}/pause`: in every job that has it.
async fn pause_run(State(app): State<App>, id: RunId) -> Result<Json<RunSummary>, Refusal> {
    on_run(app, id, |app, run| app.scheduler.pause_run(run)).await
}

/// `POST /v1/runs/{id}/resume`.
async fn resume_run(State(app): State<App>, id: RunId) -> Result<Json<RunSummary>, Refusal> {
    on_run(app, id, |app, run| app.scheduler.resume_run(run)).await
}

/// `POST /v1/runs/{id}/retry`: a failed or cancelled run waits again, from its beginning.
async fn retry_run(State(app): State<App>, id: RunId) -> Result<Json<RunSummary>, Refusal> {
    on_run(app, id, |app, run| app.scheduler.retry_run(run)).await
}

/// `POST /v1/runs/{id}/step` by `{"epochs": 3}`: a paused run does so many epochs and pauses.
async fn step_run(
    State(app): State<App>,
    id: RunId,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Json<RunSummary>, Refusal> {
    said_to_be_json(&headers)?;
    on_run(app, id, move |app, run| {
        let epochs = number(app, &body, "epochs", (1, i64::from(MAX_MORE_EPOCHS)))?;
        app.scheduler.step_run(run, epochs as u32)?;
        Ok::<_, Refusal>(())
    })
    .await
}

/// `POST /v1/runs/{id}/extend` by `{"epochs": 500}`: a job with one run that does so many more.
async fn extend_run(
    State(app): State<App>,
    id: RunId,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Refusal> {
    said_to_be_json(&headers)?;
    app.with_run(id, move |app, run| {
        let epochs = number(app, &body, "epochs", (1, i64::from(MAX_MORE_EPOCHS)))?;
        let _turn = app.turn_for_spec(&run)?;
        app.created(app.scheduler.extend_run(&run, epochs as u32)?)
    })
    .await
}

/// `DELETE /v1/runs/{id}`: whatever its state, in every job that has it.
async fn delete_run(State(app): State<App>, id: RunId) -> Result<StatusCode, Refusal> {
    app.with_run(id, move |app, run| {
        app.scheduler.delete_run(run.seq)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

/// `GET /v1/runs/{id}/log`: what was changed from outside.
async fn log(State(app): State<App>, id: RunId) -> Result<Json<RunLog>, Refusal> {
    app.with_run(id, move |app, run| {
        let entries = app.store.run_log(run.seq)?.into_iter();
        let items = entries.map(|entry| RunLogEntry {
            at: entry.at,
            robot_steps_done: entry.robot_steps_done,
            what: entry.what,
        });
        Ok(Json(RunLog {
            items: items.collect(),
        }))
    })
    .await
}

/// The one field of a small document.
fn number(app: &App, body: &[u8], field: &str, range: (i64, i64)) -> Result<i64, Refusal> {
    let document = app.read(body)?;
    one_number(&document, field, range).map_err(Refusal::fields)
}

/// Does something to a job and shows it as it is then.
pub async fn on_job<E: Into<Refusal>>(
    app: App,
    id: JobId,
    change: impl FnOnce(&App, &JobView) -> Result<(), E> + Send + 'static,
) -> Result<Json<Job>, Refusal> {
    app.with_job(id, move |app, job| {
        change(app, &job).map_err(Into::into)?;
        Ok(Json(views::job(&app.job(job.seq)?, &app.scheduler)))
    })
    .await
}

/// Does something to a run and shows it as it is then.
async fn on_run<E: Into<Refusal>>(
    app: App,
    id: RunId,
    change: impl FnOnce(&App, &RunView) -> Result<(), E> + Send + 'static,
) -> Result<Json<RunSummary>, Refusal> {
    app.with_run(id, move |app, run| {
        change(app, &run).map_err(Into::into)?;
        Ok(Json(views::run(&app.run(&run.id)?, &app.scheduler)))
    })
    .await
}
