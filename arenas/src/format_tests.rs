//! Every error of the format, what each points at, and that no text at all makes it panic.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;

fn good() -> Value {
    json!({
        "name": "two-rooms", "width_m": 0.6, "height_m": 0.6,
        "walls_m": [[0.3, 0.0, 0.3, 0.4]],
        "starts": [{"x_m": 0.1, "y_m": 0.1, "heading_rad": 0.0}]
    })
}

fn errors(arena: &Value) -> Vec<ArenaError> {
    Arena::from_json(&arena.to_string())
        .err()
        .unwrap_or_default()
}

fn pointers(arena: &Value) -> Vec<String> {
    errors(arena)
        .into_iter()
        .map(|error| error.pointer)
        .collect()
}

/// The good arena with one field changed (`null`: left out) is wrong at `pointers` exactly.
#[track_caller]
fn check(field: &str, value: Value, expected: &[&str]) {
    let mut arena = good();
    arena[field] = value;
    if arena[field].is_null() {
        arena.as_object_mut().unwrap().remove(field);
    }
    assert_eq!(pointers(&arena), expected, "{:?}", errors(&arena));
}

#[test]
fn good_arena_and_what_it_may_leave_out() {
    let arena = Arena::from_json(&good().to_string()).unwrap();
    assert_eq!(
        (arena.name(), arena.squares(), arena.starts().len()),
        ("two-rooms", [100, 100], 1)
    );
    assert_eq!(arena.to_format().build().unwrap(), arena);
    check("squares", json!(1), &[]);
    check("walls_m", json!([]), &[]);
    check("walls_m", json!([[-1e-10, 0.0, 0.6000000001, 0.6]]), &[]);
}

#[test]
fn names() {
    for name in ["", "A", "a b", "é", "-a", "..", &"a".repeat(65)] {
        check("name", json!(name), &["/name"]);
    }
    for name in ["a", "0.-_", &"a".repeat(64)] {
        check("name", json!(name), &[]);
    }
    check("name", Value::Null, &["/name"]);
}

#[test]
fn sizes_and_squares() {
    for side_m in [-1.0, 0.0, 0.09, 1000.1, 1e300] {
        check("width_m", json!(side_m), &["/width_m"]);
        check("height_m", json!(side_m), &["/height_m"]);
    }
    check("width_m", Value::Null, &["/width_m"]);
    check("squares", json!(0), &["/squares"]);
    check("squares", json!(1001), &["/squares"]);
    check("squares", json!(-1), &["/squares"]);
    check("squares", json!(1.5), &["/squares"]);
    check("squares", json!([200, 100]), &[]);
    check("squares", json!([200, 1001]), &["/squares"]);
    check("squares", json!([1, 2, 3]), &["/squares"]);
}

#[test]
fn walls() {
    check(
        "walls_m",
        json!([[0, 0, 0.1, 0], [0.2, 0.2, 0.2, 0.2], [0, 0, 0.61, 0]]),
        &["/walls_m/1", "/walls_m/2"],
    );
    check("walls_m", json!([[0, -1e-8, 0.1, 0]]), &["/walls_m/0"]);
    check("walls_m", json!([[0, 0, 1e-7, 0]]), &["/walls_m/0"]);
    check("walls_m", json!([[0, 0, 0.1]]), &["/walls_m/0"]);
    check("walls_m", json!([[0, 0, 0.1, "x"]]), &["/walls_m/0/3"]);
    check("walls_m", Value::Null, &["/walls_m"]);
    check(
        "walls_m",
        json!(vec![[0.0, 0.0, 0.1, 0.0]; validate::MAX_WALLS]),
        &[],
    );
    check(
        "walls_m",
        json!(vec![[0.0, 0.0, 0.1, 0.0]; validate::MAX_WALLS + 1]),
        &["/walls_m"],
    );
}

#[test]
fn starts() {
    let pose = |x_m: f64, y_m: f64| json!({"x_m": x_m, "y_m": y_m, "heading_rad": 0.0});
    check("starts", json!([]), &["/starts"]);
    check("starts", Value::Null, &["/starts"]);
    check(
        "starts",
        json!([pose(0.1, 0.1), pose(0.7, 0.1), pose(0.1, -0.1)]),
        &["/starts/1", "/starts/2"],
    );
    check("starts", json!([{"x_m": 0.1, "y_m": 0.1}]), &["/starts/0"]);
    check(
        "starts",
        json!([{"x_m": 0.1, "y_m": 0.1, "heading_rad": 0, "z_m": 0}]),
        &["/starts/0/z_m"],
    );
}

