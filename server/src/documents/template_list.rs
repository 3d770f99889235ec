//! `GET /v1/templates`: prepared jobs, with the number of their runs.

use api::TemplateListing;

use super::expand::run_count;
use super::templates::prepared;

/// Every template.
pub fn templates() -> Vec<TemplateListing> {
    prepared()
        .map(|(name, about, job)| TemplateListing {
            name: name.to_owned(),
            about: about.to_owned(),
            runs: run_count(&job),
            job,
        })
        .into()
}
