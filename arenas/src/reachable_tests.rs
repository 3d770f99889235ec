//! Against a flood fill on a fine grid, and against figures known by hand.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::time::Instant;

use nalgebra::Point2;
use proptest::prelude::*;

use super::*;
use crate::{ArenaFormat, GenerateFormat, GeneratorKind, Segment, builtin};

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

/// The arena of `shared` gates: two rooms and a gate between them at some height.
fn two_rooms(gate_m: f64, low_m: f64, turned: bool) -> Arena {
    let walls_m = [[1.0, 0.0, 1.0, low_m], [1.0, low_m + gate_m, 1.0, 2.0]];
    let walls_m = walls_m.map(|[x1, y1, x2, y2]| {
        if turned {
            [y1, x1, y2, x2]
        } else {
            [x1, y1, x2, y2]
        }
    });
    ArenaFormat {
        name: Some("two".to_owned()),
        width_m: Some(2.0),
        height_m: Some(2.0),
        walls_m: Some(walls_m.into()),
        starts: Some(vec![Pose {
            x_m: 0.2,
            y_m: 0.2,
            heading_rad: 0.0,
        }]),
        ..ArenaFormat::default()
    }
    .build()
    .unwrap()
}

#[test]
fn a_gate_is_open_or_closed_wherever_it_lies_on_the_grid() {
    for step in 0..200 {
        let low_m = 0.9 + 0.000_311 * f64::from(step);
        for turned in [false, true] {
            let wide = count(&two_rooms(0.0745, low_m, turned));
            assert!((9_200..9_500).contains(&wide), "{wide} at {low_m}");
            let exact = count(&two_rooms(0.074, low_m, turned));
            assert!((9_200..9_500).contains(&exact), "{exact} at {low_m}");
            for gate_m in [0.0735, 0.074 - 1e-8] {
                let narrow = count(&two_rooms(gate_m, low_m, turned));
                assert!((4_600..4_760).contains(&narrow), "{narrow} at {low_m}");
            }
        }
    }
}

#[test]
fn a_slanted_gate_opens_at_the_body_s_width() {
    // Two walls end to end at any angle, with the gate in the middle of the arena.
    for degrees in (0..180).step_by(7) {
        let angle = f64::from(degrees).to_radians();
        let (sin, cos) = angle.sin_cos();
        let gate = |gate_m: f64| {
            let far = |sign: f64| {
                let to_edge = 0.5 / cos.abs().max(sin.abs());
                let [near, far] = [0.5 * gate_m * sign, to_edge * sign];
                let [x, y] = [0.5 + cos * far, 0.5 + sin * far].map(|at| at.clamp(0.0, 1.0));
                [0.5 + cos * near, 0.5 + sin * near, x, y]
            };
            let mut arena = with_walls(vec![far(1.0), far(-1.0)], 0.5).to_format();
            let away = Pose {
                x_m: 0.5 - 0.25 * sin,
                y_m: 0.5 + 0.25 * cos,
                heading_rad: 0.0,
            };
            arena.starts = Some(vec![away]);
            count(&arena.build().unwrap())
        };
        let (open, closed) = (gate(0.074 + 1e-6), gate(0.074 - 1e-6));
        assert!(closed * 2 < open + 40, "{degrees}: {closed} of {open}");
        assert!(closed * 2 > open - 200, "{degrees}: {closed} of {open}");
    }
}

#[test]
fn corridors_narrower_than_the_body_are_closed_between_any_two_lines() {
    // Coarse squares: the lines are 8 cm apart, so the corridor lies between two of them.
    for (width_m, passes) in [(0.0739, false), (0.0741, true)] {
        let mut arena = with_walls(
            vec![
                [0.3, 0.0, 0.3, 0.5],
                [0.3, 0.5, 0.7, 0.5],
                [0.3, 0.5 + width_m, 0.7, 0.5 + width_m],
                [0.3, 0.5 + width_m, 0.3, 1.0],
            ],
            0.1,
        )
        .to_format();
        arena.squares = Some(crate::SquaresFormat::Side(2));
        let found = count(&arena.build().unwrap());
        assert_eq!(found, if passes { 4 } else { 2 }, "{width_m}");
    }
}

