//! `/openapi.json`, `/docs` and `/schemas/...`: what the service offers and what documents may hold,
//! for programs, people and editors.

use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::IntoResponse;

use super::App;
use super::docs;
use super::operation::{JSON, Operation, Shape, camel};
use super::routes::Routes;
use crate::documents::schemas;

const OPENAPI: &str = "/openapi.json";
const DOCS: &str = "/docs";
const SCHEMAS: &str = "/schemas/";
const HTML: &str = "text/html; charset=utf-8";
const SCHEMA_JSON: &str = "application/schema+json";

pub fn routes() -> Routes {
    let routes = Routes::new()
        .get(
            OPENAPI,
            openapi,
            Operation::new("getOpenapi", "This document")
                .answers(200, "The document.", JSON, Some(Shape::Any))
                .open(),
        )
        .get(
            DOCS,
            page,
            Operation::new("getDocs", "This document for people")
                .answers(200, "The page.", HTML, None)
                .open(),
        );
    schemas::DOCUMENTS
        .into_iter()
        .fold(routes, |routes, (document, _, title)| {
            // The test of the schemas makes each.
            let text = schemas::text(document).unwrap_or_default();
            let show = async move || ([(CONTENT_TYPE, SCHEMA_JSON)], text);
            let told = Operation::new(
                format!("get{}Schema", camel(document)),
                format!("JSON Schema (2020-12): {title}"),
            );
            let told = told
                .answers(200, "The schema.", SCHEMA_JSON, Some(Shape::Any))
                .open();
            routes.get(&format!("{SCHEMAS}{document}.json"), show, told)
        })
}

/// Whether this is a path of this file, which tells nothing of jobs.
pub fn is_contract(path: &str) -> bool {
    path == OPENAPI || path == DOCS || path.starts_with(SCHEMAS)
}

/// `GET /openapi.json`.
async fn openapi(State(app): State<App>) -> impl IntoResponse {
    ([(CONTENT_TYPE, JSON)], app.openapi)
}

/// `GET /docs`.
async fn page(State(app): State<App>) -> impl IntoResponse {
    let page = serde_json::from_slice(&app.openapi).map(|document| docs::html(&document));
    // The document was made from JSON.
    ([(CONTENT_TYPE, HTML)], page.unwrap_or_default())
}
