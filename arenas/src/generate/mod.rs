//! Arenas made from a seed: mazes, rooms, corridors and random obstacles from 0.6 m to 60 m.
//! Only integer draws and correctly rounded arithmetic, so every machine makes the same walls.

mod axis_walls;
mod cells;
mod layouts;
mod obstacles;
mod parameters;
mod random;

use crate::arena::Pose;
use crate::error::ArenaError;
use crate::segment::Segment;
use crate::validate::MAX_WALLS;
pub use obstacles::ObstacleShape;
pub use parameters::{GenerateFormat, GeneratorKind, Parameter};
use random::Random;

/// A generator with every parameter checked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Generator {
    seed: u64,
    layout: Layout,
}

#[derive(Clone, Debug, PartialEq)]
enum Layout {
    Maze(layouts::Maze),
    Rooms(layouts::Rooms),
    Corridors(layouts::Corridors),
    RandomObstacles(obstacles::RandomObstacles),
}

/// What a generator makes.
pub(crate) struct Generated {
    pub walls: Vec<Segment>,
    /// Where robots start if the arena does not say.
    pub start: Pose,
}

impl Generator {
    /// Name of an arena that has none: the kind and the seed.
    pub fn name(&self) -> String {
        let kind = match self.layout {
            Layout::Maze(_) => GeneratorKind::Maze,
            Layout::Rooms(_) => GeneratorKind::Rooms,
            Layout::Corridors(_) => GeneratorKind::Corridors,
            Layout::RandomObstacles(_) => GeneratorKind::RandomObstacles,
        };
        format!("{}-{}", kind.as_str(), self.seed)
    }

    /// Makes the walls for an arena of `size_m`, width and height. Obstacles keep away from the
    /// given `starts`; the other layouts do not depend on them.
    pub fn run(&self, size_m: [f64; 2], starts: Option<&[Pose]>) -> Result<Generated, ArenaError> {
        let mut random = Random::new(self.seed);
        let generated = match &self.layout {
            Layout::Maze(maze) => maze.generate(size_m, &mut random),
            Layout::Rooms(rooms) => rooms.generate(size_m, &mut random),
            Layout::Corridors(corridors) => corridors.generate(size_m, &mut random),
            Layout::RandomObstacles(obstacles) => {
                obstacles.generate(size_m, starts, &mut random)?
            }
        };
        if generated.walls.len() > MAX_WALLS {
            return Err(ArenaError::new(
                "/generate",
                format!("makes {} walls", generated.walls.len()),
                format!("at most {MAX_WALLS} walls"),
            ));
        }
        Ok(generated)
    }
}

#[cfg(test)]
#[path = "generate_tests.rs"]
mod tests;
