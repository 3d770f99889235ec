//! That the schemas take what the program takes, and refuse what they can tell is wrong.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};

use jsonschema::Validator;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;
use crate::documents::testing::{any_json, two_rooms, yard};
use crate::documents::{BuiltinArenas, expand, parse, read_arena, resolve};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn validator(document: &str) -> Validator {
    let schema: Value = serde_json::from_str(&text(document).unwrap()).unwrap();
    jsonschema::draft202012::new(&schema).unwrap()
}

fn assert_takes(validator: &Validator, document: &Value, name: &str) {
    let errors: Vec<String> = validator
        .iter_errors(document)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    assert!(errors.is_empty(), "{name}: {errors:#?}");
}

#[test]
fn the_schemas_are_those_that_are_checked_in() {
    for (document, ..) in DOCUMENTS {
        let path = root().join(format!("api/schemas/{document}.json"));
        let right = text(document).unwrap();
        if std::env::var_os("EVSWARM_REWRITE").is_some() {
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, right).unwrap();
            continue;
        }
        assert!(
            std::fs::read_to_string(&path).unwrap() == right,
            "api/schemas/{document}.json differs from the tables; rewrite it with \
             EVSWARM_REWRITE=1 cargo test --release -p server schemas"
        );
    }
}

#[test]
fn they_are_schemas_themselves() {
    for (document, ..) in DOCUMENTS {
        let schema: Value = serde_json::from_str(&text(document).unwrap()).unwrap();
        jsonschema::meta::validate(&schema).unwrap();
    }
}

#[test]
fn experiments_templates_and_arenas_are_as_the_schemas_say() {
    let (run, job, arena) = (validator("run"), validator("job"), validator("arena"));
    let mut jobs = 0;
    for entry in std::fs::read_dir(root().join("experiments")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|end| end != "json") {
            continue;
        }
        let document = parse(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let is_job = ["base", "parts", "template"]
            .iter()
            .any(|field| document.get(field).is_some());
        let (right, wrong) = if is_job { (&job, &run) } else { (&run, &job) };
        assert_takes(right, &document, &path.display().to_string());
        assert!(!wrong.is_valid(&document), "{}", path.display());
        jobs += usize::from(is_job);
    }
    assert!(jobs > 0);
    for template in crate::documents::templates() {
        assert_takes(&job, &template.job, &template.name);
        assert_takes(&job, &json!({ "template": template.name }), &template.name);
    }
    for name in arenas::builtin_names() {
        let format = arenas::builtin(name).unwrap().to_format();
        assert_takes(&arena, &serde_json::to_value(format).unwrap(), name);
    }
    let yard_run = json!({ "arena": yard(), "engine": "rapier" });
    assert_takes(&run, &yard_run, "yard");
}

/// Right documents of a run, which the changes of other tests begin with.
fn runs() -> Vec<Value> {
    vec![
        json!({}),
        json!({ "$schema": "schemas/run.json", "schema": 1, "seed": 7, "epochs": 3.0 }),
        json!({ "arena": two_rooms(), "robots": 1, "placement": "start" }),
        json!({ "arena": { "from": "easy", "tile": [2, 2], "doorway_m": null, "scale": 1.5 } }),
        json!({ "arena": { "width_m": 1.2, "height_m": 1.2, "squares": [50, 40],
            "generate": { "kind": "rooms", "seed": 3, "room_m": 0.3, "loops": null } } }),
        json!({ "arena": { "width_m": 1, "height_m": 1, "name": "x",
            "generate": { "kind": "random-obstacles", "shape": "box" } } }),
        json!({ "controller": { "method": "ev-iter-c", "alpha": 0.5,
            "train": { "arena": "easy", "epochs": 20 } } }),
        json!({ "controller": { "method": "im", "states_from": "phase-1", "train": {} } }),
        json!({ "controller": { "train": { "epochs": 3 } } }),
        json!({ "controller": { "method": "levy" }, "robot": { "preset": "epuck2", "step_s": 0.032 } }),
        json!({ "memory_budget_bytes": "e-puck2", "episodes": "continue", "channels": true,
            "record": { "every_steps": 0 } }),
        json!({ "sharing": { "mode": "radio", "range_m": null, "bytes_per_step": 64 },
            "robots": 4, "arena": "easy", "placement": { "kind": "random", "anywhere": true } }),
    ]
}

