//! Which documents are work, as far as can be told before it is done.

use serde_json::Value;

use super::expand::run_count;

/// More runs than this are work.
const MANY_RUNS: u64 = 1_000;
/// Fields of arenas that are short to say and long to write out.
const SHORT_FOR_MANY: [&str; 2] = ["generate", "tile"];

/// Whether making what a document says may take much memory or time however short it is: it has
/// walls made or repeated, or makes many runs.
pub fn is_heavy(document: &Value) -> bool {
    has_short_for_many(document) || run_count(document) > MANY_RUNS
}

/// In a field's name or in the path of an axis.
fn has_short_for_many(value: &Value) -> bool {
    match value {
        Value::Object(fields) => fields.iter().any(|(name, value)| {
            SHORT_FOR_MANY.iter().any(|field| name.contains(field)) || has_short_for_many(value)
        }),
        Value::Array(values) => values.iter().any(has_short_for_many),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_is_short_for_much_is_heavy() {
        let generated = json!({ "kind": "maze", "seed": 1 });
        for heavy in [
            json!({ "generate": generated }),
            json!({ "base": { "arena": { "from": { "generate": generated } } } }),
            json!({ "matrix": { "arena.tile+robots": [] } }),
            json!({ "parts": [{ "matrix": { "arena": [{ "tile": [1, 2] }] } }] }),
            json!({ "seeds": { "count": 1_001 } }),
        ] {
            assert!(is_heavy(&heavy), "{heavy}");
        }
        for light in [
            json!({}),
            json!(["easy"]),
            json!({ "base": { "arena": "easy" }, "seeds": { "count": 1_000 } }),
        ] {
            assert!(!is_heavy(&light), "{light}");
        }
    }
}
