//! The kinds of generators and the numbers that each takes, with default and range.

use serde::{Deserialize, Serialize};

/// What a generator makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GeneratorKind {
    /// Cells joined by a random spanning tree, a part of the dead ends opened.
    Maze,
    /// A grid of rooms; gates at random places join them.
    Rooms,
    /// Corridors between solid blocks.
    Corridors,
    /// Separate walls or boxes at random places and angles.
    RandomObstacles,
}

/// A number that a generator takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Name in the format.
    pub name: &'static str,
    /// Value if left out.
    pub default: f64,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Effect and unit.
    pub doc: &'static str,
}

const fn parameter(
    name: &'static str,
    default: f64,
    min: f64,
    max: f64,
    doc: &'static str,
) -> Parameter {
    Parameter {
        name,
        default,
        min,
        max,
        doc,
    }
}

const MAZE: &[Parameter] = &[
    parameter(
        "cell_m",
        0.12,
        0.01,
        100.0,
        "width of a corridor, metres; rounded so that whole cells fill the arena",
    ),
    parameter(
        "braid",
        0.0,
        0.0,
        1.0,
        "part of the dead ends that gets a second opening",
    ),
];
const ROOMS: &[Parameter] = &[
    parameter(
        "room_m",
        0.2,
        0.01,
        100.0,
        "side of a room, metres; rounded so that whole rooms fill the arena",
    ),
    parameter(
        "gate_m",
        0.09,
        0.001,
        100.0,
        "width of a gate, metres; less than a room's side",
    ),
    parameter(
        "loops",
        0.3,
        0.0,
        1.0,
        "part of the walls not needed open for reaching every room that gets a gate, too",
    ),
];
const CORRIDORS: &[Parameter] = &[
    parameter(
        "cell_m",
        0.2,
        0.01,
        100.0,
        "distance between parallel corridors, metres; rounded so that whole cells fill the arena",
    ),
    parameter(
        "corridor_m",
        0.1,
        0.005,
        100.0,
        "width of a corridor, metres; less than cell_m",
    ),
    parameter(
        "loops",
        0.2,
        0.0,
        1.0,
        "part of the links not needed for reaching every crossing that is there, too",
    ),
];
const RANDOM_OBSTACLES: &[Parameter] = &[
    parameter(
        "density_per_m2",
        8.0,
        0.0,
        10_000.0,
        "obstacles a square metre",
    ),
    parameter(
        "wall_length_m",
        0.1,
        0.005,
        10.0,
        "length of a wall or side of a box, metres",
    ),
    parameter(
        "gap_m",
        0.1,
        0.0,
        10.0,
        "least distance between obstacles and to the boundary, metres; the free space is connected for every body whose diameter is less; 0 lets obstacles cross",
    ),
    parameter(
        "clear_m",
        0.06,
        0.001,
        10.0,
        "radius without obstacles around each start, metres",
    ),
];

impl GeneratorKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [
        Self::Maze,
        Self::Rooms,
        Self::Corridors,
        Self::RandomObstacles,
    ];

    /// Name in the format.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Maze => "maze",
            Self::Rooms => "rooms",
            Self::Corridors => "corridors",
            Self::RandomObstacles => "random-obstacles",
        }
    }

    /// The numbers that this kind takes, beside `seed` (and `shape`, of random obstacles).
    pub const fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::Maze => MAZE,
            Self::Rooms => ROOMS,
            Self::Corridors => CORRIDORS,
            Self::RandomObstacles => RANDOM_OBSTACLES,
        }
    }
}
