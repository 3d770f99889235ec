//! A generator with every parameter checked, and what it makes of a seed.

use super::generated::Generated;
use super::kinds::GeneratorKind;
use super::layouts::{Corridors, Maze, Rooms};
use super::obstacles::RandomObstacles;
use super::random::Random;
use crate::arena::Pose;
use crate::error::ArenaError;
use crate::validate::MAX_WALLS;

/// A generator with every parameter checked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Generator {
    pub(super) seed: u64,
    pub(super) layout: Layout,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Layout {
    Maze(Maze),
    Rooms(Rooms),
    Corridors(Corridors),
    RandomObstacles(RandomObstacles),
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
