//! Movable objects: geometry against sampled points, and what is refused.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use proptest::prelude::*;

use super::*;
use crate::arena::Arena;

fn a_box(x_m: f64, y_m: f64, heading_rad: f64) -> Movable {
    Movable::Box {
        x_m,
        y_m,
        heading_rad,
        width_m: 0.2,
        height_m: 0.1,
        mass_kg: 0.05,
        friction: 0.3,
    }
}

fn disc(x_m: f64, y_m: f64) -> Movable {
    Movable::Disc {
        x_m,
        y_m,
        radius_m: 0.05,
        mass_kg: 0.05,
        friction: 0.3,
    }
}

/// Points of an object on a fine grid.
fn sampled(object: &Movable) -> Vec<Point2<f64>> {
    let (n, reach_m) = (60, object.reach_m());
    let at = |i: i32| f64::from(i) * reach_m / f64::from(n);
    (-n..=n)
        .flat_map(|i| (-n..=n).map(move |j| (i, j)))
        .map(|(i, j)| object.centre() + Vector2::new(at(i), at(j)))
        .filter(|point| object.distance_m(*point) == 0.0)
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn overlap_is_having_a_point_in_common(
        x in 0.2..0.6, y in 0.2..0.6, heading in -3.0..3.0, kinds in 0..4,
    ) {
        let first = if kinds % 2 == 0 { a_box(0.4, 0.4, 0.3) } else { disc(0.4, 0.4) };
        let second = if kinds / 2 == 0 { a_box(x, y, heading) } else { disc(x, y) };
        let nearest = sampled(&first)
            .iter()
            .map(|point| second.distance_m(*point))
            .fold(f64::INFINITY, f64::min);
        if nearest == 0.0 {
            prop_assert!(first.overlaps(&second) && second.overlaps(&first));
        } else if nearest > 0.005 {
            prop_assert!(!first.overlaps(&second) && !second.overlaps(&first));
        }
    }

    #[test]
    fn a_wall_meets_what_it_runs_through(
        x1 in 0.0..0.8, y1 in 0.0..0.8, x2 in 0.0..0.8, y2 in 0.0..0.8, heading in -3.0..3.0, boxed in any::<bool>(),
    ) {
        let object = if boxed { a_box(0.4, 0.4, heading) } else { disc(0.4, 0.4) };
        let wall = Segment::new(Point2::new(x1, y1), Point2::new(x2, y2));
        let nearest = (0..=2_000)
            .map(|n| object.distance_m(wall.a + (wall.b - wall.a) * (f64::from(n) / 2_000.0)))
            .fold(f64::INFINITY, f64::min);
        if nearest > 1e-3 {
            prop_assert!(!object.meets_wall(&wall));
        }
        if nearest == 0.0 {
            prop_assert!(object.meets_wall(&wall));
        }
    }
}

fn arena(objects: &str) -> Result<Arena, Vec<ArenaError>> {
    Arena::from_json(&format!(
        r#"{{"name": "a", "width_m": 1, "height_m": 1, "walls_m": [[0.5, 0, 0.5, 0.5]],
            "starts": [{{"x_m": 0.1, "y_m": 0.1, "heading_rad": 0}}], "objects": {objects}}}"#
    ))
}

#[test]
fn reads_writes_and_tells_apart() {
    let one = arena(r#"[{"kind": "disc", "x_m": 0.8, "y_m": 0.8, "radius_m": 0.05}]"#).unwrap();
    assert_eq!(one.objects(), [disc(0.8, 0.8)]);
    assert_eq!(one.to_format().build().unwrap(), one);
    let none = arena("[]").unwrap();
    assert_ne!(one.content_key(), none.content_key());
    let heavier =
        arena(r#"[{"kind": "disc", "x_m": 0.8, "y_m": 0.8, "radius_m": 0.05, "mass_kg": 1}]"#);
    assert_ne!(one.content_key(), heavier.unwrap().content_key());
}

#[test]
fn what_is_refused() {
    let check = |objects: &str, pointer: &str, words: &str| {
        let errors = arena(objects).unwrap_err();
        let found = errors.iter().find(|error| error.pointer == pointer);
        let found = found.unwrap_or_else(|| panic!("nothing at {pointer}: {errors:?}"));
        assert!(found.to_string().contains(words), "{found}");
    };
    let at = |x: f64, y: f64| {
        format!(r#"{{"kind": "box", "x_m": {x}, "y_m": {y}, "width_m": 0.1, "height_m": 0.1}}"#)
    };
    check(
        &format!("[{}]", at(0.02, 0.5)),
        "/objects/0",
        "leaves the arena",
    );
    check(
        &format!("[{}]", at(0.5, 0.2)),
        "/objects/0",
        "wall 0 runs through",
    );
    check(
        &format!("[{}, {}]", at(0.8, 0.8), at(0.85, 0.85)),
        "/objects/1",
        "overlaps object 0",
    );
    check(
        r#"[{"kind": "disc", "x_m": 0.8, "y_m": 0.8, "radius_m": 3}]"#,
        "/objects/0/radius_m",
        "out of range",
    );
    check(
        r#"[{"kind": "disc", "x_m": 0.8, "y_m": 0.8, "radius_m": 0.1, "mass_kg": 0}]"#,
        "/objects/0/mass_kg",
        "out of range",
    );
    assert!(arena(r#"[{"kind": "ball", "x_m": 0.8, "y_m": 0.8}]"#).is_err());
    assert!(
        arena(r#"[{"kind": "disc", "x_m": 0.8, "y_m": 0.8, "radius_m": 0.1, "colour": 1}]"#)
            .is_err()
    );
}

#[test]
fn a_start_inside_an_object_is_refused_and_tiles_take_objects_along() {
    let near = arena(r#"[{"kind": "disc", "x_m": 0.2, "y_m": 0.1, "radius_m": 0.07}]"#).unwrap();
    assert!(near.check_starts(0.02).is_empty());
    let errors = near.check_starts(0.04);
    assert_eq!(errors[0].pointer, "/starts/0");
    assert!(errors[0].message.contains("object 0"), "{}", errors[0]);
    let tiling = crate::Tiling {
        tile: [2, 1],
        ..crate::Tiling::default()
    };
    let tiled = near.tiled(&tiling).unwrap();
    assert_eq!(tiled.objects().len(), 2);
    assert_eq!(tiled.objects()[1].centre(), Point2::new(1.2, 0.1));
}
