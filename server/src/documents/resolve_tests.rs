//! Specs as a user would write them: what they become, and what is said of wrong ones.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use proptest::prelude::*;
use serde_json::{Value, json};
use swarm::spec::{ControllerParameters, ControllerPreset, Method};

use super::testing::{any_json, refused, resolved, two_rooms};
use super::*;

fn check(spec: Value, pointer: &str, words: &str) {
    refused(resolve(&spec, &BuiltinArenas).map(drop), pointer, words);
}

#[test]
fn an_empty_spec_is_the_default_experiment() {
    let run = resolved(json!({})).run_spec();
    assert_eq!(
        (run.seed, run.epochs, run.steps_per_epoch, run.robots),
        (1, 2_000, 2_000, 1)
    );
    assert_eq!(run.arena.name(), "maze");
    assert_eq!(run.controller.method, Method::EvIterC);
    let training = run.controller.training.as_ref().unwrap();
    assert_eq!((training.arena.name(), training.epochs), ("easy", 200));
    assert_eq!(run.robot, swarm::robot::RobotModel::default());
}

#[test]
fn resolving_what_was_resolved_changes_nothing() {
    let specs = [
        json!({}),
        json!({ "seed": MAX_SEED, "arena": two_rooms(), "channels": true }),
        json!({ "controller": { "method": "im", "alpha": 0.1, "eta": 1e-3, "lambda": 7.0 } }),
        json!({ "controller": { "method": "im", "states_from": "phase-1" } }),
        json!({ "arena": "easy", "start": { "heading_rad": 0.5 }, "episodes": "continue-exploring" }),
        json!({ "arena": "easy", "start": { "x_m": 0.07, "y_m": 0.08, "heading_rad": 1 } }),
        json!({ "controller": { "method": "discovery", "train": { "arena": two_rooms() } } }),
        json!({ "controller": { "method": "brownian" }, "robot": { "preset": "epuck2", "mass_kg": 0.2 } }),
        json!({ "arena": { "name": "made", "width_m": 1.2, "height_m": 1.2,
                "generate": { "kind": "maze", "seed": 3 } } }),
    ];
    for spec in specs {
        let first = resolved(spec);
        let text = first.canonical_json();
        let again = resolved(parse(&text).unwrap());
        assert_eq!(again.canonical_json(), text);
        assert_eq!(again.key(), first.key());
        assert_eq!(again.arena().content_key(), first.arena().content_key());
        let typed: api::RunSpec = serde_json::from_str(&text).unwrap();
        assert_eq!(typed, first.canonical());
    }
}

#[test]
fn every_field_of_the_contract_is_shown_in_its_order() {
    let text = resolved(json!({ "epochs": 3 })).canonical_json();
    let mut rest = text.as_str();
    let shown = resolve::FIELDS.into_iter();
    for field in shown.filter(|field| *field != domains::SCHEMA_LINK) {
        let (_, after) = rest
            .split_once(&format!("\n  \"{field}\": "))
            .unwrap_or_else(|| panic!("no {field}"));
        rest = after;
    }
    for parameter in swarm::spec::ControllerParameters::TABLE {
        assert!(
            text.contains(&format!("\n    \"{}\": ", parameter.name)),
            "{}",
            parameter.name
        );
    }
    assert!(text.ends_with("}\n"));
}

#[test]
fn a_start_is_the_first_of_the_arena_and_of_the_training_arena() {
    let run = resolved(json!({ "arena": "graph", "start": { "heading_rad": 1.25 } })).run_spec();
    let training = &run.controller.training.as_ref().unwrap().arena;
    for (arena, name) in [(&run.arena, "graph"), (training, "easy")] {
        let (start, own) = (
            arena.starts()[0],
            arenas::builtin(name).unwrap().starts()[0],
        );
        assert_eq!((start.x_m, start.y_m), (own.x_m, own.y_m));
        assert_eq!(start.heading_rad, 1.25);
    }
    assert_eq!(
        resolved(json!({ "start": null })).key(),
        resolved(json!({})).key()
    );
}

