//! The schema of a job's matrix: every dotted path into a run spec, with lists of values.

use serde_json::{Map, Value, json};

use crate::documents::resolve::SEED;

/// The matrix over the fields of a run spec, whose definitions are behind the prefix.
pub fn matrix(prefix: &str, definitions: &Map<String, Value>) -> Value {
    let mut paths = Map::new();
    if let Some(fields) = definitions.get("RunFields") {
        gather("", fields, prefix, definitions, &mut paths);
    }
    let known: Vec<&String> = paths.keys().collect();
    let names = json!({ "anyOf": [
        { "enum": known },
        { "pattern": r"^(controller\.train\.)?arena\.[^+]+$" },
        { "pattern": r"^[^+]+(\+[^+]+)+$" },
    ] });
    json!({
        "type": "object",
        "description": "Values to try by dotted path into the run spec. Paths with `+` between them \
            vary together: their values are lists with one entry a path.",
        "propertyNames": names,
        "properties": paths,
        "patternProperties": { r"\+": {
            "type": "array", "minItems": 1, "items": { "type": "array", "minItems": 2 },
        } },
        "additionalProperties": { "type": "array", "minItems": 1 },
    })
}

/// The paths of an object's fields and of what is inside them.
fn gather(
    path: &str,
    object: &Value,
    prefix: &str,
    definitions: &Map<String, Value>,
    paths: &mut Map<String, Value>,
) {
    let fields = object.get("properties").and_then(Value::as_object);
    for (name, field) in fields.into_iter().flatten() {
        let path = format!("{path}{name}");
        if path == SEED.name || path == "$schema" {
            continue;
        }
        let reference = field.get("$ref").and_then(Value::as_str);
        let reference = reference.and_then(|reference| reference.strip_prefix(prefix));
        let about = field.get("description").cloned();
        match reference {
            Some(reference) => {
                let schema =
                    field_values(&json!({ "$ref": format!("{prefix}{reference}") }), about);
                paths.insert(path.clone(), schema);
                // Of an arena there are too many paths: any is taken.
                let inside = definitions
                    .get(reference)
                    .filter(|_| reference != "ArenaRef");
                if let Some(inside) = inside {
                    gather(&format!("{path}."), inside, prefix, definitions, paths);
                }
            }
            None => {
                let mut plain = field.clone();
                if let Some(plain) = plain.as_object_mut() {
                    plain.remove("description");
                    plain.remove("default");
                }
                paths.insert(path.clone(), field_values(&plain, about));
                gather(&format!("{path}."), field, prefix, definitions, paths);
                for form in field
                    .get("anyOf")
                    .and_then(Value::as_array)
                    .into_iter()
                    .flatten()
                {
                    gather(&format!("{path}."), form, prefix, definitions, paths);
                }
            }
        }
    }
}

fn field_values(value: &Value, about: Option<Value>) -> Value {
    let mut list = json!({ "type": "array", "minItems": 1, "items": value });
    if let Some(about) = about {
        list["description"] = about;
    }
    list
}
