//! What a route is about, by the id in its path: found before the handler begins, or 404.

use api::ProblemCode;
use axum::extract::{FromRequestParts, Path};
use axum::http::request::Parts;

use super::App;
use super::refusal::Refusal;
use crate::store::{JobView, RunView};

/// The job of the path.
pub struct FoundJob(pub JobView);

/// The run of the path.
pub struct FoundRun(pub RunView);

impl FromRequestParts<App> for FoundJob {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Refusal> {
        let id = id(parts, app).await?;
        app.blocking(move |app| {
            let seq = id
                .parse()
                .map_err(|_| Refusal::not_found(ProblemCode::JobNotFound, "job", &id))?;
            app.job(seq).map(Self)
        })
        .await
    }
}

impl FromRequestParts<App> for FoundRun {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Refusal> {
        let id = id(parts, app).await?;
        app.blocking(move |app| app.run(&id).map(Self)).await
    }
}

async fn id(parts: &mut Parts, app: &App) -> Result<String, Refusal> {
    let path = Path::from_request_parts(parts, app).await;
    let Path(id) =
        path.map_err(|_| Refusal::new(ProblemCode::InvalidRequest, "the path cannot be read"))?;
    Ok(id)
}
