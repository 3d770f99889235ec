//! JSON Schemas of the documents that people write.

use serde_json::{Map, Value, json};

/// Their definitions, which refer to each other behind this prefix.
pub fn definitions(_prefix: &str) -> Map<String, Value> {
    ["RunSpec", "JobSpec", "Arena"]
        .into_iter()
        .map(|name| (name.to_owned(), json!({ "type": "object" })))
        .collect()
}
