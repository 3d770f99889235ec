//! Documents that once were taken silently for something else.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use serde_json::{Value, json};

use super::testing::{refused, resolved, two_rooms};
use super::*;

#[test]
fn a_key_that_stands_twice_is_refused_in_a_run_and_in_a_matrix() {
    let run = r#"{"arena":"easy","controller":{"method":"brownian"},"epochs":1,"epochs":2}"#;
    refused(parse(run).map(drop), "/epochs", "twice");
    let job =
        r#"{"base":{"arena":"easy"},"matrix":{"controller.eta":[0.1,0.2],"controller.eta":[0.4]}}"#;
    refused(parse(job).map(drop), "/matrix/controller.eta", "twice");
}

#[test]
fn a_spec_with_a_byte_order_mark_is_accepted() {
    let text = "\u{feff}{\"arena\":\"easy\",\"controller\":{\"method\":\"brownian\"},\"epochs\":1}";
    assert_eq!(resolved(parse(text).unwrap()).epochs(), 1);
}

fn methods_and_eta(matrix: Value) -> Result<usize, Vec<api::FieldError>> {
    let job = json!({ "base": { "arena": "easy", "epochs": 2 }, "matrix": matrix });
    expand(&job, &BuiltinArenas).map(|job| job.runs.len())
}

#[test]
fn a_matrix_may_not_vary_what_a_method_does_not_have() {
    let both = json!({ "controller.method": ["im", "brownian"], "controller.eta": [0.1, 0.2] });
    refused(
        methods_and_eta(both).map(drop),
        "/matrix/controller.eta/1",
        "brownian has no eta",
    );
    let evolved = json!({
        "controller.method": ["curiosity"], "controller.lambda": [10, 20], "epochs": [1, 2]
    });
    refused(
        methods_and_eta(evolved).map(drop),
        "/matrix/controller.lambda/1",
        "curiosity has no lambda",
    );
    // Each method has the parameter, or it does not vary.
    for (matrix, runs) in [
        (
            json!({ "controller.method": ["im", "ev-iter-c"], "controller.eta": [0.1, 0.2] }),
            4,
        ),
        (
            json!({ "controller.method": ["im", "brownian"], "controller.eta": [0.1] }),
            2,
        ),
        (
            json!({ "controller.method+controller.eta": [["im", 0.1], ["im", 0.2], ["brownian", 0.2]] }),
            3,
        ),
    ] {
        assert_eq!(methods_and_eta(matrix).unwrap(), runs);
    }
    let parts = json!({
        "base": { "arena": "easy", "epochs": 2 },
        "parts": [
            { "base": { "controller": { "method": "brownian", "eta": 0.3 } } },
            { "base": { "controller": { "method": "brownian" } } }
        ]
    });
    refused(
        expand(&parts, &BuiltinArenas).map(drop),
        "/parts/1",
        "already has",
    );
}

#[test]
fn an_arena_may_not_carry_a_built_in_one_s_name_with_other_walls() {
    let spec = |arena: Value| resolve(&json!({ "arena": arena }), &BuiltinArenas).map(drop);
    let mut other = two_rooms();
    other["name"] = json!("easy");
    refused(spec(other.clone()), "/arena/name", "built-in");
    refused(
        spec(json!({ "from": other, "tile": [2, 1] })),
        "/arena/from/name",
        "built-in",
    );
    refused(
        spec(json!({ "from": "maze", "tile": [2, 1], "name": "maze" })),
        "/arena/name",
        "built-in",
    );
    let easy = BuiltinArenas.arena("easy").unwrap().to_format();
    spec(serde_json::to_value(easy).unwrap()).unwrap();
}

#[test]
fn many_wrong_walls_and_starts_are_counted() {
    let mut arena = two_rooms();
    arena["walls_m"] = json!(vec![[0.0, 0.0, 9.0, 9.0]; 5_000]);
    let errors = resolve(&json!({ "arena": arena, "robots": 0 }), &BuiltinArenas).unwrap_err();
    assert_eq!(errors.len(), 101);
    assert_eq!(errors[100].message, "and 4901 wrong fields more");
}

#[test]
fn placement_is_a_kind_or_says_that_robots_may_be_anywhere() {
    let spec = |placement: Value| json!({ "arena": "easy", "placement": placement, "robots": 2 });
    let plain = resolved(spec(json!("random")));
    let said = resolved(spec(json!({ "kind": "random", "anywhere": false })));
    assert_eq!(plain.canonical_json(), said.canonical_json());
    let anywhere = resolved(spec(json!({ "kind": "random", "anywhere": true })));
    assert_ne!(plain.key(), anywhere.key());
    let again = resolved(parse(&anywhere.canonical_json()).unwrap());
    assert_eq!(again.key(), anywhere.key());
    for (wrong, pointer) in [
        (json!("random-anywhere"), "/placement"),
        (json!({ "kind": "rnadom" }), "/placement/kind"),
        (
            json!({ "kind": "grid", "anywere": true }),
            "/placement/anywere",
        ),
        (
            json!({ "kind": "grid", "anywhere": 1 }),
            "/placement/anywhere",
        ),
        (json!({ "anywhere": true }), "/placement/anywhere"),
        (json!(["grid"]), "/placement"),
    ] {
        refused(resolve(&spec(wrong), &BuiltinArenas).map(drop), pointer, "");
    }
    let job = json!({
        "base": { "arena": "easy", "robots": 2, "placement": { "kind": "random" } },
        "matrix": { "placement.anywhere": [false, true] }
    });
    assert_eq!(expand(&job, &BuiltinArenas).unwrap().runs.len(), 2);
}
