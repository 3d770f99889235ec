//! What schemas of documents have in common.

use serde_json::{Value, json};

/// A reference to a definition.
pub fn reference(prefix: &str, name: &str) -> Value {
    json!({ "$ref": format!("{prefix}{name}") })
}

/// The field that tells an editor where the schema is.
pub fn schema_link() -> Value {
    json!({
        "type": "string",
        "description": "Where an editor finds the JSON Schema of this document; not read.",
    })
}

/// A schema, or null.
pub fn or_null(schema: Value) -> Value {
    json!({ "anyOf": [schema, { "type": "null" }] })
}
