//! The arenas that robots move in: rectangles with walls of no thickness, start poses and a grid
//! of squares in which visits are counted.
//!
//! | from | to | by |
//! |---|---|---|
//! | JSON | a valid [`Arena`], or all that is wrong with it | [`Arena::from_json`], [`ArenaFormat::build`] |
//! | a name | a built-in arena | [`builtin()`], [`builtin_names`] |
//! | an arena | many of it side by side, larger or smaller | [`Arena::tiled`] |
//! | a seed | a maze, rooms, corridors or obstacles | [`GenerateFormat`] in [`ArenaFormat`] |
//! | an arena and a body radius | starts that overlap a wall | [`Arena::check_starts`] |
//! | the same and a start | the squares within reach | [`reachable()`] |
//! | an arena and a body radius | whether places are within reach of a start | [`WithinReach`] |
//! | an arena and a body radius | gates that the body just passes, or just does not | [`gates_at_the_limit`] |
//! | a point | its square | [`Squares`] |
//! | an arena | a drawing | [`render_svg`] |
//!
//! Lengths are metres, the origin is the lower left corner, y points up, angles are
//! counter-clockwise from the x axis in radians. The crate does no input or output, and equal
//! input gives bit-equal results on every machine.
//!
//! ```
//! use arenas::{ArenaFormat, GenerateFormat, GeneratorKind, reachable};
//!
//! let maze = ArenaFormat {
//!     width_m: Some(1.2),
//!     height_m: Some(1.2),
//!     generate: Some(GenerateFormat { braid: Some(0.5), ..GenerateFormat::new(GeneratorKind::Maze, 7) }),
//!     ..ArenaFormat::default()
//! }
//! .build()
//! .unwrap();
//! assert_eq!(maze.name(), "maze-7");
//! let within_reach = reachable(&maze, maze.starts()[0], 0.037);
//! assert!(within_reach.count > 3000);
//! ```

pub mod arena;
pub mod axis;
mod builtin;
mod error;
mod format;
mod free_space;
mod gates;
mod generate;
pub mod index;
mod near_pairs;
mod objects;
mod reachable;
mod segment;
mod sets;
mod squares;
mod starts;
mod svg;
mod tile;
mod validate;

pub use arena::{Arena, Pose};
pub use builtin::{builtin, builtin_names};
pub use error::ArenaError;
pub use format::{ArenaFormat, DEFAULT_SQUARES, SquaresFormat};
pub use gates::{Gate, gates_at_the_limit};
pub use generate::{GenerateFormat, GeneratorKind, ObstacleShape, Parameter};
pub use objects::{
    DEFAULT_OBJECT_FRICTION, DEFAULT_OBJECT_MASS_KG, MAX_OBJECTS, Movable, OBJECT_FRICTION_RANGE,
    OBJECT_HEADING_RANGE_RAD, OBJECT_MASS_RANGE_KG, OBJECT_PLACE_RANGE_M, OBJECT_SIZE_RANGE_M,
};
pub use reachable::{Reachable, WithinReach, reachable, reachable_from};
pub use segment::Segment;
pub use squares::Squares;
pub use svg::{SvgOptions, render_svg};
pub use tile::{SCALE_RANGE, Tiling};
pub use validate::{
    MAX_NAME_LENGTH, MAX_STARTS, MAX_WALLS, MIN_WALL_LENGTH_M, SIDE_RANGE_M, SQUARES_RANGE,
    WALL_TOLERANCE_M,
};
