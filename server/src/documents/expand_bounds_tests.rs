//! Jobs that are short to say and much to make: refused before they are made.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use serde_json::{Value, json};

use super::expand_tests::check_job;
use super::testing::two_rooms;
use super::*;

#[test]
fn a_long_arena_in_many_combinations_is_refused_at_once() {
    let mut arena = two_rooms();
    arena["walls_m"] = vec![json!([0.3, 0.0, 0.3, 0.4]); 10_000].into();
    let epochs: Vec<u32> = (1..=10_000).collect();
    let job = json!({ "base": { "arena": arena }, "matrix": { "epochs": epochs } });
    check_job(job, "", "too much to read");
}

#[test]
fn walls_that_many_combinations_write_out_are_bounded() {
    // Short to say, 23,000 walls each: what 2,000 of them show would be gigabytes.
    let rooms = json!({
        "name": "long", "width_m": 1_000.0, "height_m": 0.5,
        "generate": { "kind": "rooms", "seed": 0 }
    });
    let brownian = json!({ "method": "brownian" });
    let base = json!({ "arena": rooms, "controller": brownian });
    let refused = |matrix: Value, pointer: &str| {
        let job = json!({ "base": base, "matrix": matrix });
        let errors = expand(&job, &BuiltinArenas).unwrap_err();
        assert!(
            errors[0].message.contains("write out too many walls"),
            "{errors:?}"
        );
        assert!(errors[0].pointer.starts_with(pointer), "{errors:?}");
    };
    let numbers: Vec<u32> = (1..=2_000).collect();
    refused(json!({ "arena.generate.seed": numbers }), "/matrix");
    // The same arena in each of them, too.
    refused(json!({ "epochs": numbers }), "/base/arena");
    let few =
        json!({ "base": base, "matrix": { "epochs": [1, 2, 3] }, "seeds": { "count": 1_000 } });
    assert_eq!(expand(&few, &BuiltinArenas).unwrap().runs.len(), 3_000);
}

#[test]
fn objects_that_many_combinations_write_out_are_bounded() {
    let discs = (0..100).map(|number| {
        let (x, y) = (number % 10, number / 10);
        json!({
            "kind": "disc", "radius_m": 0.01,
            "x_m": 0.2 + 0.05 * f64::from(x), "y_m": 0.2 + 0.05 * f64::from(y)
        })
    });
    let arena = json!({
        "name": "discs", "width_m": 1, "height_m": 1, "walls_m": [],
        "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0 }],
        "objects": discs.collect::<Vec<_>>()
    });
    let job = |combinations: u32| {
        let epochs: Vec<u32> = (1..=combinations).collect();
        let controller = json!({ "method": "brownian" });
        let base = json!({ "arena": arena, "engine": "rapier", "controller": controller });
        json!({ "base": base, "matrix": { "epochs": epochs } })
    };
    assert_eq!(expand(&job(10), &BuiltinArenas).unwrap().runs.len(), 10);
    let errors = expand(&job(2_600), &BuiltinArenas).unwrap_err();
    assert!(errors[0].message.contains("write out"), "{errors:?}");
}

/// Each name of a path made an object in the one before: thousands of them overflowed the stack.
#[test]
fn a_path_of_many_names_is_refused() {
    for names in [17, 2_000] {
        let path = vec!["a"; names].join(".");
        for path in [
            path.clone(),
            format!("arena.{path}"),
            format!("epochs+{path}"),
        ] {
            let job = json!({ "matrix": { path: [1] } });
            let errors = expand(&job, &BuiltinArenas).unwrap_err();
            assert_eq!(errors[0].message, "is no dotted path", "{errors:?}");
        }
    }
}

#[test]
fn walls_that_the_parts_of_a_job_write_out_are_bounded_together() {
    let job = |parts: u32| {
        let part = |number: u32| {
            let epochs: Vec<u32> = (1..=10).map(|epochs| number * 10 + epochs).collect();
            json!({ "name": format!("part {number}"), "matrix": { "epochs": epochs } })
        };
        let arena = json!({
            "name": "long", "width_m": 1_000.0, "height_m": 0.5,
            "generate": { "kind": "rooms", "seed": 0 }
        });
        json!({
            "base": { "arena": arena, "controller": { "method": "brownian" } },
            "parts": (0..parts).map(part).collect::<Vec<_>>()
        })
    };
    assert_eq!(expand(&job(2), &BuiltinArenas).unwrap().runs.len(), 20);
    let errors = expand(&job(3), &BuiltinArenas).unwrap_err();
    assert!(
        errors[0].message.contains("write out too many walls"),
        "{errors:?}"
    );
    assert_eq!(errors[0].pointer, "/base/arena");
}