#[test]
fn a_preset_stands_where_nothing_is_said() {
    let with = |controller: Value| resolved(json!({ "controller": controller }));
    let stepwise = with(json!({ "preset": "stepwise" })).run_spec();
    let p = &stepwise.controller.parameters;
    assert_eq!(*p, ControllerParameters::preset(ControllerPreset::Stepwise));
    let mixed = with(json!({ "preset": "stepwise", "alpha": 0.1 })).run_spec();
    assert_eq!(mixed.controller.parameters.alpha, 0.1);
    assert_eq!(mixed.controller.parameters.slope, p.slope);
    // A preset is short for its values: the same run has the same id.
    let listed = controllers().controller_presets;
    let values = listed
        .iter()
        .find(|preset| preset.name == "stepwise")
        .unwrap();
    let spelt = with(serde_json::to_value(&values.parameters).unwrap());
    assert_eq!(spelt.key(), with(json!({ "preset": "stepwise" })).key());
    assert_ne!(spelt.key(), with(json!({})).key());
    for name in ["default", "printed"] {
        assert_eq!(with(json!({ "preset": name })).key(), with(json!({})).key());
    }
    check(
        json!({ "controller": { "preset": "printd" } }),
        "/controller/preset",
        "did you mean \"printed\"?",
    );
}

/// The values that the thesis prints are kept by the preset that says so.
#[test]
fn the_printed_preset_keeps_what_is_printed() {
    let p = ControllerParameters::preset(ControllerPreset::Printed);
    assert_eq!(
        (
            p.epsilon_sensori_motor,
            p.epsilon_actuator,
            p.epsilon_sensor
        ),
        (1.8, 0.6, 1.0)
    );
    assert_eq!((p.lambda, p.lambda_total), (60, 500));
    assert_eq!((p.eta, p.alpha), (0.05, 0.7));
    assert_eq!((p.sigma, p.restart_after), (0.2, 30));
    assert_eq!(p.initial_weight_variance, 0.1);
}

#[test]
fn keys_tell_runs_apart() {
    let key = |spec: Value| resolved(spec).key();
    let default = key(json!({}));
    assert_eq!(default.len(), 64);
    assert_eq!(
        default,
        key(json!({ "seed": 1, "controller": { "alpha": 0.7 } }))
    );
    let mut moved = two_rooms();
    moved["walls_m"][0][3] = json!(0.41);
    let keys = [
        default,
        key(json!({ "seed": 2 })),
        key(json!({ "controller": { "alpha": 0.71 } })),
        key(json!({ "channels": true })),
        key(json!({ "arena": two_rooms() })),
        key(json!({ "arena": moved })),
        key(json!({ "start": { "heading_rad": 0.5 } })),
    ];
    let distinct: std::collections::BTreeSet<_> = keys.iter().collect();
    assert_eq!(distinct.len(), keys.len());
}

#[test]
fn an_uploaded_arena_of_the_same_name_but_other_walls_has_another_key() {
    struct Uploaded(std::sync::Arc<arenas::Arena>);
    impl ArenaSource for Uploaded {
        fn arena(&self, name: &str) -> Option<std::sync::Arc<arenas::Arena>> {
            (name == "mine")
                .then(|| self.0.clone())
                .or_else(|| BuiltinArenas.arena(name))
        }
        fn names(&self) -> Vec<String> {
            vec!["mine".to_owned()]
        }
    }
    let uploaded = |wall_end_m: f64| {
        let mut arena = two_rooms();
        arena["walls_m"][0][3] = json!(wall_end_m);
        Uploaded(std::sync::Arc::new(
            arenas::Arena::from_json(&arena.to_string()).unwrap(),
        ))
    };
    let key = |end_m| {
        resolve(&json!({ "arena": "mine" }), &uploaded(end_m))
            .unwrap()
            .key()
    };
    assert_eq!(key(0.4), key(0.4));
    assert_ne!(key(0.4), key(0.5));
}

