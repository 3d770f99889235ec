//! Which documents are much work, as far as can be told before it is done.

use serde_json::Value;

use super::expand::run_count;

/// More runs than this are much work ...
const MANY_RUNS: u64 = 1_000;
/// ... and so are fewer that have so much text together.
const MUCH_TEXT_BYTES: u64 = 1 << 20;
/// Fields of arenas that are short to say and long to write out.
const SHORT_FOR_MANY: [&str; 2] = ["generate", "tile"];
/// Fields that name arenas.
const NAMES_ARENA: [&str; 2] = ["arena", "from"];

/// Whether making what a document of so many bytes says may take much memory or time however short
/// it is: it makes many runs, has walls made or repeated, or names an arena that is large.
pub fn is_heavy(document: &Value, bytes: usize, is_large: &dyn Fn(&str) -> bool) -> bool {
    let runs = run_count(document);
    runs > MANY_RUNS
        || runs.saturating_mul(bytes as u64) > MUCH_TEXT_BYTES
        || has_large(document, is_large)
}

/// In a field, or where the path of an axis leads.
fn has_large(value: &Value, is_large: &dyn Fn(&str) -> bool) -> bool {
    match value {
        Value::Object(fields) => fields.iter().any(|(name, value)| {
            let last = |path: &str| NAMES_ARENA.iter().any(|field| path.ends_with(field));
            SHORT_FOR_MANY.iter().any(|field| name.contains(field))
                || name.split('+').any(last) && names_large(value, is_large)
                || has_large(value, is_large)
        }),
        Value::Array(values) => values.iter().any(|value| has_large(value, is_large)),
        _ => false,
    }
}

/// Whether a value, or one of a list of values or of lists of them, is a large arena's name.
fn names_large(value: &Value, is_large: &dyn Fn(&str) -> bool) -> bool {
    match value {
        Value::String(name) => is_large(name),
        Value::Array(values) => values.iter().any(|value| names_large(value, is_large)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_is_short_for_much_is_heavy() {
        let is_heavy = |document: &Value, bytes| is_heavy(document, bytes, &|name| name == "mine");
        let generated = json!({ "kind": "maze", "seed": 1 });
        for heavy in [
            json!({ "generate": generated }),
            json!({ "base": { "arena": { "from": { "generate": generated } } } }),
            json!({ "matrix": { "arena.tile+robots": [] } }),
            json!({ "parts": [{ "matrix": { "arena": [{ "tile": [1, 2] }] } }] }),
            json!({ "seeds": { "count": 1_001 } }),
            json!({ "base": { "arena": "mine" } }),
            json!({ "base": { "arena": { "from": "mine" } } }),
            json!({ "matrix": { "arena+robots": [["easy", 1], ["mine", 2]] } }),
            json!({ "matrix": { "controller.train.arena": ["mine"] } }),
        ] {
            assert!(is_heavy(&heavy, 100), "{heavy}");
        }
        let light = json!({
            "base": { "arena": "easy", "controller": { "method": "im" } },
            "matrix": { "arena": ["easy", "small"] }, "seeds": { "count": 500 }
        });
        for light in [json!({}), json!(["easy"]), light.clone()] {
            assert!(!is_heavy(&light, 100), "{light}");
        }
        assert!(is_heavy(&light, 2_000));
    }
}
