//! An arena made of copies of another, side by side: more room at the same density of walls.

use nalgebra::Point2;

use crate::arena::{Arena, Pose};
use crate::error::ArenaError;
use crate::objects::{self, MAX_OBJECTS, Movable};
use crate::segment::Segment;
use crate::validate::{
    self, MAX_STARTS, MAX_WALLS, MIN_WALL_LENGTH_M, SIDE_RANGE_M, SQUARES_RANGE,
};

/// Range of [`Tiling::scale`].
pub const SCALE_RANGE: [f64; 2] = [0.01, 100.0];

/// How an arena is repeated. Movable objects go along; their size stays, as that of robots does.
#[derive(Clone, Debug, PartialEq)]
pub struct Tiling {
    /// Tiles in a row and in a column.
    pub tile: [u32; 2],
    /// Factor on every length of a tile, 0.01 to 100: sides, walls and places of starts.
    pub scale: f64,
    /// Width of the opening in the middle of each side that two tiles share, metres; without it
    /// they have no wall between them.
    pub doorway_m: Option<f64>,
    /// Columns and rows of squares a tile; without it those of the arena.
    pub squares: Option<[u32; 2]>,
    /// Name of the arena that is made; without it the tile's with the numbers of tiles.
    pub name: Option<String>,
}

impl Default for Tiling {
    /// The arena as it is.
    fn default() -> Self {
        Self {
            tile: [1, 1],
            scale: 1.0,
            doorway_m: None,
            squares: None,
            name: None,
        }
    }
}