#[test]
fn wrong_specs_are_refused_where_they_are_wrong() {
    check(json!([]), "", "must be an object, not an array");
    check(json!({ "sed": 1 }), "/sed", "did you mean \"seed\"?");
    check(json!({ "schema": 2 }), "/schema", "2 is not");
    check(json!({ "seed": -1 }), "/seed", "from 0 to 9007199254740991");
    check(json!({ "seed": 1.5 }), "/seed", "1.5 is not a whole number");
    check(
        json!({ "seed": 1u64 << 53 }),
        "/seed",
        "9007199254740992 is not",
    );
    check(json!({ "seed": "7" }), "/seed", "not a string");
    check(json!({ "epochs": 0 }), "/epochs", "from 1 to 1000000");
    check(json!({ "epochs": 1_000_001 }), "/epochs", "1000001 is not");
    check(
        json!({ "steps_per_epoch": 1e300 }),
        "/steps_per_epoch",
        "is not a whole number",
    );
    check(json!({ "robots": 100_001 }), "/robots", "from 1 to 100000");
    check(json!({ "robots": null }), "/robots", "not null");
    check(
        json!({ "placement": "gird" }),
        "/placement",
        "did you mean \"grid\"?",
    );
    check(
        json!({ "episodes": 3 }),
        "/episodes",
        "must be a string, not a number",
    );
    check(
        json!({ "start": { "heading_rad": "north" } }),
        "/start/heading_rad",
        "not a string",
    );
    check(
        json!({ "start": { "heading_rad": 1e9 } }),
        "/start/heading_rad",
        "out of range",
    );
    check(
        json!({ "arena": "easy", "start": { "x_m": 2 } }),
        "/start",
        "outside the arena easy",
    );
    check(
        json!({ "arena": "easy", "start": { "x_m": 0.01 } }),
        "/arena/starts/0",
        "from the boundary",
    );
    check(
        json!({ "start": { "y": 0.1 } }),
        "/start/y",
        "there is no field",
    );
    check(
        json!({ "engine": "bullet" }),
        "/engine",
        "kinematic, rapier",
    );
    check(json!({ "channels": "yes" }), "/channels", "true or false");
    check(
        json!({ "memory_budget_bytes": "e-puk" }),
        "/memory_budget_bytes",
        "did you mean \"e-puck\"?",
    );
    check(
        json!({ "memory_budget_bytes": 100 }),
        "/memory_budget_bytes",
        "at least ",
    );
    check(
        json!({ "memory_budget_bytes": true }),
        "/memory_budget_bytes",
        "not a truth value",
    );
    check(
        json!({ "sharing": { "mode": "radio", "range_m": -1 } }),
        "/sharing/range_m",
        "from 0 to 100",
    );
    check(
        json!({ "sharing": { "mode": "radio", "bytes_per_step": 5 } }),
        "/sharing/bytes_per_step",
        "from 6 to 4096",
    );
    check(
        json!({ "sharing": { "mode": "arena", "range_m": 1 } }),
        "/sharing/range_m",
        "has no radio",
    );
    check(
        json!({ "sharing": { "mode": "radio" }, "controller": { "method": "brownian" } }),
        "/sharing/mode",
        "learns nothing",
    );
    check(
        json!({ "sharing": { "mode": "non" } }),
        "/sharing/mode",
        "did you mean \"none\"?",
    );
    check(
        json!({ "record": { "every_steps": 10, "robots": 2 } }),
        "/record/robots",
        "2 is not from 1 to 1",
    );
    check(
        json!({ "robots": 3, "record": { "every_steps": 10, "robots": [0, 2, 0] } }),
        "/record/robots",
        "robot 0 is listed twice",
    );
    check(
        json!({ "record": { "every_steps": 1, "robots": [] } }),
        "/record/robots",
        "no robot is listed",
    );
    check(
        json!({ "record": { "every_steps": 1, "fields": [] } }),
        "/record/fields",
        "the list is empty",
    );
    check(
        json!({ "record": { "fields": ["pose"] } }),
        "/record/fields",
        "nothing is recorded",
    );
    check(
        json!({ "record": { "every_steps": 1 }, "epochs": 1_000_000 }),
        "/record",
        "the recording would take about",
    );
    check(
        json!({ "record": { "every_step": 10 } }),
        "/record/every_step",
        "\"every_steps\"?",
    );
    check(
        json!({ "robot": { "preset": "epuck3" } }),
        "/robot/preset",
        "\"epuck2\"?",
    );
    check(
        json!({ "robot": { "mas_kg": 1 } }),
        "/robot/mas_kg",
        "\"mass_kg\"?",
    );
    check(
        json!({ "robot": { "mass_kg": -1 } }),
        "/robot/mass_kg",
        "a number from 0.001 to 100",
    );
    check(json!({ "robot": 1 }), "/robot", "must be an object");
}

