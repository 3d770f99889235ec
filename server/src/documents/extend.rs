//! A job's document with more seeds: as if it had been posted with them from the beginning.

use serde_json::{Value, json};

use super::fields::Errors;
use super::templates::with_template;

/// The document, which is a valid one, with so many more seeds wherever it has some; those are the
/// ones that follow the largest.
pub fn with_more_seeds(document: &Value, more: u64) -> Value {
    // A valid document names no template that does not exist.
    let mut job = with_template(document, &mut Errors::default()).into_owned();
    // What is merged stands there in full.
    if let Some(fields) = job.as_object_mut() {
        fields.remove("template");
    }
    let own = job.pointer("/base/seed").cloned();
    let parts = job.get_mut("parts").and_then(Value::as_array_mut);
    let mut inherits = parts.is_none();
    for part in parts.into_iter().flatten() {
        match part.get_mut("seeds") {
            Some(seeds) => lengthen(seeds, more),
            None => inherits = true,
        }
    }
    match job.get_mut("seeds") {
        Some(seeds) => lengthen(seeds, more),
        None if inherits => {
            if let Some(base) = job.get_mut("base").and_then(Value::as_object_mut) {
                base.remove("seed");
            }
            let first = own.unwrap_or_else(|| json!(1));
            job["seeds"] = json!({ "first": first, "count": more + 1 });
        }
        None => {}
    }
    job
}

fn lengthen(seeds: &mut Value, more: u64) {
    match seeds {
        Value::Array(list) => {
            let largest = list.iter().filter_map(Value::as_u64).max().unwrap_or(0);
            list.extend((1..=more).map(|number| json!(largest.saturating_add(number))));
        }
        range => {
            let count = range.get("count").and_then(Value::as_u64).unwrap_or(1);
            range["count"] = json!(count.saturating_add(more));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::collections::BTreeSet;

    use super::*;
    use crate::documents::{BuiltinArenas, expand};

    fn keys(job: &Value) -> BTreeSet<String> {
        let expanded = expand(job, &BuiltinArenas).unwrap();
        expanded.runs.iter().map(|run| run.key()).collect()
    }

    #[test]
    fn a_longer_job_has_the_runs_of_the_shorter_and_as_many_more_as_asked_for() {
        let base = json!({ "controller": { "method": "brownian" } });
        let seeded = json!({ "seed": 9, "controller": { "method": "brownian" } });
        for (job, combinations) in [
            (json!({ "base": base }), 1),
            (json!({ "base": seeded }), 1),
            (json!({ "base": base, "seeds": [5, 3] }), 1),
            (
                json!({ "base": base, "seeds": { "first": 4, "count": 2 } }),
                1,
            ),
            (json!({ "base": base, "seeds": { "first": 4 } }), 1),
            (
                json!({ "base": base, "matrix": { "epochs": [1, 2, 3] } }),
                3,
            ),
            (
                json!({ "base": base, "parts": [
                    { "name": "own", "base": { "epochs": 2 }, "seeds": [1] },
                    { "name": "inherits", "base": { "epochs": 3 } },
                ] }),
                2,
            ),
            (json!({ "template": "chapter-5", "seeds": [1] }), 0),
        ] {
            let (before, after) = (keys(&job), keys(&with_more_seeds(&job, 4)));
            assert!(before.is_subset(&after), "{job}");
            let each = if combinations == 0 {
                before.len()
            } else {
                combinations
            };
            assert_eq!(after.len(), before.len() + 4 * each, "{job}");
        }
    }
}
