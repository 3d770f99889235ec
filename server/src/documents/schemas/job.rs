//! The schema of a job.

use serde_json::{Map, Value, json};

use super::about::object;
use super::common::{reference, schema_link};
use super::matrix::matrix;
use super::run;
use crate::documents::expand::{FIRST_SEED, MAX_NAME, MAX_RUNS, SEED_COUNT};
use crate::documents::limits::MAX_SEED;
use crate::documents::parts::{MAX_NAME as MAX_PART_NAME, MAX_PARTS};
use crate::documents::resolve::VERSION;
use crate::documents::templates;

/// `JobSpec` and what it is made of.
pub fn definitions(prefix: &str) -> Map<String, Value> {
    let part = object::<api::JobPart>([
        (
            "name",
            json!({ "type": "string", "minLength": 1, "maxLength": MAX_PART_NAME }),
        ),
        ("base", reference(prefix, "RunFields")),
        ("matrix", reference(prefix, "Matrix")),
        ("seeds", reference(prefix, "Seeds")),
    ]);
    let parts = json!({ "type": "array", "minItems": 1, "maxItems": MAX_PARTS, "items": part });
    let mut job = object::<api::JobSpec>([
        ("$schema", schema_link()),
        (VERSION.name, VERSION.schema()),
        ("name", json!({ "type": "string", "maxLength": MAX_NAME })),
        ("base", reference(prefix, "RunFields")),
        ("matrix", reference(prefix, "Matrix")),
        ("seeds", reference(prefix, "Seeds")),
        ("parts", parts),
        ("template", json!({ "enum": templates::names() })),
    ]);
    job["dependentSchemas"] = json!({ "parts": { "properties": { "matrix": false } } });
    [
        ("JobSpec", job),
        ("Matrix", matrix(prefix, &run::definitions(prefix))),
        ("Seeds", seeds()),
    ]
    .into_iter()
    .map(|(name, schema)| (name.to_owned(), schema))
    .collect()
}

fn seeds() -> Value {
    let range = json!({
        "type": "object",
        "properties": { (FIRST_SEED.name): FIRST_SEED.schema(), (SEED_COUNT.name): SEED_COUNT.schema() },
        "additionalProperties": false,
    });
    let list = json!({
        "type": "array", "minItems": 1, "maxItems": MAX_RUNS, "uniqueItems": true,
        "items": { "type": "integer", "minimum": 0, "maximum": MAX_SEED },
    });
    json!({ "description": "Seeds to repeat each combination with.", "anyOf": [range, list] })
}
