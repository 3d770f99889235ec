//! `/health/...`: whether the process lives and whether it can do its work. Answered without a place
//! among the other requests, as whoever asks may end the process when no answer comes.

use std::time::Duration;

use api::ProblemCode;
use axum::extract::State;
use axum::routing::get;
use axum::{Json, Router};
use serde_json::{Value, json};

use super::App;
use super::refusal::Refusal;
use crate::store::StoreError;

/// Where it is told that the process lives.
const LIVE: [&str; 2] = ["/health/livez", "/healthz"];
/// Where it is told that it can do its work.
const READY: [&str; 2] = ["/health/readyz", "/readyz"];
/// Longest time that the database may take to answer.
const DATABASE_TIME: Duration = Duration::from_secs(1);

pub fn routes() -> Router<App> {
    let live = LIVE
        .iter()
        .fold(Router::new(), |router, path| router.route(path, get(livez)));
    READY
        .iter()
        .fold(live, |router, path| router.route(path, get(readyz)))
}

/// Whether this is a path of this file.
pub fn is_health(path: &str) -> bool {
    LIVE.contains(&path) || READY.contains(&path)
}

/// `GET /health/livez`: touches nothing else.
async fn livez() -> Json<Value> {
    Json(json!({ "status": "ok" }))
}

/// `GET /health/readyz`: whether the database answers soon, and there is room.
async fn readyz(State(app): State<App>) -> Result<Json<Value>, Refusal> {
    let not_ready = |detail: &str| Refusal::new(ProblemCode::NotReady, detail).retry_after_s(1);
    let ping = app.blocking(|app| Ok(app.store.ping()));
    match tokio::time::timeout(DATABASE_TIME, ping).await {
        Ok(Ok(Ok(()))) => Ok(Json(json!({ "status": "ok" }))),
        Ok(Ok(Err(error @ StoreError::Full(_)))) => Err(not_ready(&error.to_string())),
        Ok(Ok(Err(error))) => {
            tracing::error!(%error, "the database does not answer");
            Err(not_ready(
                "the database does not answer; the server's log says why",
            ))
        }
        Ok(Err(refusal)) => Err(refusal),
        Err(_) => Err(not_ready("the database takes too long to answer")),
    }
}
