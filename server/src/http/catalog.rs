//! `/v1/controllers` and `/v1/templates`: what jobs can be made of.

use api::ControllerListing;
use axum::routing::get;
use axum::{Json, Router};
use serde_json::{Value, json};

use super::App;

pub fn routes() -> Router<App> {
    Router::new()
        .route("/controllers", get(controllers))
        .route("/templates", get(templates))
}

/// `GET /v1/controllers`: methods, and parameters with default, range, unit and source.
async fn controllers() -> Json<ControllerListing> {
    Json(crate::documents::controllers())
}

/// `GET /v1/templates`: prepared jobs.
async fn templates() -> Json<Value> {
    Json(json!({ "items": crate::documents::templates() }))
}
