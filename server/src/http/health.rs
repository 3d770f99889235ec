//! `/health/...`: whether the process lives and whether it can do its work.

use axum::extract::State;
use axum::routing::get;
use axum::{Json, Router};
use serde_json::{Value, json};

use super::App;
use super::refusal::Refusal;

pub fn routes() -> Router<App> {
    Router::new()
        .route("/health/livez", get(livez))
        .route("/health/readyz", get(readyz))
}

/// Whether this is a path of this file.
pub fn is_health(path: &str) -> bool {
    ["/health/livez", "/health/readyz"].contains(&path)
}

/// `GET /health/livez`.
async fn livez() -> Json<Value> {
    Json(json!({ "status": "ok" }))
}

/// `GET /health/readyz`: whether the database answers.
async fn readyz(State(app): State<App>) -> Result<Json<Value>, Refusal> {
    app.blocking(|app| {
        app.store.ping()?;
        Ok(Json(json!({ "status": "ok" })))
    })
    .await
}
