//! What a route is about, by the id in its path: looked up where the work for it is done, or before
//! the handler begins; 404 where there is no such.

use api::ProblemCode;
use axum::extract::{FromRequestParts, Path};
use axum::http::request::Parts;

use super::App;
use super::refusal::Refusal;
use super::request::number;
use crate::store::{JobView, RunView};

/// The id of the job in the path, for [`App::with_job`].
pub struct JobId(String);

/// The id of the run in the path, for [`App::with_run`].
pub struct RunId(String);

/// The job of the path, for handlers that do more than one thing with it.
pub struct FoundJob(pub JobView);

/// The run of the path, for handlers that do more than one thing with it.
pub struct FoundRun(pub RunView);

impl App {
    /// Does what blocks with the job of the path, as [`App::blocking`]; 404 where there is none.
    pub(super) async fn with_job<T: Send + 'static>(
        &self,
        JobId(id): JobId,
        task: impl FnOnce(&Self, JobView) -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        self.blocking(move |app| {
            let seq = number(&id);
            let seq =
                seq.ok_or_else(|| Refusal::not_found(ProblemCode::JobNotFound, "job", &id))?;
            task(app, app.job(seq)?)
        })
        .await
    }

    /// The same with the run of the path.
    pub(super) async fn with_run<T: Send + 'static>(
        &self,
        RunId(id): RunId,
        task: impl FnOnce(&Self, RunView) -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        self.blocking(move |app| task(app, app.run(&id)?)).await
    }
}

impl<S: Send + Sync> FromRequestParts<S> for JobId {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refusal> {
        id(parts, state).await.map(Self)
    }
}

impl<S: Send + Sync> FromRequestParts<S> for RunId {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refusal> {
        id(parts, state).await.map(Self)
    }
}

impl FromRequestParts<App> for FoundJob {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Refusal> {
        let id = JobId::from_request_parts(parts, app).await?;
        app.with_job(id, |_, job| Ok(Self(job))).await
    }
}

impl FromRequestParts<App> for FoundRun {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Refusal> {
        let id = RunId::from_request_parts(parts, app).await?;
        app.with_run(id, |_, run| Ok(Self(run))).await
    }
}

async fn id(parts: &mut Parts, state: &(impl Send + Sync)) -> Result<String, Refusal> {
    let path = Path::from_request_parts(parts, state).await;
    let Path(id) =
        path.map_err(|_| Refusal::new(ProblemCode::InvalidRequest, "the path cannot be read"))?;
    Ok(id)
}
