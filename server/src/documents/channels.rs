//! What is asked of a run's channels: the body of `POST /v1/runs/{id}/channels`.

use api::FieldError;
use serde_json::Value;

use super::domains::{Flag, Whole};
use super::fields::{Errors, Object};
use crate::channels::{ChannelSet, LosslessSettings};

const EVERY_STEPS: Whole = Whole {
    name: "every_steps",
    min: 1,
    max: 1_000_000,
    default: 1,
};
const TIMEOUT_MS: Whole = Whole {
    name: "timeout_ms",
    min: 1,
    max: 60_000,
    default: 5_000,
};
const READERS: Whole = Whole {
    name: "readers",
    min: 0,
    max: 8,
    default: 0,
};
const NAMES: [&str; 5] = ["frames", "coverage", "metrics", "status", "lossless"];

/// Reads which channels are asked for.
///
/// # Errors
/// What is wrong with the document.
pub fn asked_channels(document: &Value) -> Result<ChannelSet, Vec<FieldError>> {
    let mut errors = Errors::default();
    let set = read(document, &mut errors);
    match set {
        Some(set) if errors.is_empty() => Ok(set),
        _ => Err(errors.into_vec()),
    }
}

fn read(document: &Value, errors: &mut Errors) -> Option<ChannelSet> {
    let object = Object::open(document, "", NAMES, errors)?;
    let mut flag = |name| {
        let default = false;
        object.flag(&Flag { name, default }, errors)
    };
    let [frames, coverage, metrics, status] =
        ["frames", "coverage", "metrics", "status"].map(&mut flag);
    let lossless = match object.get("lossless") {
        None | Some(Value::Null) => None,
        Some(asked) => Some(lossless(asked, errors)?),
    };
    Some(ChannelSet {
        frames,
        coverage,
        metrics,
        status,
        lossless,
    })
}

fn lossless(asked: &Value, errors: &mut Errors) -> Option<LosslessSettings> {
    let known = ["every_steps", "timeout_ms", "readers"];
    let object = Object::open(asked, "/lossless", known, errors)?;
    // All three are of 32 bits by their ranges.
    let mut whole = |field| object.whole(field, errors) as u32;
    Some(LosslessSettings {
        every_steps: whole(&EVERY_STEPS),
        timeout_ms: whole(&TIMEOUT_MS),
        readers: whole(&READERS),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use serde_json::json;

    use super::*;

    #[test]
    fn nothing_is_lossless_unless_it_is_asked_for() {
        assert!(asked_channels(&json!({})).unwrap().is_empty());
        let all = json!({ "frames": true, "coverage": true, "metrics": true, "status": true });
        let all = asked_channels(&all).unwrap();
        assert_eq!(all, ChannelSet::of_spec(true));
        let asked = asked_channels(&json!({ "lossless": { "every_steps": 3 } })).unwrap();
        let lossless = asked.lossless.unwrap();
        assert_eq!(
            (lossless.every_steps, lossless.timeout_ms, lossless.readers),
            (3, 5_000, 0)
        );
        assert!(
            asked_channels(&json!({ "lossless": null }))
                .unwrap()
                .is_empty()
        );
    }

    #[test]
    fn wrong_fields_are_all_told() {
        for (document, pointer) in [
            (json!([]), ""),
            (json!({ "frame": true }), "/frame"),
            (json!({ "frames": 1 }), "/frames"),
            (json!({ "lossless": true }), "/lossless"),
            (
                json!({ "lossless": { "every_steps": 0 } }),
                "/lossless/every_steps",
            ),
            (
                json!({ "lossless": { "timeout_ms": 600_001 } }),
                "/lossless/timeout_ms",
            ),
            (json!({ "lossless": { "readers": 9 } }), "/lossless/readers"),
        ] {
            let errors = asked_channels(&document).unwrap_err();
            assert_eq!(errors[0].pointer, pointer, "{document}");
        }
    }
}