#[test]
fn values_that_json_cannot_write_are_caught_too() {
    let pose = Pose {
        x_m: f64::NAN,
        y_m: 0.1,
        heading_rad: f64::INFINITY,
    };
    let format = ArenaFormat {
        name: Some("a".to_owned()),
        width_m: Some(f64::NAN),
        height_m: Some(1.0),
        walls_m: Some(vec![[0.0, f64::NAN, 1.0, 1.0]]),
        starts: Some(vec![pose]),
        ..ArenaFormat::default()
    };
    let pointers: Vec<String> = format
        .build()
        .unwrap_err()
        .into_iter()
        .map(|error| error.pointer)
        .collect();
    assert_eq!(
        pointers,
        [
            "/width_m",
            "/walls_m/0",
            "/starts/0/x_m",
            "/starts/0/heading_rad"
        ]
    );
}

#[test]
fn all_wrong_fields_at_once() {
    let arena = json!({"width_m": -1, "squares": 0, "walls_m": [[0, 0, 0, 0]], "generate": {"kind": "maze"}});
    assert_eq!(
        pointers(&arena),
        ["/width_m", "/height_m", "/squares", "/generate"]
    );
    assert_eq!(
        pointers(&json!({})),
        ["/name", "/width_m", "/height_m", "/walls_m", "/starts"]
    );
}

#[test]
fn what_is_no_arena_object() {
    check("colour", json!("red"), &["/colour"]);
    for text in [
        "",
        "[",
        "null",
        "3",
        "{} {}",
        "[1, 2]",
        "{\"name\": \"a\", \"name\": \"b\"}",
    ] {
        assert_eq!(Arena::from_json(text).unwrap_err().len(), 1, "{text}");
    }
    let error = &Arena::from_json("{").unwrap_err()[0];
    assert!(error.to_string().contains("EOF"), "{error}");
}

#[test]
fn generate_is_checked_like_the_rest() {
    let check = |generate: Value, expected: &[&str]| {
        let arena = json!({"width_m": 1.2, "height_m": 0.6, "generate": generate});
        assert_eq!(pointers(&arena), expected, "{:?}", errors(&arena));
    };
    check(json!({"kind": "maze"}), &[]);
    check(json!({}), &["/generate"]);
    check(json!({"kind": "labyrinth"}), &["/generate/kind"]);
    check(json!({"kind": "maze", "seed": -1}), &["/generate/seed"]);
    check(json!({"kind": "maze", "cels_m": 1}), &["/generate/cels_m"]);
    check(
        json!({"kind": "maze", "cell_m": "x"}),
        &["/generate/cell_m"],
    );
    check(
        json!({"kind": "maze", "cell_m": 0.001, "braid": 1.1, "gap_m": 1, "shape": "box"}),
        &[
            "/generate/cell_m",
            "/generate/braid",
            "/generate/gap_m",
            "/generate/shape",
        ],
    );
    check(
        json!({"kind": "maze", "cell_m": 0.7}),
        &["/generate/cell_m"],
    );
    check(
        json!({"kind": "rooms", "room_m": 0.2, "gate_m": 0.2}),
        &["/generate/gate_m"],
    );
    check(
        json!({"kind": "corridors", "cell_m": 0.2, "corridor_m": 0.3}),
        &["/generate/corridor_m"],
    );
    check(
        json!({"kind": "random-obstacles", "density_per_m2": 1000}),
        &["/generate/density_per_m2"],
    );
    check(
        json!({"kind": "random-obstacles", "clear_m": 0.4}),
        &["/generate/clear_m"],
    );
}

#[test]
fn starts_too_near_to_walls() {
    let mut arena = good();
    arena["starts"] = json!([
        {"x_m": 0.1, "y_m": 0.1, "heading_rad": 0}, {"x_m": 0.28, "y_m": 0.1, "heading_rad": 0},
        {"x_m": 0.3, "y_m": 0.436, "heading_rad": 0}, {"x_m": 0.037, "y_m": 0.037, "heading_rad": 0},
        {"x_m": 0.1, "y_m": 0.59, "heading_rad": 0}
    ]);
    let errors = Arena::from_json(&arena.to_string())
        .unwrap()
        .check_starts(0.037);
    let pointers: Vec<&str> = errors.iter().map(|error| error.pointer.as_str()).collect();
    assert_eq!(pointers, ["/starts/1", "/starts/2", "/starts/4"]);
    assert!(
        errors[0].message.contains("0.020000 m from wall 0"),
        "{}",
        errors[0]
    );
    assert!(errors[2].message.contains("boundary"), "{}", errors[2]);
}