#[test]
fn wrong_controllers_are_refused_where_they_are_wrong() {
    let check = |controller: Value, pointer: &str, words: &str| {
        check(
            json!({ "controller": controller }),
            &format!("/controller{pointer}"),
            words,
        );
    };
    check(json!("im"), "", "must be an object, not a string");
    check(
        json!({ "method": "ev-iter" }),
        "/method",
        "did you mean \"ev-iter-c\"?",
    );
    check(json!({ "alhpa": 0.5 }), "/alhpa", "did you mean \"alpha\"?");
    check(json!({ "alpha": 1.5 }), "/alpha", "a number from 0 to 1");
    check(json!({ "alpha": "high" }), "/alpha", "a number from 0 to 1");
    check(json!({ "alpha": [0.5] }), "/alpha", "not an array");
    check(json!({ "lambda": 2.5 }), "/lambda", "a whole number");
    check(
        json!({ "insufficiency": "never" }),
        "/insufficiency",
        "every-action, state-total",
    );
    check(
        json!({ "train": { "epoch": 3 } }),
        "/train/epoch",
        "did you mean \"epochs\"?",
    );
    check(
        json!({ "train": { "epochs": 0 } }),
        "/train/epochs",
        "from 1 to",
    );
    check(
        json!({ "train": { "arena": "esay" } }),
        "/train/arena",
        "did you mean \"easy\"?",
    );
    check(
        json!({ "method": "brownian", "train": {} }),
        "/train",
        "brownian has no training",
    );
    check(
        json!({ "method": "im", "train": {} }),
        "/train",
        "states_from \"phase-1\"",
    );
}

#[test]
fn wrong_arenas_are_refused_where_they_are_wrong() {
    check(
        json!({ "arena": "mase" }),
        "/arena",
        "did you mean \"maze\"?",
    );
    check(
        json!({ "arena": 3 }),
        "/arena",
        "must be a name or an arena object",
    );
    check(json!({ "arena": {} }), "/arena/width_m", "missing");
    let wrong = |change: fn(&mut Value), pointer: &str, words: &str| {
        let mut arena = two_rooms();
        change(&mut arena);
        check(json!({ "arena": arena }), pointer, words);
    };
    wrong(
        |a| a["width"] = json!(1),
        "/arena/width",
        "did you mean \"width_m\"?",
    );
    wrong(|a| a["width_m"] = json!("1"), "/arena/width_m", "string");
    wrong(|a| a["width_m"] = json!(-1), "/arena/width_m", "-1");
    wrong(
        |a| a["walls_m"][0] = json!([1, 2, 3]),
        "/arena/walls_m/0",
        "length",
    );
    wrong(
        |a| a["starts"][0]["z_m"] = json!(0),
        "/arena/starts/0/z_m",
        "no field \"z_m\"",
    );
}

#[test]
fn all_wrong_fields_are_told_at_once() {
    let spec = json!({
        "sed": 1, "epochs": 0, "arena": "nowhere", "robot": { "mass_kg": "heavy" },
        "controller": { "alpha": 2, "lambda": 0, "train": { "arena": "nowhere" } }
    });
    let errors = resolve(&spec, &BuiltinArenas).unwrap_err();
    let pointers: Vec<_> = errors.iter().map(|error| error.pointer.as_str()).collect();
    for pointer in [
        "/sed",
        "/epochs",
        "/arena",
        "/robot/mass_kg",
        "/controller/alpha",
        "/controller/lambda",
        "/controller/train/arena",
    ] {
        assert!(
            pointers.contains(&pointer),
            "{pointer} is not in {pointers:?}"
        );
    }
}

#[test]
fn text_that_is_no_json_says_where_it_stops() {
    let errors = parse("{\"seed\": 1,}").unwrap_err();
    assert_eq!(errors[0].pointer, "");
    assert!(
        errors[0].message.contains("line 1 column 12"),
        "{}",
        errors[0].message
    );
}

proptest! {
    #[test]
    fn no_json_makes_resolving_panic(value in any_json()) {
        match resolve(&value, &BuiltinArenas) {
            Ok(run) => {
                let again = resolved(parse(&run.canonical_json()).unwrap());
                prop_assert_eq!(again.key(), run.key());
            }
            Err(errors) => prop_assert!(!errors.is_empty()),
        }
    }
}

