//! `/problems`: what the codes of refusals mean. The `type` of a problem is a reference to here.

use api::ProblemCode;
use axum::extract::Path;
use axum::routing::get;
use axum::{Json, Router};
use serde_json::{Value, json};

use super::App;
use super::refusal::Refusal;

/// Where the routes of this file are.
const PREFIX: &str = "/problems";

pub fn routes() -> Router<App> {
    Router::new()
        .route(PREFIX, get(list))
        .route(&format!("{PREFIX}/{{code}}"), get(show))
}

/// Whether this is a path of this file.
pub fn is_problem(path: &str) -> bool {
    path.strip_prefix(PREFIX)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// `GET /problems`: all of them, by status.
async fn list() -> Json<Value> {
    let items: Vec<Value> = ProblemCode::ALL.iter().copied().map(told).collect();
    Json(json!({ "items": items }))
}

/// `GET /problems/{code}`.
async fn show(Path(code): Path<String>) -> Result<Json<Value>, Refusal> {
    let problem = ProblemCode::from_code(&code)
        .ok_or_else(|| Refusal::not_found(ProblemCode::RouteNotFound, "problem", &code))?;
    Ok(Json(told(problem)))
}

fn told(problem: ProblemCode) -> Value {
    json!({
        "type": problem.uri(),
        "code": problem.code(),
        "status": problem.status(),
        "title": problem.title(),
        "meaning": problem.meaning(),
    })
}