#[test]
fn places_are_within_reach_of_a_start_or_not() {
    let closed = vec![
        [0.2, 0.2, 0.5, 0.2],
        [0.5, 0.2, 0.5, 0.5],
        [0.5, 0.5, 0.2, 0.5],
        [0.2, 0.5, 0.2, 0.2],
    ];
    let arena = with_walls(closed, 0.8);
    let within = WithinReach::new(&arena, RADIUS_M, 1e-3);
    for place in 0..10_000 {
        let point = Point2::new(
            f64::from(place % 100) / 100.0,
            f64::from(place / 100) / 100.0,
        );
        let room_m = RADIUS_M + 1e-3;
        let boundary = arena.boundary();
        let walls = arena.walls().iter().chain(&boundary);
        let clear = walls
            .map(|wall| wall.distance_squared_m2(point))
            .fold(1.0, f64::min);
        if clear < room_m * room_m {
            continue;
        }
        let inside = (0.2..0.5).contains(&point.x) && (0.2..0.5).contains(&point.y);
        assert_eq!(within.holds(point.x, point.y), !inside, "{point}");
    }
    // From two starts, both rooms are.
    let one = count(&arena);
    let starts = [Point2::new(0.8, 0.5), Point2::new(0.35, 0.35)];
    let both = reachable_from(&arena, &starts, RADIUS_M).count;
    let inner = reachable_from(&arena, &starts[1..], RADIUS_M).count;
    assert!(inner > 400 && both == one + inner, "{one} {inner} {both}");
}

#[test]
fn giant_arenas_are_quick() {
    let long = |height_m: f64, generate| ArenaFormat {
        name: Some("long".to_owned()),
        width_m: Some(1_000.0),
        height_m: Some(height_m),
        generate,
        ..ArenaFormat::default()
    };
    let empty = ArenaFormat {
        walls_m: Some(Vec::new()),
        starts: Some(vec![Pose {
            x_m: 0.1,
            y_m: 0.1,
            heading_rad: 0.0,
        }]),
        ..long(0.3, None)
    };
    let rooms = long(0.5, Some(GenerateFormat::new(GeneratorKind::Rooms, 0)));
    for format in [empty, rooms] {
        let arena = format.build().unwrap();
        let began = Instant::now();
        assert!(count(&arena) > 6_000);
        // Below one, on a machine of its own.
        assert!(began.elapsed().as_secs_f64() < 5.0, "{:?}", began.elapsed());
    }
}

#[test]
fn more_walls_than_can_be_looked_at_are_bounded_work() {
    // Walls over the whole height, and as many rows as there may be.
    let walls_m: Vec<[f64; 4]> = (0..100_000)
        .map(|wall| {
            let x_m = 0.5 + 0.4 * f64::from(wall) / 1e5;
            [x_m, 0.0, x_m, 1.0]
        })
        .collect();
    let mut arena = with_walls(walls_m, 0.25).to_format();
    arena.squares = Some(crate::SquaresFormat::Side(1_000));
    let arena = arena.build().unwrap();
    let began = Instant::now();
    let found = count(&arena);
    assert!(
        began.elapsed().as_secs_f64() < 10.0,
        "{:?}",
        began.elapsed()
    );
    let expected = (0.5 - 2.0 * RADIUS_M) * (1.0 - 2.0 * RADIUS_M) * 1e6;
    assert!(
        (f64::from(found) / expected - 1.0).abs() < 0.2,
        "{found} of {expected}"
    );
}

/// What a disc of `radius_m` reaches of the points of a lattice, moving between neighbours.
fn lattice_flood(arena: &Arena, radius_m: f64, across_corners: bool) -> Vec<bool> {
    let side = 300_usize;
    let pitch_m = 1.0 / side as f64;
    let walls: Vec<Segment> = arena
        .boundary()
        .iter()
        .chain(arena.walls())
        .copied()
        .collect();
    let clear = |point: Point2<f64>| {
        let clear_m2 = walls.iter().map(|wall| wall.distance_squared_m2(point));
        clear_m2.fold(f64::INFINITY, f64::min) >= radius_m * radius_m
    };
    let place = |cell: usize| {
        Point2::new(
            (cell % side) as f64 * pitch_m + 0.5 * pitch_m,
            (cell / side) as f64 * pitch_m + 0.5 * pitch_m,
        )
    };
    let start = arena.starts()[0].position();
    let mut reached = vec![false; side * side];
    let mut todo = Vec::new();
    if clear(start) {
        todo.push((start.y / pitch_m) as usize * side + (start.x / pitch_m) as usize);
    }
    while let Some(cell) = todo.pop() {
        if reached[cell] || !clear(place(cell)) {
            continue;
        }
        reached[cell] = true;
        let (x, y) = (cell % side, cell / side);
        for (dx, dy) in [
            (-1, 0),
            (1, 0),
            (0, -1),
            (0, 1),
            (-1, -1),
            (1, 1),
            (-1, 1),
            (1, -1),
        ] {
            let (x, y) = (x as i64 + dx, y as i64 + dy);
            let inside = (0..side as i64).contains(&x) && (0..side as i64).contains(&y);
            if inside && (across_corners || dx == 0 || dy == 0) {
                todo.push(y as usize * side + x as usize);
            }
        }
    }
    reached
}

