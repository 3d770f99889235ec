//! JSON Schemas (2020-12) of the documents that people write, for editors and for the OpenAPI
//! document. Names, ranges and defaults are those that documents are checked with.

mod about;
mod arena;
mod common;
mod job;
mod matrix;
mod run;
#[cfg(test)]
mod tests;

pub use about::plain;
use serde_json::{Map, Value, json};

/// Where definitions are in a schema by itself.
const OWN: &str = "#/$defs/";

/// The documents: name of the file, of the definition, and what it is.
pub const DOCUMENTS: [(&str, &str, &str); 3] = [
    ("run", "RunSpec", "A run spec of evswarm"),
    ("job", "JobSpec", "A job of evswarm"),
    ("arena", "Arena", "An arena of evswarm"),
];

/// Every definition; they refer to each other by this and their names.
pub fn definitions(prefix: &str) -> Map<String, Value> {
    let mut all = arena::definitions(prefix);
    all.extend(run::definitions(prefix));
    all.extend(job::definitions(prefix));
    all
}

/// The schema of a document as text; `None` where there is no such document.
pub fn text(document: &str) -> Option<String> {
    let (_, name, title) = DOCUMENTS.iter().find(|(file, ..)| *file == document)?;
    let mut needed = Map::new();
    keep(name, &definitions(OWN), &mut needed);
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        "$ref": format!("{OWN}{name}"),
        "$defs": needed,
    });
    let mut text = serde_json::to_string_pretty(&schema).ok()?;
    text.push('\n');
    Some(text)
}

/// Takes over a definition with all that it refers to.
fn keep(name: &str, all: &Map<String, Value>, kept: &mut Map<String, Value>) {
    if kept.contains_key(name) {
        return;
    }
    let Some(schema) = all.get(name) else { return };
    kept.insert(name.to_owned(), schema.clone());
    let mut names = Vec::new();
    referred(schema, &mut names);
    for name in names {
        keep(&name, all, kept);
    }
}

fn referred(schema: &Value, names: &mut Vec<String>) {
    match schema {
        Value::Object(map) => {
            if let Some(name) = map.get("$ref").and_then(Value::as_str) {
                names.extend(name.strip_prefix(OWN).map(str::to_owned));
            }
            map.values().for_each(|inside| referred(inside, names));
        }
        Value::Array(list) => list.iter().for_each(|inside| referred(inside, names)),
        _ => {}
    }
}
