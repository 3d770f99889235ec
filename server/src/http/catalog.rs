//! `/v1/controllers`, `/v1/templates`, `/v1/version`: what jobs can be made of, and by which program.

use api::{ControllerListing, TemplateList, Version};
use axum::Json;

use super::operation::Operation;
use super::routes::Routes;

pub fn routes() -> Routes {
    Routes::new()
        .get(
            "/controllers",
            controllers,
            Operation::new("listControllers", "Methods and parameters")
                .details("Each parameter with its default, range, unit and source.")
                .shows::<ControllerListing>("All that `controller` and `robot` may hold."),
        )
        .get(
            "/templates",
            templates,
            Operation::new("listTemplates", "Prepared jobs").shows::<TemplateList>("All of them."),
        )
        .get(
            "/version",
            version,
            Operation::new(
                "getVersion",
                "Version of the program, of results and of documents",
            )
            .shows::<Version>("The versions."),
        )
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
async fn templates() -> Json<TemplateList> {
    Json(TemplateList {
        items: crate::documents::templates(),
    })
}