/// Walls and starts at random places: the subdivided search finds what a plain search finds.
#[test]
fn many_starts_and_walls() {
    let mut state = 1u64;
    let mut unit = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let format = ArenaFormat {
        name: Some("many".to_owned()),
        width_m: Some(19.0),
        height_m: Some(19.0),
        walls_m: Some(
            (0..2000)
                .map(|_| {
                    let [x, y] = [18.8 * unit(), 18.8 * unit()];
                    [x, y, x + 0.2 * unit(), y + 0.2 * unit()]
                })
                .collect(),
        ),
        starts: Some(
            (0..10_000)
                .map(|_| Pose {
                    x_m: 19.0 * unit(),
                    y_m: 19.0 * unit(),
                    heading_rad: 0.0,
                })
                .collect(),
        ),
        ..ArenaFormat::default()
    };
    let arena = format.build().unwrap();
    let began = std::time::Instant::now();
    let found: Vec<String> = arena
        .check_starts(0.037)
        .into_iter()
        .map(|error| error.pointer)
        .collect();
    let took = began.elapsed();
    let expected: Vec<String> = arena
        .starts()
        .iter()
        .enumerate()
        .filter(|(_, start)| {
            let clearance_m2 = arena
                .walls()
                .iter()
                .chain(&arena.boundary())
                .map(|wall| wall.distance_squared_m2(start.position()))
                .fold(f64::INFINITY, f64::min);
            clearance_m2.sqrt() < 0.037 - 1e-9
        })
        .map(|(index, _)| format!("/starts/{index}"))
        .collect();
    assert!(expected.len() > 100);
    assert_eq!(found, expected);
    // Well above what it takes, for slow and busy machines.
    assert!(took.as_millis() < 500, "{took:?}");
}

/// A world of ten robots like those that other simulators are compared on.
#[test]
fn worlds_of_the_comparison_load() {
    let arena = Arena::from_json(include_str!("../data/tests/ten-robots.json")).unwrap();
    assert_eq!((arena.walls().len(), arena.starts().len()), (2, 10));
    assert_eq!(arena.check_starts(0.037), []);
}

/// Values that are nearly arenas: known and unknown fields with values of any kind.
fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        (-2i64..1200).prop_map(Value::from),
        (0.0..1.0).prop_map(Value::from),
        prop_oneof![
            Just("maze"),
            Just("rooms"),
            Just("corridors"),
            Just("random-obstacles"),
            Just("box"),
            Just("-")
        ]
        .prop_map(Value::from),
    ];
    let key = proptest::sample::select(vec![
        "name",
        "width_m",
        "height_m",
        "squares",
        "walls_m",
        "starts",
        "x_m",
        "y_m",
        "heading_rad",
        "generate",
        "kind",
        "seed",
        "cell_m",
        "braid",
        "gap_m",
        "shape",
        "colour",
    ]);
    leaf.prop_recursive(3, 24, 8, move |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..5).prop_map(Value::from),
            prop::collection::btree_map(key.clone().prop_map(str::to_owned), inner, 0..8)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

proptest! {
    #[test]
    fn no_text_panics(text in ".{0,80}") {
        drop(Arena::from_json(&text));
    }

    #[test]
    fn no_value_panics(value in any_json(), field in "width_m|height_m|squares|walls_m|starts|generate|name") {
        drop(Arena::from_json(&value.to_string()));
        let mut arena = good();
        arena[field] = value;
        drop(Arena::from_json(&arena.to_string()));
    }

    #[test]
    fn numbers_give_an_arena_or_errors(
        numbers in prop::array::uniform6(any::<f64>()),
        wall in prop::array::uniform4(-0.1..1.1f64),
        squares in any::<u32>(),
        radius_m in any::<f64>(),
    ) {
        let [width_m, height_m, x_m, y_m, heading_rad, x2_m] = numbers;
        for (size_m, walls_m, pose) in [
            ([width_m, height_m], vec![[x_m, y_m, x2_m, heading_rad]], [x_m, y_m, heading_rad]),
            ([1.0, 1.0], vec![wall], [wall[0].abs().min(1.0), 0.5, heading_rad]),
        ] {
            let format = ArenaFormat {
                name: Some("a".to_owned()),
                width_m: Some(size_m[0]),
                height_m: Some(size_m[1]),
                squares: Some(crate::SquaresFormat::Sides([1 + squares % 200, 1 + squares / 7 % 200])),
                walls_m: Some(walls_m),
                starts: Some(vec![Pose { x_m: pose[0], y_m: pose[1], heading_rad: pose[2] }]),
                ..ArenaFormat::default()
            };
            match format.build() {
                Ok(arena) => {
                    prop_assert_eq!(&arena.to_format().build().unwrap(), &arena);
                    let written = serde_json::to_string(&arena.to_format()).unwrap();
                    prop_assert_eq!(&Arena::from_json(&written).unwrap(), &arena);
                    let _ = arena.check_starts(radius_m);
                    let _ = crate::render_svg(&arena, &crate::SvgOptions { size_px: squares, body_radius_m: radius_m });
                    let _ = crate::reachable(&arena, arena.starts()[0], radius_m.clamp(0.01, 2.0));
                }
                Err(errors) => prop_assert!(!errors.is_empty()),
            }
        }
    }
}
