//! `/problems`: what the codes of refusals mean. The `type` of a problem is a reference to here.

use api::ProblemCode::{self, RouteNotFound};
use api::{ProblemList, ProblemMeaning};
use axum::Json;
use axum::extract::Path;

use super::operation::Operation;
use super::refusal::Refusal;
use super::routes::Routes;

/// Where the routes of this file are.
const PREFIX: &str = "/problems";

pub fn routes() -> Routes {
    Routes::new()
        .get(
            PREFIX,
            list,
            Operation::new("listProblems", "Every kind of problem, by status")
                .shows::<ProblemList>("All of them.")
                .open(),
        )
        .get(
            &format!("{PREFIX}/{{code}}"),
            show,
            Operation::new("getProblem", "What a kind of problem means")
                .shows::<ProblemMeaning>("Its meaning.")
                .refuses(&[RouteNotFound])
                .open(),
        )
}

/// Whether this is a path of this file.
pub fn is_problem(path: &str) -> bool {
    path.strip_prefix(PREFIX)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// `GET /problems`: all of them, by status.
async fn list() -> Json<ProblemList> {
    let items = ProblemCode::ALL.iter().copied();
    Json(ProblemList {
        items: items.map(ProblemMeaning::from).collect(),
    })
}

/// `GET /problems/{code}`.
async fn show(Path(code): Path<String>) -> Result<Json<ProblemMeaning>, Refusal> {
    let problem = ProblemCode::from_code(&code)
        .ok_or_else(|| Refusal::not_found(RouteNotFound, "problem", &code))?;
    Ok(Json(problem.into()))
}