fn jobs() -> Vec<Value> {
    let base = json!({ "arena": "easy", "controller": { "method": "brownian" }, "epochs": 2 });
    vec![
        json!({ "name": "a", "base": base, "seeds": [3, 1] }),
        json!({ "$schema": "x", "base": base, "seeds": { "first": 0, "count": 2 },
            "matrix": { "epochs": [1, 2], "robot.step_s": [0.03], "arena": ["easy", "maze"] } }),
        json!({ "base": { "arena": { "from": "easy" }, "controller": { "method": "brownian" } },
            "matrix": { "robots+arena.tile": [[1, [1, 1]], [2, [2, 1]]] } }),
        json!({ "base": { "controller": { "alpha": 0.5 } },
            "matrix": { "controller.train.epochs": [3, 4], "arena.from": ["maze"] } }),
        json!({ "base": base, "parts": [{ "name": "x", "base": { "epochs": 5 } }, { "seeds": [9] }] }),
        json!({ "template": "chapter-5", "base": { "epochs": 200 }, "seeds": { "count": 3 } }),
    ]
}

#[test]
fn right_documents_are_taken_by_both() {
    let (run, job) = (validator("run"), validator("job"));
    for document in runs() {
        resolve(&document, &BuiltinArenas)
            .unwrap_or_else(|errors| panic!("{document}: {errors:?}"));
        assert_takes(&run, &document, &document.to_string());
    }
    for document in jobs() {
        expand(&document, &BuiltinArenas).unwrap_or_else(|errors| panic!("{document}: {errors:?}"));
        assert_takes(&job, &document, &document.to_string());
    }
}

#[test]
fn a_resolved_spec_is_as_the_schema_says() {
    let run = validator("run");
    for document in runs() {
        let resolved = resolve(&document, &BuiltinArenas).unwrap();
        let shown = parse(&resolved.canonical_json()).unwrap();
        assert_takes(&run, &shown, &document.to_string());
        assert!(shown.get("$schema").is_none());
    }
}

#[test]
fn wrong_documents_are_refused_by_both() {
    let (run, job, arena) = (validator("run"), validator("job"), validator("arena"));
    let of_a_run = [
        json!({ "robotz": 3 }),
        json!({ "$schema": 3 }),
        json!({ "schema": 2 }),
        json!({ "epochs": 0 }),
        json!({ "epochs": 1_000_001 }),
        json!({ "epochs": 1.5 }),
        json!({ "epochs": "3" }),
        json!({ "robots": null }),
        json!({ "seed": -1 }),
        json!({ "seed": 9_007_199_254_740_992_u64 }),
        json!({ "arena": 3 }),
        json!({ "arena": "No Name" }),
        json!({ "arena": { "from": "easy", "tile": 3 } }),
        json!({ "arena": { "from": "easy", "doorway_m": 0 } }),
        json!({ "arena": { "width_m": 1, "height_m": 1 } }),
        json!({ "arena": { "width_m": 1, "height_m": 1, "generate": { "kind": "maze", "gap_m": 1 } } }),
        json!({ "controller": { "method": "ev-iter" } }),
        json!({ "controller": { "alpha": 2 } }),
        json!({ "controller": { "slop": 2 } }),
        json!({ "controller": { "method": "brownian", "train": {} } }),
        json!({ "controller": { "method": "im", "train": {} } }),
        json!({ "controller": { "train": { "epochs": 0 } } }),
        json!({ "robot": { "preset": "khepera" } }),
        json!({ "robot": { "step_s": 7 } }),
        json!({ "robot": { "step_s": [7] } }),
        json!({ "placement": "anywhere" }),
        json!({ "placement": { "kind": "random", "anywhere": 1 } }),
        json!({ "episodes": "none" }),
        json!({ "engine": "box2d" }),
        json!({ "memory_budget_bytes": 0 }),
        json!({ "memory_budget_bytes": "khepera" }),
        json!({ "sharing": { "mode": "radio", "range_m": 101 } }),
        json!({ "sharing": { "range_m": 1 } }),
        json!({ "record": { "every_step": 1 } }),
        json!({ "channels": "yes" }),
        json!([]),
    ];
    for document in of_a_run {
        assert!(resolve(&document, &BuiltinArenas).is_err(), "{document}");
        assert!(!run.is_valid(&document), "{document}");
    }
    let of_a_job = [
        json!({ "bas": {} }),
        json!({ "base": { "robotz": 3 } }),
        json!({ "name": 3 }),
        json!({ "name": "x".repeat(201) }),
        json!({ "matrix": { "epohcs": [3] } }),
        json!({ "matrix": { "epochs": [] } }),
        json!({ "matrix": { "epochs": 3 } }),
        json!({ "matrix": { "epochs": [0] } }),
        json!({ "matrix": { "seed": [1, 2] } }),
        json!({ "matrix": { "controller.alpha": [2] } }),
        json!({ "matrix": { "robots+epochs": [1] } }),
        json!({ "seeds": [] }),
        json!({ "seeds": [1, 1] }),
        json!({ "seeds": { "count": 0 } }),
        json!({ "seeds": { "last": 3 } }),
        json!({ "template": "chapter-6" }),
        json!({ "parts": [] }),
        json!({ "parts": [{ "name": "" }] }),
        json!({ "parts": [{ "base": { "epochs": 0 } }] }),
        json!({ "parts": [{}], "matrix": {} }),
    ];
    for document in of_a_job {
        assert!(expand(&document, &BuiltinArenas).is_err(), "{document}");
        assert!(!job.is_valid(&document), "{document}");
    }
    let mut wrong = Vec::new();
    for (field, value) in [
        ("name", json!("_x")),
        ("name", json!("x".repeat(65))),
        ("name", json!("a b")),
        ("width_m", json!(0.01)),
        ("height_m", Value::Null),
        ("squares", json!(0)),
        ("squares", json!([10, 1001])),
        ("walls_m", json!([[0, 0, 1]])),
        ("walls_m", json!({})),
        ("starts", json!([])),
        ("starts", json!([{ "x_m": 0.1, "y_m": 0.1 }])),
        ("objects", json!([{ "kind": "ball" }])),
        ("colour", json!("red")),
    ] {
        let mut document = two_rooms();
        document[field] = value;
        wrong.push(document);
    }
    for field in ["name", "width_m", "height_m", "walls_m", "starts"] {
        let mut document = two_rooms();
        document.as_object_mut().unwrap().remove(field);
        wrong.push(document);
    }
    for document in wrong {
        assert!(read_arena(&document).is_err(), "{document}");
        assert!(!arena.is_valid(&document), "{document}");
    }
}

