//! A job of several parts, each a product of its own: `"parts": [{"base", "matrix", "seeds"}]`.

use std::collections::BTreeSet;

use api::FieldError;
use serde_json::{Map, Value};

use super::fields::{Errors, Object, join, kind};

/// Most parts of a job.
pub(super) const MAX_PARTS: usize = 32;

/// Longest name of a part, in characters.
pub(super) const MAX_NAME: usize = 40;

pub(super) const FIELDS: [&str; 4] = ["name", "base", "matrix", "seeds"];

/// One part.
pub struct Part {
    /// Its name, no other part's.
    pub name: String,
    /// It as a job: its base over the job's, its matrix, its seeds or the job's.
    pub job: Value,
    /// Its place among the parts.
    place: usize,
    /// What it says itself.
    own: Value,
}

impl Part {
    /// An error in [`Part::job`] as one in the whole job: what the part does not say itself stands
    /// in the job.
    pub fn in_job(&self, error: FieldError) -> FieldError {
        let own = format!("/parts/{}", self.place);
        let pointer = match error.pointer.as_str() {
            "" => own,
            // The base is the two put into each other: told where the field stands.
            pointer if self.own.pointer(pointer).is_some() || pointer.starts_with("/matrix") => {
                format!("{own}{pointer}")
            }
            pointer => pointer.to_owned(),
        };
        FieldError { pointer, ..error }
    }
}

/// The parts of a job; none where it has no such field, `None` where they are wrong.
pub fn parts(job: &Value, errors: &mut Errors) -> Option<Vec<Part>> {
    let Some(value) = job.get("parts") else {
        return Some(Vec::new());
    };
    let allowed = format!("a list of 1 to {MAX_PARTS} parts, each with base, matrix and seeds");
    let list = match value {
        Value::Array(list) if (1..=MAX_PARTS).contains(&list.len()) => list,
        Value::Array(list) => {
            errors.add("/parts", format!("holds {} parts", list.len()), allowed);
            return None;
        }
        _ => {
            let message = format!("must be a list, not {}", kind(value));
            errors.add("/parts", message, allowed);
            return None;
        }
    };
    if job.get("matrix").is_some() {
        errors.add(
            "/matrix",
            "stands beside parts",
            "one of the two: each part has a matrix of its own",
        );
        return None;
    }
    let mut names = BTreeSet::new();
    let parts: Vec<Part> = list
        .iter()
        .enumerate()
        .filter_map(|(place, own)| {
            let part = part(job, place, own, errors)?;
            if !names.insert(part.name.clone()) {
                let message = format!("{:?} is another part's name", part.name);
                errors.add(format!("/parts/{place}/name"), message, "a name of its own");
                return None;
            }
            Some(part)
        })
        .collect();
    (parts.len() == list.len()).then_some(parts)
}

fn part(job: &Value, place: usize, own: &Value, errors: &mut Errors) -> Option<Part> {
    let pointer = format!("/parts/{place}");
    let object = Object::open(own, &pointer, FIELDS, errors)?;
    let name = match object.get("name") {
        None => format!("part {}", place + 1),
        Some(Value::String(name)) if (1..=MAX_NAME).contains(&name.chars().count()) => name.clone(),
        Some(_) => {
            errors.add(
                join(&pointer, "name"),
                "is no name of a part",
                format!("a string of 1 to {MAX_NAME} characters"),
            );
            return None;
        }
    };
    let mut base = job
        .get("base")
        .cloned()
        .unwrap_or_else(|| Map::new().into());
    if let Some(own) = object.get("base") {
        merge(&mut base, own);
    }
    let mut made = Map::new();
    made.insert("base".to_owned(), base);
    let of_job = job.get("seeds");
    for (field, value) in [
        ("matrix", object.get("matrix")),
        ("seeds", object.get("seeds").or(of_job)),
    ] {
        if let Some(value) = value {
            made.insert(field.to_owned(), value.clone());
        }
    }
    Some(Part {
        name,
        job: Value::Object(made),
        place,
        own: own.clone(),
    })
}

/// Puts `over` into `under`: objects field by field, anything else in place of what is there.
fn merge(under: &mut Value, over: &Value) {
    match (under, over) {
        (Value::Object(under), Value::Object(over)) => {
            for (name, value) in over {
                merge(under.entry(name).or_insert(Value::Null), value);
            }
        }
        (under, over) => *under = over.clone(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use serde_json::json;

    use super::*;

    fn told(job: Value) -> (Option<Vec<Part>>, Vec<FieldError>) {
        let mut errors = Errors::default();
        let parts = parts(&job, &mut errors);
        (parts, errors.into_vec())
    }

    #[test]
    fn a_part_is_a_job_of_its_own_over_the_common_base() {
        let (parts, errors) = told(json!({
            "base": { "epochs": 5, "controller": { "method": "im", "alpha": 0.5 } },
            "seeds": [1, 2],
            "parts": [
                { "matrix": { "arena": ["easy"] } },
                { "name": "other", "base": { "controller": { "alpha": 1, "train": null } },
                  "seeds": [7] }
            ]
        }));
        assert!(errors.is_empty());
        let parts = parts.unwrap();
        assert_eq!(
            (parts[0].name.as_str(), parts[1].name.as_str()),
            ("part 1", "other")
        );
        assert_eq!(
            parts[0].job,
            json!({
                "base": { "epochs": 5, "controller": { "method": "im", "alpha": 0.5 } },
                "matrix": { "arena": ["easy"] }, "seeds": [1, 2]
            })
        );
        assert_eq!(
            parts[1].job,
            json!({
                "base": {
                    "epochs": 5, "controller": { "method": "im", "alpha": 1, "train": null }
                },
                "seeds": [7]
            })
        );
    }

    #[test]
    fn errors_point_at_where_the_field_stands() {
        let (parts, _) = told(json!({
            "base": { "epochs": 0 },
            "parts": [{ "base": { "robots": 0 }, "matrix": { "arena": ["x"] } }]
        }));
        let part = &parts.unwrap()[0];
        for (inside, outside) in [
            ("", "/parts/0"),
            ("/base/epochs", "/base/epochs"),
            ("/base/robots", "/parts/0/base/robots"),
            ("/matrix/arena/0", "/parts/0/matrix/arena/0"),
            ("/seeds", "/seeds"),
        ] {
            let error = part.in_job(FieldError::new(inside, "is wrong", "else"));
            assert_eq!(error.pointer, outside);
        }
    }

    #[test]
    fn wrong_parts_are_refused() {
        for (job, pointer) in [
            (json!({ "parts": [] }), "/parts"),
            (json!({ "parts": 3 }), "/parts"),
            (json!({ "parts": [7] }), "/parts/0"),
            (json!({ "parts": [{ "name": "" }] }), "/parts/0/name"),
            (json!({ "parts": [{ "seed": 1 }] }), "/parts/0/seed"),
            (json!({ "parts": [{}], "matrix": {} }), "/matrix"),
            (
                json!({ "parts": [{ "name": "a" }, { "name": "a" }] }),
                "/parts/1/name",
            ),
            (json!({ "parts": vec![json!({}); MAX_PARTS + 1] }), "/parts"),
        ] {
            let (_, errors) = told(job.clone());
            assert_eq!(errors[0].pointer, pointer, "{job}");
        }
    }
}
