//! Run specs that are wrong.

use serde_json::{Value, json};
use tests::command::evswarm;
use tests::refusals::row;
use tests::server::Server;
use tests::{job, small_spec};

use super::has;

/// Run specs that are wrong: the row of the table, the field to set (as a JSON pointer), its value,
/// the pointer that the error must have, and words of its message.
pub type Wrong = (
    &'static str,
    &'static str,
    Value,
    &'static str,
    &'static str,
);

pub fn wrong_specs() -> Vec<Wrong> {
    let unknown = "a field that does not exist (the nearest name is told)";
    let range = "a number out of range or a value of the wrong kind";
    let name = "an unknown arena, method, preset, engine or placement";
    let arena = "an arena with a wall outside it or a start inside a wall";
    let recording =
        "recording robots or fields that are not there, or more bytes than a recording may have";
    let budget = "a memory budget too small for any plan (the smallest that works is told)";
    let sharing = "sharing what a method does not have, or by a radio that cannot be";
    let tiles = "more tiles of an arena than fit, a wrong scale or doorway";
    let objects = "movable objects under the kinematic engine, also in a training arena";
    let room = |wall: Value, x_m: f64| {
        json!({
            "name": "room", "width_m": 0.6, "height_m": 0.6, "walls_m": [wall],
            "starts": [{ "x_m": x_m, "y_m": 0.3, "heading_rad": 0.0 }]
        })
    };
    vec![
        (
            unknown,
            "/epcohs",
            json!(1),
            "/epcohs",
            "did you mean \"epochs\"?",
        ),
        (
            unknown,
            "/controller/alhpa",
            json!(1),
            "/controller/alhpa",
            "\"alpha\"?",
        ),
        (
            unknown,
            "/robot/axel_m",
            json!(1),
            "/robot/axel_m",
            "\"axle_m\"?",
        ),
        (
            unknown,
            "/arena",
            json!({ "nmae": "x" }),
            "/arena/nmae",
            "\"name\"?",
        ),
        (range, "/epochs", json!(0), "/epochs", "0 is not"),
        (range, "/epochs", json!(-3), "/epochs", "-3 is not"),
        (range, "/epochs", json!(1e300), "/epochs", "is not"),
        (
            range,
            "/steps_per_epoch",
            json!(2.5),
            "/steps_per_epoch",
            "2.5 is not",
        ),
        (range, "/robots", json!(100_001), "/robots", "100001 is not"),
        (range, "/robots", json!("two"), "/robots", "not a string"),
        (
            range,
            "/seed",
            json!(9_007_199_254_740_993_u64),
            "/seed",
            "is not",
        ),
        (range, "/seed", json!(null), "/seed", "not null"),
        (range, "/schema", json!(2), "/schema", "2 is not"),
        (
            range,
            "/controller",
            json!([]),
            "/controller",
            "not an array",
        ),
        (
            range,
            "/controller/alpha",
            json!(1.5),
            "/controller/alpha",
            "",
        ),
        (
            range,
            "/controller/lambda",
            json!(true),
            "/controller/lambda",
            "truth value",
        ),
        (
            range,
            "/robot/body_radius_m",
            json!(-1),
            "/robot/body_radius_m",
            "",
        ),
        (
            range,
            "/channels",
            json!("yes"),
            "/channels",
            "not a string",
        ),
        (
            name,
            "/arena",
            json!("mase"),
            "/arena",
            "did you mean \"maze\"?",
        ),
        (
            name,
            "/arena",
            json!("../easy"),
            "/arena",
            "there is no arena",
        ),
        (
            name,
            "/controller/method",
            json!("browian"),
            "/controller/method",
            "\"brownian\"?",
        ),
        (
            name,
            "/robot/preset",
            json!("e-puck3"),
            "/robot/preset",
            "there is no preset",
        ),
        (
            name,
            "/engine",
            json!("box2d"),
            "/engine",
            "there is no engine",
        ),
        (
            name,
            "/placement",
            json!("circle"),
            "/placement",
            "there is no placement",
        ),
        (
            name,
            "/episodes",
            json!(""),
            "/episodes",
            "there is no episodes",
        ),
        (
            arena,
            "/arena",
            room(json!([0.1, 0.1, 0.7, 0.1]), 0.3),
            "/arena/walls_m/0",
            "leaves",
        ),
        (
            arena,
            "/arena",
            room(json!([0.1, 0.1, 0.1, 0.1]), 0.3),
            "/arena/walls_m/0",
            "0 m long",
        ),
        (
            arena,
            "/arena",
            room(json!([0.3, 0.0, 0.3, 0.6]), 0.31),
            "/arena/starts/0",
            "",
        ),
        (
            arena,
            "/arena",
            room(json!([0.3, 0.0, 0.3, 0.6]), 0.61),
            "/arena/starts/0",
            "outside",
        ),
        (
            arena,
            "/arena",
            room(json!([0.1, 0.1, 0.1]), 0.3),
            "/arena/walls_m/0",
            "",
        ),
        (
            "an arena written out under a built-in one's name, with other walls",
            "/arena",
            json!({
                "name": "easy", "width_m": 0.6, "height_m": 0.6, "walls_m": [],
                "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.0 }]
            }),
            "/arena/name",
            "built-in",
        ),
        (
            tiles,
            "/arena",
            json!({ "from": "easy", "tile": [11, 1] }),
            "/arena/tile/0",
            "11 columns",
        ),
        (
            tiles,
            "/arena",
            json!({ "from": "easy", "tile": [2, 1], "doorway_m": 2 }),
            "/arena/doorway_m",
            "out of range",
        ),
        (
            "more robots than the arena has start poses",
            "/robots",
            json!(5),
            "/robots",
            "1 start poses for 5 robots",
        ),
        (
            "more robots than fit under the placement `grid` or `random`",
            "",
            json!({
                "seed": 1, "arena": "easy", "controller": { "method": "brownian" },
                "epochs": 3, "robots": 5_000, "placement": "grid"
            }),
            "/robots",
            "5000 robots do not fit",
        ),
        (
            "more robots than fit under the placement `grid` or `random`",
            "",
            json!({
                "seed": 1, "arena": "easy", "controller": { "method": "brownian" },
                "epochs": 3, "robots": 5_000, "placement": "random"
            }),
            "/robots",
            "5000 robots do not fit",
        ),
        (
            "a robot that moves too far in a step for its size",
            "/robot/body_radius_m",
            json!(0.005),
            "/robot/max_wheel_speed_rad_s",
            "too far",
        ),
        (
            "training for a method that has none",
            "/controller/train",
            json!({ "epochs": 3 }),
            "/controller/train",
            "brownian has no training",
        ),
        (
            objects,
            "/arena",
            json!({
                "name": "boxes", "width_m": 0.6, "height_m": 0.6, "walls_m": [],
                "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.0 }],
                "objects": [{ "kind": "box", "x_m": 0.3, "y_m": 0.3, "width_m": 0.05, "height_m": 0.05 }]
            }),
            "/engine",
            "cannot move the 1 objects",
        ),
        (
            budget,
            "/memory_budget_bytes",
            json!(4),
            "/memory_budget_bytes",
            "too few",
        ),
        (
            sharing,
            "/sharing",
            json!({ "mode": "radio", "bytes_per_step": 1 }),
            "/sharing/bytes_per_step",
            "not a whole number",
        ),
        (
            recording,
            "/record",
            json!({ "every_steps": 5, "robots": [0, 7] }),
            "/record/robots/1",
            "not the number of a robot",
        ),
        (
            recording,
            "/record",
            json!({ "every_steps": 5, "fields": ["pose", "sensor"] }),
            "/record/fields/1",
            "\"sensors\"?",
        ),
    ]
}

