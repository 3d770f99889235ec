//! What the tests of specs and of jobs have in common.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::FieldError;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::{BuiltinArenas, ResolvedRun, resolve};

/// The run of a spec that must be right.
pub fn resolved(spec: Value) -> ResolvedRun {
    resolve(&spec, &BuiltinArenas).unwrap_or_else(|errors| panic!("{spec}: {errors:?}"))
}

/// An arena with a box and a disc to push.
pub fn yard() -> Value {
    json!({
        "name": "yard", "width_m": 0.6, "height_m": 0.6, "walls_m": [],
        "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.8 }],
        "objects": [
            { "kind": "box", "x_m": 0.2, "y_m": 0.2, "width_m": 0.06, "height_m": 0.04 },
            { "kind": "disc", "x_m": 0.35, "y_m": 0.3, "radius_m": 0.03 }
        ]
    })
}

/// The document is refused with an error at `pointer` whose message and hint contain `words`.
pub fn refused(outcome: Result<(), Vec<FieldError>>, pointer: &str, words: &str) {
    let errors = outcome
        .err()
        .unwrap_or_else(|| panic!("{pointer} was not refused"));
    let found = errors.iter().find(|error| error.pointer == pointer);
    let found = found.unwrap_or_else(|| panic!("nothing at {pointer}: {errors:#?}"));
    assert!(
        found.to_string().contains(words),
        "{found} does not say {words:?}"
    );
    assert!(
        !found.allowed.is_empty(),
        "{found} does not say what is allowed"
    );
}

/// A small arena written out.
pub fn two_rooms() -> Value {
    json!({
        "name": "two-rooms", "width_m": 0.6, "height_m": 0.6,
        "walls_m": [[0.3, 0.0, 0.3, 0.4]],
        "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.0 }]
    })
}

/// Any JSON, with names of real fields among others.
pub fn any_json() -> impl Strategy<Value = Value> {
    let names = prop::sample::select(
        [
            "schema",
            "seed",
            "arena",
            "controller",
            "epochs",
            "robots",
            "placement",
            "robot",
            "sharing",
            "record",
            "mode",
            "train",
            "method",
            "alpha",
            "name",
            "base",
            "matrix",
            "seeds",
            "first",
            "count",
            "template",
            "width_m",
            "height_m",
            "walls_m",
            "starts",
            "generate",
            "kind",
            "controller.alpha",
            "arena.name",
            "x",
            "",
        ]
        .map(str::to_owned)
        .to_vec(),
    );
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        (0u64..20).prop_map(Value::from),
        prop::sample::select(vec!["maze", "im", "first-job", "grid", "~/", "é"])
            .prop_map(Value::from),
    ];
    leaf.prop_recursive(4, 40, 6, move |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
            prop::collection::vec((names.clone(), inner), 0..6)
                .prop_map(|fields| Value::Object(fields.into_iter().collect())),
        ]
    })
}
