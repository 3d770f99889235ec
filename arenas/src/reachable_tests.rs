//! Against a flood fill on a fine grid, and against figures known by hand.
#![allow(clippy::unwrap_used)]

use std::time::Instant;

use super::*;
use crate::{ArenaFormat, GenerateFormat, GeneratorKind, builtin};

const RADIUS_M: f64 = 0.037;

/// Flood fill over the centres of `side` x `side` cells: slow and simple.
fn flood(arena: &Arena, side: usize) -> Vec<bool> {
    let walls: Vec<Segment> = arena
        .boundary()
        .iter()
        .chain(arena.walls())
        .copied()
        .collect();
    let [cell_x_m, cell_y_m] = [
        arena.width_m() / side as f64,
        arena.height_m() / side as f64,
    ];
    let free: Vec<bool> = (0..side * side)
        .map(|cell| {
            let centre = Point2::new(
                cell_x_m * ((cell % side) as f64 + 0.5),
                cell_y_m * ((cell / side) as f64 + 0.5),
            );
            walls
                .iter()
                .all(|wall| wall.distance_squared_m2(centre) >= RADIUS_M * RADIUS_M)
        })
        .collect();
    let start = arena.starts()[0];
    let first = (start.y_m / cell_y_m) as usize * side + (start.x_m / cell_x_m) as usize;
    let squares = Squares::of(arena);
    let mut mask = vec![false; squares.count()];
    let mut seen = vec![false; side * side];
    let mut todo = vec![first];
    while let Some(cell) = todo.pop() {
        if seen[cell] || !free[cell] {
            continue;
        }
        seen[cell] = true;
        let (x, y) = (cell % side, cell / side);
        mask[squares.square_of((x as f64 + 0.5) * cell_x_m, (y as f64 + 0.5) * cell_y_m)] = true;
        todo.extend((x > 0).then(|| cell - 1));
        todo.extend((x + 1 < side).then_some(cell + 1));
        todo.extend((y > 0).then(|| cell - side));
        todo.extend((y + 1 < side).then_some(cell + side));
    }
    mask
}

#[test]
fn built_in_arenas_have_the_known_counts() {
    for (name, expected) in [
        ("easy", 4630.0),
        ("graph", 4580.0),
        ("maze", 4370.0),
        ("hard-maze", 4310.0),
    ] {
        let arena = builtin(name).unwrap();
        let found = reachable(&arena, arena.starts()[0], RADIUS_M);
        assert!(
            (f64::from(found.count) / expected - 1.0).abs() < 0.01,
            "{name}: {}",
            found.count
        );
        assert_eq!(
            found.mask.iter().filter(|&&reached| reached).count() as u32,
            found.count
        );
    }
}

#[test]
fn built_in_arenas_agree_with_a_flood_fill() {
    for name in crate::builtin_names() {
        let arena = builtin(name).unwrap();
        let found = reachable(&arena, arena.starts()[0], RADIUS_M);
        let flooded = flood(&arena, 600);
        let differing = found
            .mask
            .iter()
            .zip(&flooded)
            .filter(|(one, other)| one != other)
            .count();
        let flooded = flooded.iter().filter(|&&reached| reached).count();
        assert!(
            differing * 100 < flooded,
            "{name}: {differing} of {flooded} squares differ"
        );
    }
}

fn with_walls(walls_m: Vec<[f64; 4]>, x_m: f64) -> Arena {
    ArenaFormat {
        name: Some("a".to_owned()),
        width_m: Some(1.0),
        height_m: Some(1.0),
        walls_m: Some(walls_m),
        starts: Some(vec![Pose {
            x_m,
            y_m: 0.5,
            heading_rad: 0.0,
        }]),
        ..ArenaFormat::default()
    }
    .build()
    .unwrap()
}

fn count(arena: &Arena) -> u32 {
    reachable(arena, arena.starts()[0], RADIUS_M).count
}

#[test]
fn open_room_is_all_but_the_rim() {
    // The centre stays 0.037 m from each wall: squares 3 to 96 of 0 to 99.
    assert_eq!(count(&with_walls(vec![], 0.5)), 94 * 94);
}

#[test]
fn gates_open_and_shut_at_the_body_s_width() {
    let gate = |width_m: f64| {
        let half_m = 0.5 * width_m;
        with_walls(
            vec![[0.5, 0.0, 0.5, 0.5 - half_m], [0.5, 0.5 + half_m, 0.5, 1.0]],
            0.25,
        )
    };
    let one_side = count(&gate(0.0738));
    assert!(
        (44 * 94..44 * 94 + 20).contains(&one_side),
        "half the room: {one_side}"
    );
    assert!(count(&gate(0.0746)) > 2 * one_side - 20);
}

#[test]
fn a_robot_inside_a_closed_room_stays_there() {
    let room = |x_m| {
        with_walls(
            vec![
                [0.4, 0.4, 0.6, 0.4],
                [0.6, 0.4, 0.6, 0.6],
                [0.6, 0.6, 0.4, 0.6],
                [0.4, 0.6, 0.4, 0.4],
            ],
            x_m,
        )
    };
    // The centre moves from 0.437 to 0.563: squares 43 to 56.
    assert_eq!(count(&room(0.5)), 14 * 14);
    let outside = count(&room(0.2));
    // It stays out of squares 37 to 62, but for the rounded corners.
    assert!(
        (94 * 94 - 26 * 26..94 * 94 - 26 * 26 + 20).contains(&outside),
        "{outside}"
    );
    assert_eq!(count(&room(0.41)), 0, "overlaps a wall");
    assert_eq!(count(&room(0.437)), 14 * 14, "touches a wall");
}

#[test]
fn points_do_not_pass_through_walls() {
    let arena = with_walls(vec![[0.5, 0.0, 0.5, 1.0], [0.0, 0.25, 1.0, 0.75]], 0.25);
    let found = reachable(&arena, arena.starts()[0], 0.0);
    assert!((3000..3900).contains(&found.count), "{}", found.count);
}

#[test]
fn huge_bodies_reach_nothing() {
    let arena = builtin("maze").unwrap();
    for radius_m in [f64::INFINITY, 1e300, 1.0] {
        assert_eq!(reachable(&arena, arena.starts()[0], radius_m).count, 0);
    }
}

#[test]
fn large_arenas_are_quick() {
    for (kind, density_per_m2) in [
        (GeneratorKind::RandomObstacles, Some(5.6)),
        (GeneratorKind::Maze, None),
    ] {
        let generate = GenerateFormat {
            density_per_m2,
            cell_m: (kind == GeneratorKind::Maze).then_some(0.24),
            ..GenerateFormat::new(kind, 1)
        };
        let arena = ArenaFormat {
            width_m: Some(60.0),
            height_m: Some(60.0),
            generate: Some(generate),
            ..ArenaFormat::default()
        }
        .build()
        .unwrap();
        let began = Instant::now();
        let found = reachable(&arena, arena.starts()[0], RADIUS_M);
        let took = began.elapsed();
        assert_eq!(found.count, 10_000);
        // Well above what it takes, for slow and busy machines.
        assert!(took.as_secs_f64() < 10.0, "{took:?}");
    }
}