fn some_walls() -> impl Strategy<Value = Vec<[f64; 4]>> {
    let place = 0.0..1.0f64;
    let wall = (place.clone(), place, -0.4..0.4f64, -0.4..0.4f64).prop_map(|(x, y, dx, dy)| {
        // Every third one or so along an axis, as walls often are.
        let (dx, dy) = match (dx * 1e4) as i64 % 3 {
            0 => (dx, 0.0),
            1 => (0.0, dy),
            _ => (dx, dy),
        };
        [x, y, (x + dx).clamp(0.0, 1.0), (y + dy).clamp(0.0, 1.0)]
    });
    let long = |wall: &[f64; 4]| (wall[0] - wall[2]).hypot(wall[1] - wall[3]) > 1e-3;
    proptest::collection::vec(wall.prop_filter("long", long), 0..14)
}

fn arena_of(walls_m: Vec<[f64; 4]>, [x_m, y_m]: [f64; 2]) -> Arena {
    let mut arena = with_walls(walls_m, 0.5).to_format();
    arena.squares = Some(crate::SquaresFormat::Side(50));
    arena.starts = Some(vec![Pose {
        x_m,
        y_m,
        heading_rad: 0.0,
    }]);
    arena.build().unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// 50 squares have 300 points a side. A body that is half the diagonal of the lattice's cells
    /// larger reaches no more than the exact one, and one that much smaller no less.
    #[test]
    fn reach_lies_between_two_flood_fills(
        walls_m in some_walls(), x_m in 0.05..0.95f64, y_m in 0.05..0.95f64,
        radius_m in prop::sample::select(vec![0.01, 0.037, 0.06]),
    ) {
        let arena = arena_of(walls_m, [x_m, y_m]);
        let found = reachable(&arena, arena.starts()[0], radius_m);
        let margin_m = 0.7072 / 300.0;
        let squares_of = |reached: Vec<bool>| {
            let mut mask = vec![false; 2_500];
            for cell in (0..90_000).filter(|&cell| reached[cell]) {
                mask[cell / 300 / 6 * 50 + cell % 300 / 6] = true;
            }
            mask
        };
        let inner = squares_of(lattice_flood(&arena, radius_m + margin_m, false));
        // The start need not be on the lattice: a body a whole diagonal smaller is at a point of it.
        let outer = squares_of(lattice_flood(&arena, radius_m - margin_m, true));
        for square in 0..2_500 {
            prop_assert!(!inner[square] || found.mask[square], "square {} too few", square);
            prop_assert!(outer[square] || !found.mask[square], "square {} too many", square);
        }
    }

    /// Points hang together or not whatever other lines there are.
    #[test]
    fn what_hangs_together_does_not_depend_on_the_lines(
        walls_m in some_walls(),
        points in proptest::collection::vec((0.0..1.0f64, 0.0..1.0f64), 8),
        radius_m in prop::sample::select(vec![0.003, 0.02, 0.037]),
        shift in 0.0..1.0f64,
    ) {
        let arena = arena_of(walls_m, [0.5, 0.5]);
        let groups = |lines: usize| {
            let mut y_m: Vec<f64> = points.iter().map(|point| point.1).collect();
            y_m.extend([0.0, 1.0]);
            y_m.extend((0..lines).map(|line| (line as f64 + shift) / lines as f64));
            y_m.sort_by(f64::total_cmp);
            let mut space = FreeSpace::new(&arena, radius_m, y_m.into_iter()).unwrap();
            let points = points.iter().map(|&(x, y)| Point2::new(x, y));
            let from = |start: Point2<f64>, space: &mut FreeSpace| {
                let reached = space.reached_from(std::iter::once(start));
                let is_reached = |point| space.gap_at(point).is_some_and(|gap| reached[gap]);
                points.clone().map(is_reached).collect::<Vec<bool>>()
            };
            points.clone().map(|start| from(start, &mut space)).collect::<Vec<_>>()
        };
        let few = groups(0);
        prop_assert_eq!(&few, &groups(37));
        prop_assert_eq!(&few, &groups(1_000));
    }
}
