//! The JSON format of an arena, and the one way from it to a valid [`Arena`].

use nalgebra::Point2;
use serde::{Deserialize, Serialize};

use crate::arena::{Arena, Pose};
use crate::error::{ArenaError, json_pointer};
use crate::generate::{GenerateFormat, Generated};
use crate::objects::{self, Movable};
use crate::segment::Segment;
use crate::validate;

/// Squares along each side if the arena does not say.
pub const DEFAULT_SQUARES: u32 = 100;

/// How many squares an arena has: along each side, or in a row and in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "a whole number of squares along each side, or [columns, rows]"
)]
pub enum SquaresFormat {
    /// As many in a row as in a column.
    Side(u32),
    /// Columns and rows.
    Sides([u32; 2]),
}

impl SquaresFormat {
    /// Columns and rows.
    pub fn sides(self) -> [u32; 2] {
        match self {
            Self::Side(side) => [side, side],
            Self::Sides(sides) => sides,
        }
    }
}

impl From<[u32; 2]> for SquaresFormat {
    fn from(sides: [u32; 2]) -> Self {
        if sides[0] == sides[1] {
            Self::Side(sides[0])
        } else {
            Self::Sides(sides)
        }
    }
}

/// An arena as written: in a file, an upload or inline in a run.
///
/// Every field is optional here so that [`ArenaFormat::build`] can report all that is missing or
/// wrong at once. Needed are `name`, `width_m`, `height_m` and either `walls_m` with `starts` or
/// `generate` (which supplies what of `name` and `starts` is left out).
///
/// ```
/// let arena = arenas::Arena::from_json(r#"{
///     "name": "two-rooms", "width_m": 0.6, "height_m": 0.6,
///     "walls_m": [[0.3, 0.0, 0.3, 0.4]],
///     "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.0 }]
/// }"#).unwrap();
/// assert_eq!(arena.walls().len(), 1);
/// assert_eq!(arena.squares(), [100, 100]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArenaFormat {
    /// 1 to 64 characters of `a-z 0-9 . _ -`, the first a letter or a digit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Extent along x, metres, 0.1 to 1000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_m: Option<f64>,
    /// Extent along y, metres, 0.1 to 1000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
    /// Squares along each side, or [columns, rows], 1 to 1000; 100 if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub squares: Option<SquaresFormat>,
    /// Inner walls: x1, y1, x2, y2 in metres from the lower left corner, y up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walls_m: Option<Vec<[f64; 4]>>,
    /// How to make the walls, in place of `walls_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub generate: Option<GenerateFormat>,
    /// Start poses, the first for the first robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub starts: Option<Vec<Pose>>,
    /// Boxes and discs that robots can push.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<Movable>,
}

