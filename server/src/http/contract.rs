//! `/openapi.json`: what the service offers, for programs.

use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;

use super::App;
use super::operation::{JSON, Operation, Shape};
use super::routes::Routes;

/// Where the document is.
const OPENAPI: &str = "/openapi.json";

pub fn routes() -> Routes {
    Routes::new().get(
        OPENAPI,
        openapi,
        Operation::new("getOpenapi", "This document")
            .answers(200, "The document.", JSON, Some(Shape::Any))
            .open(),
    )
}

/// Whether this is a path of this file, which tells nothing of jobs.
pub fn is_contract(path: &str) -> bool {
    path == OPENAPI
}

/// `GET /openapi.json`.
async fn openapi(State(app): State<App>) -> impl IntoResponse {
    ([(CONTENT_TYPE, JSON)], app.openapi)
}
