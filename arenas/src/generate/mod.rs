//! Arenas made from a seed: mazes, rooms, corridors and random obstacles from 0.6 m to 60 m.
//! Only integer draws and correctly rounded arithmetic, so every machine makes the same walls.

mod axis_walls;
mod cells;
mod generated;
mod generator;
mod kinds;
mod layouts;
mod obstacles;
mod parameters;
mod random;

pub(crate) use generated::Generated;
pub use kinds::{GeneratorKind, Parameter};
pub use obstacles::ObstacleShape;
pub use parameters::GenerateFormat;

#[cfg(test)]
#[path = "generate_tests.rs"]
mod tests;
