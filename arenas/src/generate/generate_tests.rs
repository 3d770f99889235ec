//! Generated arenas: the same everywhere, connected, clear at the start.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use proptest::prelude::*;

use super::random::Random;
use super::*;
use crate::{Arena, ArenaFormat, Pose, Squares, reachable};

const RADIUS_M: f64 = 0.037;

fn build(side_m: f64, generate: GenerateFormat) -> Arena {
    ArenaFormat {
        width_m: Some(side_m),
        height_m: Some(side_m),
        generate: Some(generate),
        ..ArenaFormat::default()
    }
    .build()
    .unwrap()
}

/// FNV-1a, 64 bit.
fn digest(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[test]
fn a_seed_gives_the_same_walls_on_every_machine() {
    // Published results name arenas by kind and seed: these may not change unnoticed.
    let expected = [
        (GeneratorKind::Maze, 0x713e_9d3d_4314_15e9),
        (GeneratorKind::Rooms, 0x54de_54aa_b009_95d7),
        (GeneratorKind::Corridors, 0x814d_7c8e_c999_0bb6),
        (GeneratorKind::RandomObstacles, 0x782f_6140_484d_6950_u64),
    ];
    let found = GeneratorKind::ALL.map(|kind| {
        (
            kind,
            digest(&build(1.2, GenerateFormat::new(kind, 7)).content_key()),
        )
    });
    assert_eq!(found, expected, "{found:#x?}");
    for kind in GeneratorKind::ALL {
        let [one, other] = [1, 2].map(|seed| build(1.2, GenerateFormat::new(kind, seed)));
        assert_ne!(one.content_key(), other.content_key(), "{kind:?}");
    }
}

#[test]
fn names_default_to_kind_and_seed() {
    for kind in GeneratorKind::ALL {
        assert_eq!(
            build(1.2, GenerateFormat::new(kind, 7)).name(),
            format!("{}-7", kind.as_str())
        );
    }
    let named = ArenaFormat {
        name: Some("mine".to_owned()),
        width_m: Some(0.6),
        height_m: Some(0.6),
        generate: Some(GenerateFormat::new(GeneratorKind::Maze, 1)),
        ..ArenaFormat::default()
    };
    assert_eq!(named.build().unwrap().name(), "mine");
}

#[test]
fn defaults_are_in_their_ranges_and_every_number_has_a_kind() {
    for kind in GeneratorKind::ALL {
        for parameter in kind.parameters() {
            assert!(
                (parameter.min..=parameter.max).contains(&parameter.default),
                "{}",
                parameter.name
            );
        }
        let written = serde_json::to_value(GenerateFormat::new(kind, 1)).unwrap();
        assert_eq!(
            written,
            serde_json::json!({"kind": kind.as_str(), "seed": 1})
        );
    }
}

/// The centre of every cell of the grid can be reached.
#[track_caller]
fn check_connected(arena: &Arena, cell_m: f64) {
    assert_eq!(arena.check_starts(RADIUS_M), []);
    let found = reachable(arena, arena.starts()[0], RADIUS_M);
    let squares = Squares::of(arena);
    let cells = (arena.width_m() / cell_m).round() as usize;
    for cell in 0..cells * cells {
        let [x_m, y_m] = [cell % cells, cell / cells]
            .map(|index| (index as f64 + 0.5) * arena.width_m() / cells as f64);
        assert!(
            found.mask[squares.square_of(x_m, y_m)],
            "cell {cell} of {}",
            arena.name()
        );
    }
}

#[test]
fn a_perfect_maze_has_a_wall_unit_for_every_pair_not_joined() {
    let arena = build(
        1.2,
        GenerateFormat {
            cell_m: Some(0.1),
            ..GenerateFormat::new(GeneratorKind::Maze, 3)
        },
    );
    // 12 x 12 cells have 2 * 12 * 11 neighbouring pairs, a spanning tree joins 143.
    let units: f64 = arena.walls().iter().map(|wall| wall.length_m() / 0.1).sum();
    assert!(
        (units - f64::from(2 * 12 * 11 - 143)).abs() < 1e-9,
        "{units}"
    );
    assert!(
        arena.walls().len() < 80,
        "collinear walls are merged: {}",
        arena.walls().len()
    );
}

#[test]
fn a_braided_maze_has_no_dead_ends() {
    let mut random = Random::new(5);
    let mut cells = cells::Cells::spanning_tree(20, 30, &mut random);
    let openings = |cells: &cells::Cells, cell: usize| {
        usize::from(cells.east(cell))
            + usize::from(cells.north(cell))
            + usize::from(!cell.is_multiple_of(20) && cells.east(cell - 1))
            + usize::from(cell >= 20 && cells.north(cell - 20))
    };
    let dead_ends =
        |cells: &cells::Cells| (0..600).filter(|&cell| openings(cells, cell) == 1).count();
    assert!(dead_ends(&cells) > 20);
    cells.open_dead_ends(1.0, &mut random);
    assert_eq!(dead_ends(&cells), 0);
}

#[test]
fn boxes_keep_apart_and_are_closed() {
    let generate = GenerateFormat {
        shape: Some(ObstacleShape::Box),
        wall_length_m: Some(0.05),
        gap_m: Some(0.08),
        density_per_m2: Some(20.0),
        ..GenerateFormat::new(GeneratorKind::RandomObstacles, 1)
    };
    let arena = build(2.0, generate);
    assert_eq!(arena.walls().len(), 4 * 80);
    for outline in arena.walls().chunks(4) {
        assert_eq!(outline[3].b, outline[0].a);
        assert!(
            outline
                .iter()
                .all(|wall| (wall.length_m() - 0.05).abs() < 1e-12)
        );
    }
    for (index, wall) in arena.walls().iter().enumerate() {
        for other in arena.walls().iter().skip(index / 4 * 4 + 4) {
            assert!(other.distance_squared_m2(wall.a) > 0.08 * 0.08);
        }
    }
}

#[test]
fn obstacles_keep_away_from_given_starts() {
    let starts: Vec<Pose> = (1..10)
        .map(|i| Pose {
            x_m: 0.2 * f64::from(i),
            y_m: 1.0,
            heading_rad: 0.0,
        })
        .collect();
    let arena = ArenaFormat {
        width_m: Some(2.0),
        height_m: Some(2.0),
        starts: Some(starts.clone()),
        generate: Some(GenerateFormat {
            gap_m: Some(0.0),
            density_per_m2: Some(100.0),
            ..GenerateFormat::new(GeneratorKind::RandomObstacles, 1)
        }),
        ..ArenaFormat::default()
    }
    .build()
    .unwrap();
    assert_eq!(arena.starts(), starts);
    assert_eq!(arena.walls().len(), 400);
    assert_eq!(arena.check_starts(0.06), []);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn grids_are_connected(seed in any::<u64>(), side_m in 0.6..2.0f64, braid in 0.0..1.0f64, loops in 0.0..1.0f64) {
        let maze = GenerateFormat { braid: Some(braid), ..GenerateFormat::new(GeneratorKind::Maze, seed) };
        check_connected(&build(side_m, maze), 0.12);
        let rooms = GenerateFormat { loops: Some(loops), ..GenerateFormat::new(GeneratorKind::Rooms, seed) };
        check_connected(&build(side_m, rooms), 0.2);
        let corridors = GenerateFormat { loops: Some(loops), ..GenerateFormat::new(GeneratorKind::Corridors, seed) };
        check_connected(&build(side_m, corridors), 0.2);
    }

    #[test]
    fn free_space_between_obstacles_is_connected(seed in any::<u64>(), side_m in 0.6..2.0f64) {
        let arena = build(side_m, GenerateFormat::new(GeneratorKind::RandomObstacles, seed));
        prop_assert_eq!(arena.check_starts(RADIUS_M), vec![]);
        let found = reachable(&arena, arena.starts()[0], RADIUS_M);
        let squares = Squares::of(&arena);
        for square in 0..squares.count() {
            let centre = squares.centre_of(square);
            let clear = arena.walls().iter().chain(&arena.boundary())
                .all(|wall| wall.distance_squared_m2(centre) > 0.04 * 0.04);
            prop_assert!(!clear || found.mask[square], "{}: {}", arena.name(), centre);
        }
    }
}