impl ArenaFormat {
    /// Checks every field and builds the arena; generated walls become plain walls.
    ///
    /// # Errors
    /// All wrong fields at once, in the order of the format's fields. What depends on the robot's
    /// size is apart: [`Arena::check_starts`].
    pub fn build(self) -> Result<Arena, Vec<ArenaError>> {
        let mut errors = Vec::new();
        if let Some(name) = &self.name {
            errors.extend(validate::name(name));
        } else if self.generate.is_none() {
            errors.push(required("/name", validate::NAME_ALLOWED));
        }
        let width_m = side_m(self.width_m, "/width_m", &mut errors);
        let height_m = side_m(self.height_m, "/height_m", &mut errors);
        let size_m = width_m
            .zip(height_m)
            .map(|(width_m, height_m)| [width_m, height_m]);
        let squares = self
            .squares
            .map_or([DEFAULT_SQUARES; 2], SquaresFormat::sides);
        errors.extend(validate::squares(squares));

        let mut generator = None;
        match (&self.walls_m, &self.generate) {
            (Some(walls_m), None) => validate::walls(walls_m, size_m, &mut errors),
            (None, Some(generate)) => match generate.resolve(size_m) {
                Ok(resolved) => generator = Some(resolved),
                Err(wrong) => errors.extend(wrong),
            },
            (Some(_), Some(_)) => errors.push(ArenaError::new(
                "/generate",
                "the arena has walls_m too",
                "either walls_m or generate",
            )),
            (None, None) => errors.push(required(
                "/walls_m",
                "either walls_m (it may be []) or generate",
            )),
        }
        match &self.starts {
            Some(starts) => validate::starts(starts, size_m, &mut errors),
            None if self.generate.is_none() => {
                errors.push(required("/starts", validate::STARTS_ALLOWED));
            }
            None => {}
        }
        let size_m = match size_m {
            Some(size_m) if errors.is_empty() => size_m,
            _ => return Err(errors),
        };

        let (walls, starts, name) = match generator {
            Some(generator) => {
                let Generated { walls, start } = generator
                    .run(size_m, self.starts.as_deref())
                    .map_err(|error| vec![error])?;
                let name = self.name.unwrap_or_else(|| generator.name());
                (walls, self.starts.unwrap_or_else(|| vec![start]), name)
            }
            None => (
                self.walls_m
                    .unwrap_or_default()
                    .iter()
                    .map(segment)
                    .collect(),
                self.starts.unwrap_or_default(),
                self.name.unwrap_or_default(),
            ),
        };
        objects::check(&self.objects, size_m, &walls, &mut errors);
        if !errors.is_empty() {
            return Err(errors);
        }
        Ok(Arena::from_checked(
            name,
            size_m,
            walls,
            starts,
            squares,
            self.objects,
        ))
    }
}

impl Arena {
    /// Reads and checks an arena.
    ///
    /// # Errors
    /// One error if the text is not JSON or a value has the wrong type, else all wrong fields.
    pub fn from_json(json: &str) -> Result<Self, Vec<ArenaError>> {
        let mut deserializer = serde_json::Deserializer::from_str(json);
        let format: ArenaFormat = serde_path_to_error::deserialize(&mut deserializer)
            .map_err(|error| vec![not_the_format(json_pointer(error.path()), error.inner())])?;
        deserializer
            .end()
            .map_err(|error| vec![not_the_format(String::new(), &error)])?;
        format.build()
    }

    /// The arena as it would be written; building it again gives an equal arena.
    pub fn to_format(&self) -> ArenaFormat {
        ArenaFormat {
            name: Some(self.name().to_owned()),
            width_m: Some(self.width_m()),
            height_m: Some(self.height_m()),
            squares: Some(self.squares().into()),
            walls_m: Some(
                self.walls()
                    .iter()
                    .map(|wall| [wall.a.x, wall.a.y, wall.b.x, wall.b.y])
                    .collect(),
            ),
            generate: None,
            starts: Some(self.starts().to_vec()),
            objects: self.objects().to_vec(),
        }
    }
}

fn segment([x1, y1, x2, y2]: &[f64; 4]) -> Segment {
    Segment::new(Point2::new(*x1, *y1), Point2::new(*x2, *y2))
}

fn required(pointer: &str, allowed: &str) -> ArenaError {
    ArenaError::new(pointer, "missing", allowed)
}

fn side_m(side_m: Option<f64>, pointer: &str, errors: &mut Vec<ArenaError>) -> Option<f64> {
    match side_m.map(|side_m| validate::side_m(side_m, pointer)) {
        Some(Ok(side_m)) => Some(side_m),
        Some(Err(error)) => {
            errors.push(error);
            None
        }
        None => {
            errors.push(required(pointer, validate::SIDE_ALLOWED));
            None
        }
    }
}

fn not_the_format(pointer: String, error: &serde_json::Error) -> ArenaError {
    ArenaError::new(
        pointer,
        error.to_string(),
        "an object with name, width_m, height_m, squares, walls_m or generate, starts, objects",
    )
}

#[cfg(test)]
#[path = "format_tests.rs"]
mod tests;
