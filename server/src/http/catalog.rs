//! `/v1/controllers`, `/v1/templates`, `/v1/version`: what jobs can be made of, and by which program.

use api::{ControllerListing, Version};
use axum::routing::get;
use axum::{Json, Router};
use serde_json::{Value, json};

use super::App;

pub fn routes() -> Router<App> {
    Router::new()
        .route("/controllers", get(controllers))
        .route("/templates", get(templates))
        .route("/version", get(version))
}

/// `GET /v1/controllers`: methods, and parameters with default, range, unit and source.
async fn controllers() -> Json<ControllerListing> {
    Json(crate::documents::controllers())
}

/// `GET /v1/version`: of the program, of its results and of the documents that it takes.
async fn version() -> Json<Version> {
    Json(Version {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        results_version: swarm::RESULTS_VERSION,
        schema: api::SCHEMA,
    })
}

/// `GET /v1/templates`: prepared jobs.
async fn templates() -> Json<Value> {
    Json(json!({ "items": crate::documents::templates() }))
}