/// Sets a field, whose parent is made if it is missing.
fn set(document: &mut Value, pointer: &str, value: Value) {
    let mut place = document;
    for name in pointer.split('/').skip(1) {
        place = &mut place[name];
    }
    *place = value;
}

#[test]
fn wrong_specs_are_refused_by_the_service_and_by_the_command() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    for (row, field, value, pointer, words) in wrong_specs() {
        let mut spec = small_spec();
        set(&mut spec, field, value);
        let told = format!("{row}: {spec}");

        let out = home.path().join("out");
        let done = evswarm(
            &["run", "-", "--out", out.to_str().unwrap()],
            &spec.to_string(),
        );
        assert_eq!(
            done.code,
            self::row(row).exit.map(i32::from),
            "{told}: {done:?}"
        );
        let line = format!("{pointer}: ");
        let found = done
            .stderr
            .lines()
            .any(|l| l.starts_with(&line) && l.contains(words));
        assert!(found, "{told}: {done:?}");
        assert!(
            !out.exists() && !home.path().join("out.partial").exists(),
            "{told}"
        );

        let seed = spec.as_object_mut().unwrap().remove("seed").unwrap();
        let posted = if field == "/seed" {
            json!({ "base": { "seed": seed } })
        } else {
            job(spec, 1)
        };
        let problem = server.post("/v1/jobs", &posted).refused(row);
        assert!(
            has(&problem.errors, &format!("/base{pointer}"), words),
            "{told}: {problem:?}"
        );
    }
    let jobs: Value = server.read("/v1/jobs");
    assert_eq!(jobs["items"], json!([]));
}

#[test]
fn all_wrong_fields_are_told_at_once() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let wrong = json!({
        "nmae": "x",
        "base": { "epochs": -1, "arena": "nowhere", "controller": { "alpha": 7 } },
        "matrix": { "robots": [1, 0] }, "seeds": { "first": 1, "count": 0 }
    });
    let problem = server.post("/v1/jobs", &wrong).problem(422);
    let first = ["/nmae", "/seeds/count"];
    assert!(
        first
            .iter()
            .all(|pointer| has(&problem.errors, pointer, "")),
        "{problem:?}"
    );
    let mut rest = wrong;
    rest["seeds"]["count"] = json!(1);
    let problem = server.post("/v1/jobs", &rest).problem(422);
    for pointer in [
        "/nmae",
        "/base/epochs",
        "/base/arena",
        "/base/controller/alpha",
        "/matrix/robots/1",
    ] {
        assert!(has(&problem.errors, pointer, ""), "{pointer}: {problem:?}");
    }
}