#[test]
fn arenas_are_made_of_copies_of_others() {
    let run = resolved(json!({
        "arena": { "from": "easy", "tile": [3, 2] }, "robots": 6, "controller": { "method": "brownian" }
    }));
    assert_eq!(run.arena().name(), "easy-3x2");
    assert_eq!(run.arena().squares(), [300, 200]);
    let again = resolved(serde_json::from_str(&run.canonical_json()).unwrap());
    assert_eq!(
        (again.key(), again.canonical_json()),
        (run.key(), run.canonical_json())
    );
    let nested = resolved(json!({
        "arena": { "from": { "from": two_rooms(), "scale": 2 }, "tile": [2, 1], "squares": 50, "doorway_m": 0.3 }
    }));
    assert_eq!(nested.arena().squares(), [100, 50]);
    assert!((nested.arena().width_m() - 2.4).abs() < 1e-9);

    let check = |arena: Value, pointer: &str, words: &str| {
        let spec = json!({ "arena": arena });
        refused(resolve(&spec, &BuiltinArenas).map(drop), pointer, words);
    };
    check(json!({ "from": "esay" }), "/arena/from", "\"easy\"?");
    check(
        json!({ "from": "easy", "tiles": [1, 1] }),
        "/arena/tiles",
        "\"tile\"?",
    );
    check(
        json!({ "from": "easy", "tile": 3 }),
        "/arena/tile",
        "3 is not",
    );
    check(
        json!({ "from": "easy", "tile": [1, -1] }),
        "/arena/tile",
        "columns, rows",
    );
    check(
        json!({ "from": "easy", "tile": [11, 1] }),
        "/arena/tile/0",
        "1 to 10 columns",
    );
    check(
        json!({ "from": "easy", "scale": 0 }),
        "/arena/scale",
        "out of range",
    );
    check(
        json!({ "from": "easy", "doorway_m": 9 }),
        "/arena/doorway_m",
        "shorter side",
    );
    check(
        json!({ "from": { "from": 3 } }),
        "/arena/from/from",
        "a name or an arena object",
    );
    let mut deep = json!("easy");
    for _ in 0..9 {
        deep = json!({ "from": deep });
    }
    check(deep, "/arena/from/from/from/from/from", "at most 4");
}

#[test]
fn objects_are_read_shown_and_checked() {
    let mut arena = two_rooms();
    arena["objects"] = json!([{ "kind": "disc", "x_m": 0.4, "y_m": 0.4, "radius_m": 0.03 }]);
    let spec = json!({ "arena": arena, "engine": "rapier", "controller": { "method": "im" } });
    let run = resolved(spec.clone());
    assert_eq!(run.arena().objects().len(), 1);
    let again: Value = serde_json::from_str(&run.canonical_json()).unwrap();
    assert_eq!(again["arena"]["objects"][0]["mass_kg"], json!(0.05));
    assert_eq!(resolved(again).key(), run.key());
    let mut wrong = spec;
    wrong["arena"]["objects"][0]["radius_m"] = json!(5);
    refused(
        resolve(&wrong, &BuiltinArenas).map(drop),
        "/arena/objects/0/radius_m",
        "out of range",
    );
}

#[test]
fn a_method_s_own_parameters_are_its_alone() {
    let common = resolved(json!({ "controller": { "method": "brownian" } }));
    let common = common.canonical().controller.unwrap().parameters.len();
    for &method in Method::ALL {
        let shown = resolved(json!({ "controller": { "method": method.name() } }));
        let shown = shown.canonical().controller.unwrap().parameters;
        let own = (method.definition().parameters)();
        assert_eq!(shown.len(), common + own.table().len(), "{method:?}");
        for parameter in own.table() {
            let name = parameter.name;
            let with = |method: Method| json!({ "controller": { "method": method.name(), name: shown[name].clone() } });
            resolved(with(method));
            let pointer = format!("/controller/{name}");
            for &other in Method::ALL.iter().filter(|&&other| other != method) {
                let reason = format!("it is a parameter of {}", method.name());
                check(with(other), &pointer, &reason);
                // In a matrix too.
                let path = format!("controller.{name}");
                let job = json!({
                    "base": { "controller": { "method": other.name() } },
                    "matrix": { path.clone(): [shown[name].clone()] },
                });
                let place = format!("/matrix/{path}/0");
                refused(expand(&job, &BuiltinArenas).map(drop), &place, &reason);
            }
            let wrong = json!({ "controller": { "method": method.name(), name: [] } });
            check(wrong, &pointer, "must be");
        }
    }
}
