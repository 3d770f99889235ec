//! `/v1/jobs`: post, list, show, pause, resume, cancel, delete, and a job's runs.

use api::ProblemCode::{AlreadyEnded, JobTooLarge, KeyReused, KeyUnderWay, NotEnded, QueueFull};
use api::{Job, JobPage, RunPage};
use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::header::LOCATION;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};

use super::App;
use super::control::on_job;
use super::extract::JobId;
use super::operation::{Operation, Shape, key_schema};
use super::query::{CURSOR, LIMIT, ORDER, Parameter, Query, STATE};
use super::refusal::Refusal;
use super::request::{MAX_KEY_BYTES, idempotency_key, said_to_be_json};
use super::routes::Routes;
use crate::documents::{expand, run_count};
use crate::findings::views;
use crate::scheduler::StoredArenas;
use crate::store::{Created, Intent, JobFilter, JobKey, JobRequest};

const Q: Parameter = Parameter::text("q", "Words that the name has, in any case.");

pub fn routes() -> Routes {
    Routes::new()
        .get(
            "/jobs",
            list,
            Operation::new("listJobs", "Jobs, newest first")
                .query(&[LIMIT, CURSOR, STATE, Q, ORDER])
                .shows::<JobPage>("A page of jobs."),
        )
        .post(
            "/jobs",
            create,
            Operation::new("createJob", "Post a job")
                .details(
                    "A job is stored before it is answered. The same body posted again with the \
                     same `Idempotency-Key` answers with the job that there is.",
                )
                .header(
                    "Idempotency-Key",
                    "Any text; with it a request can be sent again without making a second job.",
                    key_schema(MAX_KEY_BYTES),
                )
                .takes(Shape::Document("JobSpec"))
                .creates::<Job>(201, "The job.")
                .refuses(&[KeyUnderWay, KeyReused, JobTooLarge, QueueFull]),
        )
        .get(
            "/jobs/{id}",
            show,
            Operation::new("getJob", "A job").shows::<Job>("The job."),
        )
        .delete(
            "/jobs/{id}",
            delete,
            Operation::new("deleteJob", "Delete a job, whatever its state")
                .details("With the runs and results that no other job has.")
                .answers_nothing("It is deleted.")
                .refuses(&[KeyUnderWay]),
        )
        .get(
            "/jobs/{id}/runs",
            runs,
            Operation::new(
                "listJobRuns",
                "A job's runs, in order of their places in it",
            )
            .query(&[LIMIT, CURSOR])
            .shows::<RunPage>("A page of runs."),
        )
        .post(
            "/jobs/{id}/cancel",
            cancel,
            changes("cancelJob", "End what is left of a job").refuses(&[AlreadyEnded]),
        )
        .post(
            "/jobs/{id}/pause",
            pause,
            changes("pauseJob", "Hold what is left of a job").refuses(&[AlreadyEnded]),
        )
        .post(
            "/jobs/{id}/resume",
            resume,
            changes("resumeJob", "Go on with a job that is paused")
                .details("Also with those of its runs that were paused one by one.")
                .refuses(&[AlreadyEnded]),
        )
        .post(
            "/jobs/{id}/retry",
            retry,
            changes(
                "retryJob",
                "Run again what failed or was cancelled, from its beginning",
            )
            .refuses(&[AlreadyEnded, NotEnded, QueueFull, JobTooLarge]),
        )
}

fn changes(id: &str, about: &str) -> Operation {
    Operation::new(id, about).shows::<Job>("The job as it is then.")
}

