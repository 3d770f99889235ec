//! Tests of tiled arenas.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use crate::{builtin, reachable};

const RADIUS_M: f64 = 0.037;

fn tiling(columns: u32, rows: u32) -> Tiling {
    Tiling {
        tile: [columns, rows],
        ..Tiling::default()
    }
}

fn pointers(arena: &Arena, tiling: &Tiling) -> Vec<String> {
    let errors = arena.tiled(tiling).unwrap_err();
    errors.into_iter().map(|error| error.pointer).collect()
}

#[test]
fn one_tile_is_the_arena_itself() {
    for name in crate::builtin_names() {
        let arena = builtin(name).unwrap();
        let one = arena.tiled(&Tiling::default()).unwrap();
        assert_eq!(one.content_key(), arena.content_key());
        assert_eq!(one.name(), format!("{name}-1x1"));
    }
}

#[test]
fn tiles_stand_side_by_side_and_start_in_rounds() {
    let json = r#"{"name":"a","width_m":0.6,"height_m":0.4,"walls_m":[[0.1,0.1,0.2,0.1]],"squares":10,
        "starts":[{"x_m":0.3,"y_m":0.2,"heading_rad":1},{"x_m":0.5,"y_m":0.2,"heading_rad":2}]}"#;
    let arena = Arena::from_json(json).unwrap();
    let tiled = arena.tiled(&tiling(2, 3)).unwrap();
    assert_eq!((tiled.squares(), tiled.walls().len()), ([20, 30], 6));
    assert!((tiled.width_m() - 1.2).abs() < 1e-12 && (tiled.height_m() - 1.2).abs() < 1e-12);
    let place = |start: usize| {
        let Pose {
            x_m,
            y_m,
            heading_rad,
        } = tiled.starts()[start];
        [x_m, y_m, heading_rad].map(|value| (value * 1e6).round() / 1e6)
    };
    assert_eq!(tiled.starts().len(), 12);
    assert_eq!(place(0), [0.3, 0.2, 1.0]);
    assert_eq!(place(1), [0.9, 0.2, 1.0]);
    assert_eq!(place(2), [0.3, 0.6, 1.0]);
    assert_eq!(place(6), [0.5, 0.2, 2.0]);
    assert_eq!(tiled.to_format().build().unwrap(), tiled);
    let large = arena
        .tiled(&Tiling {
            scale: 2.0,
            ..tiling(1, 1)
        })
        .unwrap();
    assert_eq!((large.width_m(), large.walls()[0].length_m()), (1.2, 0.2));
}

#[test]
fn robots_can_go_from_tile_to_tile() {
    for name in ["easy", "maze"] {
        let arena = builtin(name).unwrap();
        let one = reachable(&arena, arena.starts()[0], RADIUS_M).count;
        for doorway_m in [None, Some(0.2)] {
            let tiled = arena
                .tiled(&Tiling {
                    doorway_m,
                    ..tiling(3, 2)
                })
                .unwrap();
            assert_eq!(tiled.check_starts(RADIUS_M), []);
            let all = reachable(&tiled, tiled.starts()[0], RADIUS_M).count;
            assert!(all > 6 * one, "{name} {doorway_m:?}: {all} of 6 x {one}");
            // The rims along the sides that tiles share are open now.
            assert!(all < 8 * one, "{name} {doorway_m:?}: {all} of 6 x {one}");
        }
    }
}

#[test]
fn a_doorway_as_wide_as_the_side_is_no_wall_and_a_narrow_one_closes() {
    let json = r#"{"name":"a","width_m":0.6,"height_m":0.6,"walls_m":[],
        "starts":[{"x_m":0.3,"y_m":0.3,"heading_rad":0}]}"#;
    let arena = Arena::from_json(json).unwrap();
    let with = |doorway_m| {
        let tiling = Tiling {
            doorway_m: Some(doorway_m),
            ..tiling(2, 1)
        };
        arena.tiled(&tiling).unwrap()
    };
    assert!(with(0.6).walls().is_empty());
    assert_eq!(with(0.1).walls().len(), 2);
    let count = |arena: &Arena| reachable(arena, arena.starts()[0], RADIUS_M).count;
    let one = count(&arena);
    // A body can lean into the doorway, but not pass.
    assert!(count(&with(0.05)) < one + one / 20);
    assert!(count(&with(0.1)) > 2 * one);
}

#[test]
fn too_large_and_wrong_tilings_name_their_fields() {
    let easy = builtin("easy").unwrap();
    assert_eq!(pointers(&easy, &tiling(11, 0)), ["/tile/0", "/tile/1"]);
    let error = &easy.tiled(&tiling(11, 1)).unwrap_err()[0];
    assert!(error.allowed.starts_with("1 to 10 columns"), "{error}");
    let coarse = Tiling {
        squares: Some([20, 20]),
        ..tiling(50, 50)
    };
    assert_eq!(easy.tiled(&coarse).unwrap().squares(), [1000, 1000]);
    let finest = Tiling {
        squares: Some([1, 1]),
        ..tiling(200, 200)
    };
    assert_eq!(pointers(&easy, &finest), ["/tile"]);
    for (wrong, pointer) in [
        (
            Tiling {
                scale: f64::NAN,
                ..tiling(1, 1)
            },
            "/scale",
        ),
        (
            Tiling {
                scale: 0.01,
                ..tiling(1, 1)
            },
            "/scale",
        ),
        (
            Tiling {
                doorway_m: Some(0.0),
                ..tiling(2, 1)
            },
            "/doorway_m",
        ),
        (
            Tiling {
                squares: Some([0, 1]),
                ..tiling(2, 1)
            },
            "/squares",
        ),
        (
            Tiling {
                name: Some("A b".into()),
                ..tiling(2, 1)
            },
            "/name",
        ),
    ] {
        assert_eq!(pointers(&easy, &wrong)[0], pointer, "{wrong:?}");
    }
}
