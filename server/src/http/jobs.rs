//! `/v1/jobs`: post, list, show, pause, resume, cancel, delete, and a job's runs.

use api::{JobPage, RunPage};
use axum::Json;
use axum::body::Bytes;
use axum::extract::{FromRequest, Path, Request, State};
use axum::http::header::{CONTENT_TYPE, LOCATION};
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse, Response};

use super::guard::TIMEOUT;
use super::refusal::Refusal;
use super::request::{idempotency_key, json_body, page, parse};
use super::{App, views};
use crate::documents::{expand, run_count};
use crate::scheduler::{StoredArenas, new_job};
use crate::store::{Created, Intent, JobRequest, JobSeq, JobView};

/// `POST /v1/jobs`.
pub async fn create(State(app): State<App>, request: Request) -> Result<Response, Refusal> {
    let headers = request.headers().clone();
    let idempotency_key = idempotency_key(&headers)?;
    let body = tokio::time::timeout(TIMEOUT, Bytes::from_request(request, &()))
        .await
        .map_err(|_| Refusal::new(StatusCode::REQUEST_TIMEOUT, "the body took too long"))?;
    let body = json_body(&headers, body)?;
    app.blocking(move |app| {
        let arenas = StoredArenas::new(&app.store);
        let document = parse(&body)?;
        let request = JobRequest::new(&body, idempotency_key);
        // A job for which there is no room, or that is stored already, need not be expanded.
        let earlier = app.scheduler.admit(&request, run_count(&document))?;
        let seq = match earlier {
            Some(seq) => seq,
            None => {
                let expanded = expand(&document, &arenas).map_err(Refusal::fields)?;
                let (Created::New(seq, _) | Created::Replayed(seq)) =
                    app.scheduler.submit(&new_job(expanded, request))?;
                seq
            }
        };
        let shown = views::job(&found(app, seq)?, &app.scheduler);
        let location = [(LOCATION, format!("/v1/jobs/{seq}"))];
        Ok((StatusCode::CREATED, location, Json(shown)).into_response())
    })
    .await
}

/// `GET /v1/jobs`: newest first.
pub async fn list(State(app): State<App>, uri: Uri) -> Result<Json<JobPage>, Refusal> {
    let page = page(&uri)?;
    app.blocking(move |app| {
        let mut jobs = app.store.jobs(page.cursor, page.limit + 1)?;
        let more = jobs.len() > page.limit as usize;
        jobs.truncate(page.limit as usize);
        let next = jobs.last().filter(|_| more).map(|job| job.seq.to_string());
        let items = jobs
            .iter()
            .map(|job| views::job(job, &app.scheduler))
            .collect();
        Ok(Json(JobPage { items, next }))
    })
    .await
}

/// `GET /v1/jobs/{id}`.
pub async fn show(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<api::Job>, Refusal> {
    let seq = job_seq(&id)?;
    app.blocking(move |app| Ok(Json(views::job(&found(app, seq)?, &app.scheduler))))
        .await
}

/// `GET /v1/jobs/{id}/runs`: in order of their places in the job.
pub async fn runs(
    State(app): State<App>,
    Path(id): Path<String>,
    uri: Uri,
) -> Result<Json<RunPage>, Refusal> {
    let (seq, page) = (job_seq(&id)?, page(&uri)?);
    app.blocking(move |app| {
        found(app, seq)?;
        let from = page
            .cursor
            .and_then(|cursor| u64::try_from(cursor).ok())
            .unwrap_or(0);
        let mut runs = app.store.runs(seq, from, page.limit + 1)?;
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
pub async fn cancel(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<api::Job>, Refusal> {
    want(app, id, Intent::Cancelled).await
}

/// `POST /v1/jobs/{id}/pause`.
pub async fn pause(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<api::Job>, Refusal> {
    want(app, id, Intent::Paused).await
}

/// `POST /v1/jobs/{id}/resume`.
pub async fn resume(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<api::Job>, Refusal> {
    want(app, id, Intent::Active).await
}

/// `POST /v1/jobs/{id}/retry`: failed and cancelled runs wait again, from their beginning.
pub async fn retry(
    State(app): State<App>,
    Path(id): Path<String>,
) -> Result<Json<api::Job>, Refusal> {
    let seq = job_seq(&id)?;
    app.blocking(move |app| {
        let before = found(app, seq)?;
        let state = before.intent.job_state(&before.counts);
        if !state.is_final() {
            return Err(Refusal::conflict(format!("the job is {state}")));
        }
        app.scheduler.retry(seq)?;
        Ok(Json(views::job(&found(app, seq)?, &app.scheduler)))
    })
    .await
}

/// `DELETE /v1/jobs/{id}`: whatever its state, with the runs and results that only it has.
pub async fn delete(State(app): State<App>, Path(id): Path<String>) -> Result<StatusCode, Refusal> {
    let seq = job_seq(&id)?;
    app.blocking(move |app| {
        found(app, seq)?;
        app.scheduler.delete(seq)?;
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

/// Changes what is wanted of a job; wanting the same again is no error.
async fn want(app: App, id: String, intent: Intent) -> Result<Json<api::Job>, Refusal> {
    let seq = job_seq(&id)?;
    app.blocking(move |app| {
        let before = found(app, seq)?;
        if before.intent != intent {
            let state = before.intent.job_state(&before.counts);
            if state.is_final() {
                return Err(Refusal::conflict(format!("the job is {state} already")));
            }
            app.scheduler.set_intent(seq, intent)?;
        }
        Ok(Json(views::job(&found(app, seq)?, &app.scheduler)))
    })
    .await
}

/// Answers with a text that is made of a job.
pub async fn text(
    app: App,
    id: String,
    media_type: &'static str,
    make: impl FnOnce(&App, JobSeq) -> Result<String, Refusal> + Send + 'static,
) -> Result<Response, Refusal> {
    let seq = job_seq(&id)?;
    app.blocking(move |app| {
        let body = make(app, seq)?;
        Ok(([(CONTENT_TYPE, media_type)], body).into_response())
    })
    .await
}

/// A job's key from its id.
pub fn job_seq(id: &str) -> Result<JobSeq, Refusal> {
    id.parse().map_err(|_| Refusal::not_found("job", id))
}

/// The job of this key.
pub fn found(app: &App, seq: JobSeq) -> Result<JobView, Refusal> {
    app.store
        .job(seq)?
        .ok_or_else(|| Refusal::not_found("job", &seq.to_string()))
}