impl Arena {
    /// The arena repeated in columns and rows. The outer walls remain around the whole; between
    /// tiles there is none, or one with a doorway in the middle of each shared side. Starts are
    /// taken in rounds: the first one of every tile, row by row from the lower left, then the second
    /// ones, so that any number of robots is spread evenly.
    ///
    /// # Errors
    /// Every wrong field, with pointers `/tile`, `/scale`, `/doorway_m`, `/squares` or `/name`. An
    /// arena that would be too large is refused with the most tiles that there may be.
    pub fn tiled(&self, tiling: &Tiling) -> Result<Arena, Vec<ArenaError>> {
        let mut errors = Vec::new();
        let scale = tiling.scale;
        if !(SCALE_RANGE[0]..=SCALE_RANGE[1]).contains(&scale) {
            errors.push(ArenaError::new(
                "/scale",
                format!("{scale} is out of range"),
                format!("{} to {}", SCALE_RANGE[0], SCALE_RANGE[1]),
            ));
        }
        if let Some(name) = &tiling.name {
            errors.extend(validate::name(name));
        }
        let squares = tiling.squares.unwrap_or(self.squares());
        errors.extend(validate::squares(squares));
        if !errors.is_empty() {
            return Err(errors);
        }
        let size_m = [self.width_m() * scale, self.height_m() * scale];
        let shorter_m = size_m[0].min(size_m[1]);
        if let Some(doorway_m) = tiling.doorway_m
            && !(doorway_m > 0.0 && doorway_m <= shorter_m)
        {
            errors.push(ArenaError::new(
                "/doorway_m",
                format!("{doorway_m} m is out of range"),
                format!("more than 0, at most the tile's shorter side, {shorter_m} m"),
            ));
        }
        self.check_tiles(tiling.tile, size_m, squares, &mut errors);
        if !errors.is_empty() {
            return Err(errors);
        }
        let [columns, rows] = tiling.tile;
        let whole_m = [size_m[0] * f64::from(columns), size_m[1] * f64::from(rows)];
        let corners: Vec<[f64; 2]> = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| [column, row]))
            .map(|[column, row]| [size_m[0] * f64::from(column), size_m[1] * f64::from(row)])
            .collect();
        let moved = |point: Point2<f64>, corner: [f64; 2]| {
            Point2::new(
                (corner[0] + point.x * scale).clamp(0.0, whole_m[0]),
                (corner[1] + point.y * scale).clamp(0.0, whole_m[1]),
            )
        };
        let mut walls: Vec<Segment> = Vec::with_capacity(corners.len() * self.walls().len());
        for &corner in &corners {
            let inner = self.walls().iter();
            walls.extend(
                inner.map(|wall| Segment::new(moved(wall.a, corner), moved(wall.b, corner))),
            );
        }
        if let Some(doorway_m) = tiling.doorway_m {
            walls.extend(walls_between(tiling.tile, size_m, doorway_m));
        }
        let starts: Vec<Pose> = self
            .starts()
            .iter()
            .flat_map(|start| {
                corners.iter().map(|&corner| {
                    let place = moved(start.position(), corner);
                    Pose {
                        x_m: place.x,
                        y_m: place.y,
                        heading_rad: start.heading_rad,
                    }
                })
            })
            .collect();
        let name = tiling.name.clone().unwrap_or_else(|| {
            let tile: String = self.name().chars().take(40).collect();
            format!("{tile}-{columns}x{rows}")
        });
        let squares = [squares[0] * columns, squares[1] * rows];
        let objects: Vec<Movable> = corners
            .iter()
            .flat_map(|&corner| {
                let object = move |o: &Movable| o.moved_to(moved(o.centre(), corner));
                self.objects().iter().map(object)
            })
            .take(MAX_OBJECTS + 1)
            .collect();
        objects::check(&objects, whole_m, &walls, &mut errors);
        if !errors.is_empty() {
            return Err(errors);
        }
        Ok(Arena::from_checked(
            name, whole_m, walls, starts, squares, objects,
        ))
    }

    /// Whether so many tiles of this size stay inside the limits of an arena.
    fn check_tiles(
        &self,
        tile: [u32; 2],
        size_m: [f64; 2],
        squares: [u32; 2],
        errors: &mut Vec<ArenaError>,
    ) {
        for (place, what) in ["columns", "rows"].into_iter().enumerate() {
            let by_squares = SQUARES_RANGE[1] / squares[place];
            let by_metres = (SIDE_RANGE_M[1] / size_m[place]).min(f64::from(u32::MAX)) as u32;
            let most = by_squares.min(by_metres);
            if size_m[place] < SIDE_RANGE_M[0] {
                errors.push(ArenaError::new(
                    "/scale",
                    format!("a tile would be {} m long", size_m[place]),
                    format!("sides of at least {} m", SIDE_RANGE_M[0]),
                ));
            } else if !(1..=most).contains(&tile[place]) {
                let why = if by_squares <= by_metres {
                    format!(
                        "{} squares a side at {} a tile; fewer `squares` a tile allow more tiles",
                        SQUARES_RANGE[1], squares[place]
                    )
                } else {
                    format!("{} m a side", SIDE_RANGE_M[1])
                };
                errors.push(ArenaError::new(
                    format!("/tile/{place}"),
                    format!("{} {what}", tile[place]),
                    format!("1 to {most} {what} ({why})"),
                ));
            }
        }
        // Each tile has at most four pieces of wall towards the next ones.
        let walls = self.walls().len() + 4;
        let most = (MAX_WALLS / walls).min(MAX_STARTS / self.starts().len());
        let tiles = u64::from(tile[0]) * u64::from(tile[1]);
        if errors.is_empty() && tiles > most as u64 {
            errors.push(ArenaError::new(
                "/tile",
                format!("{tiles} tiles of {} walls", self.walls().len()),
                format!("at most {most} tiles ({MAX_WALLS} walls in all)"),
            ));
        }
    }
}

/// Walls on the sides that tiles share, open in the middle of each.
fn walls_between([columns, rows]: [u32; 2], size_m: [f64; 2], doorway_m: f64) -> Vec<Segment> {
    let mut walls = Vec::new();
    // Along y between columns, then along x between rows.
    for (along, lines, tiles) in [(1, columns, rows), (0, rows, columns)] {
        let across = 1 - along;
        let beside_m = (size_m[along] - doorway_m) / 2.0;
        if beside_m < MIN_WALL_LENGTH_M {
            continue;
        }
        for line in 1..lines {
            for tile in 0..tiles {
                let at = |way_m: f64| {
                    let mut place = [0.0; 2];
                    place[across] = size_m[across] * f64::from(line);
                    place[along] = way_m;
                    Point2::from(place)
                };
                let from_m = size_m[along] * f64::from(tile);
                let to_m = size_m[along] * f64::from(tile + 1);
                walls.push(Segment::new(at(from_m), at(from_m + beside_m)));
                walls.push(Segment::new(at(to_m - beside_m), at(to_m)));
            }
        }
    }
    walls
}

#[cfg(test)]
#[path = "tile_tests.rs"]
mod tests;