#[test]
fn every_field_says_what_it_is_for() {
    let all = definitions(OWN);
    for name in [
        "RunFields",
        "Controller",
        "Robot",
        "SharingSpec",
        "JobSpec",
        "Arena",
        "Pose",
    ] {
        for (field, schema) in all[name]["properties"].as_object().unwrap() {
            assert!(schema.get("description").is_some(), "{name}.{field}");
        }
    }
    let epochs = &all["RunFields"]["properties"]["epochs"];
    assert_eq!(
        (&epochs["minimum"], &epochs["maximum"], &epochs["default"]),
        (&json!(1), &json!(1_000_000), &json!(2_000))
    );
}

/// A document with a value somewhere in it put in place of another, or a field added.
fn changed(mut document: Value, place: usize, name: &str, value: Value) -> Value {
    fn count(value: &Value) -> usize {
        1 + match value {
            Value::Object(map) => map.values().map(count).sum(),
            Value::Array(list) => list.iter().map(count).sum(),
            _ => 0,
        }
    }
    fn put(at: &mut Value, place: &mut usize, name: &str, value: &Value) {
        if *place == 0 {
            match &mut *at {
                Value::Object(map) => drop(map.insert(name.to_owned(), value.clone())),
                other => *other = value.clone(),
            }
        }
        *place = place.wrapping_sub(1);
        match at {
            Value::Object(map) => map.values_mut().for_each(|at| put(at, place, name, value)),
            Value::Array(list) => list.iter_mut().for_each(|at| put(at, place, name, value)),
            _ => {}
        }
    }
    let mut place = place % count(&document);
    put(&mut document, &mut place, name, &value);
    document
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// An editor underlines nothing that the program takes.
    #[test]
    fn what_the_program_takes_the_schema_takes(
        which in any::<prop::sample::Index>(),
        place in any::<usize>(),
        name in prop::sample::select(vec![
            "epochs", "robots", "arena", "alpha", "train", "tile", "squares", "name", "scale",
            "walls_m", "generate", "seed", "mode", "range_m", "kind", "x", "schema", "$schema",
        ]),
        value in any_json(),
    ) {
        static VALIDATOR: std::sync::LazyLock<Validator> =
            std::sync::LazyLock::new(|| validator("run"));
        let document = changed(which.get(&runs()).clone(), place, name, value);
        if resolve(&document, &BuiltinArenas).is_ok() {
            prop_assert!(VALIDATOR.is_valid(&document), "{document}");
        }
    }
}