/// `POST /v1/jobs`.
async fn create(
    State(app): State<App>,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Refusal> {
    said_to_be_json(&headers)?;
    let idempotency_key = idempotency_key(&headers)?;
    app.blocking(move |app| {
        let arenas = StoredArenas::to_keep(&app.store);
        let document = app.read(&body)?;
        let request = JobRequest::of_document(&body, idempotency_key);
        // A job for which there is no room, or that is stored already, need not be expanded.
        let earlier = app.scheduler.admit(&request, run_count(&document))?;
        let seq = match earlier {
            Some(seq) => seq,
            None => {
                let expanded = expand(&document, &arenas).map_err(Refusal::fields)?;
                let job = app.scheduler.new_job(expanded, request)?;
                let (Created::New(seq, _) | Created::Replayed(seq)) = app.scheduler.submit(&job)?;
                seq
            }
        };
        let shown = views::job(&app.job(seq)?, &app.scheduler);
        let location = [(LOCATION, format!("/v1/jobs/{seq}"))];
        Ok((StatusCode::CREATED, location, Json(shown)).into_response())
    })
    .await
}

/// `GET /v1/jobs`: newest first unless it says otherwise, of a state or with words in their name.
async fn list(State(app): State<App>, query: Query) -> Result<Json<JobPage>, Refusal> {
    let page = query.page()?;
    let filter = JobFilter {
        state: query.state()?,
        name_has: query.text(&Q)?,
        oldest_first: query.word(&ORDER)? == Some("oldest"),
    };
    app.blocking(move |app| {
        let after = page.cursor.map(JobKey);
        let found = app.store.list_jobs(&filter, after, page.limit)?;
        let items = found.items.iter();
        Ok(Json(JobPage {
            items: items.map(|job| views::job(job, &app.scheduler)).collect(),
            next: found.next.map(|next| next.to_string()),
        }))
    })
    .await
}

/// `GET /v1/jobs/{id}`.
async fn show(State(app): State<App>, id: JobId) -> Result<Json<Job>, Refusal> {
    app.with_job(id, move |app, job| {
        Ok(Json(views::job(&job, &app.scheduler)))
    })
    .await
}

/// `GET /v1/jobs/{id}/runs`: in order of their places in the job.
async fn runs(State(app): State<App>, id: JobId, query: Query) -> Result<Json<RunPage>, Refusal> {
    let page = query.page()?;
    app.with_job(id, move |app, job| {
        let from = page
            .cursor
            .and_then(|cursor| u64::try_from(cursor).ok())
            .unwrap_or(0);
        let mut runs = app.store.runs(job.seq, from, page.limit + 1)?;
        let rest = runs.split_off(runs.len().min(page.limit as usize));
        let next = rest.first().map(|run| run.ordinal.to_string());
        let items = runs
            .iter()
            .map(|run| views::run(run, &app.scheduler))
            .collect();
        Ok(Json(RunPage { items, next }))
    })
    .await
}

/// `POST /v1/jobs/{id}/cancel`.
async fn cancel(State(app): State<App>, id: JobId) -> Result<Json<Job>, Refusal> {
    want(app, id, Intent::Cancelled).await
}

/// `POST /v1/jobs/{id}/pause`.
async fn pause(State(app): State<App>, id: JobId) -> Result<Json<Job>, Refusal> {
    want(app, id, Intent::Paused).await
}

/// `POST /v1/jobs/{id}/resume`: also its runs that were paused one by one.
async fn resume(State(app): State<App>, id: JobId) -> Result<Json<Job>, Refusal> {
    want(app, id, Intent::Active).await
}

/// `POST /v1/jobs/{id}/retry`: failed and cancelled runs wait again, from their beginning.
async fn retry(State(app): State<App>, id: JobId) -> Result<Json<Job>, Refusal> {
    on_job(app, id, |app, job| app.scheduler.try_again(job)).await
}

/// `DELETE /v1/jobs/{id}`: whatever its state, with the runs and results that only it has.
async fn delete(State(app): State<App>, id: JobId) -> Result<StatusCode, Refusal> {
    app.with_job(id, move |app, job| {
        app.scheduler.delete(job.seq)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

/// Changes what is wanted of a job.
async fn want(app: App, id: JobId, intent: Intent) -> Result<Json<Job>, Refusal> {
    on_job(app, id, move |app, job| app.scheduler.want(job, intent)).await
}
