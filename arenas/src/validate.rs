//! The limits of the arena format, each checked in one place.

use crate::arena::Pose;
use crate::error::ArenaError;

/// Most inner walls of one arena.
pub const MAX_WALLS: usize = 200_000;
/// Most start poses of one arena.
pub const MAX_STARTS: usize = 1_000_000;
/// Shortest and longest side, metres.
pub const SIDE_RANGE_M: [f64; 2] = [0.1, 1000.0];
/// Shortest wall, metres.
pub const MIN_WALL_LENGTH_M: f64 = 1e-6;
/// Fewest and most squares along a side.
pub const SQUARES_RANGE: [u32; 2] = [1, 1000];
/// A wall may leave the rectangle by this much, metres, so that rounded decimals are no error.
pub const WALL_TOLERANCE_M: f64 = 1e-9;
/// Longest name, in characters.
pub const MAX_NAME_LENGTH: usize = 64;

pub(crate) const NAME_ALLOWED: &str =
    "1 to 64 characters of a-z 0-9 . _ -, the first a letter or a digit";
pub(crate) const SIDE_ALLOWED: &str = "0.1 to 1000 (metres)";
pub(crate) const STARTS_ALLOWED: &str = "1 to 1000000 poses {x_m, y_m, heading_rad}";

pub(crate) fn name(name: &str) -> Option<ArenaError> {
    let known = |c: char| matches!(c, 'a'..='z' | '0'..='9' | '.' | '_' | '-');
    let message = if name.is_empty() {
        "the name is empty".to_owned()
    } else if let Some(other) = name.chars().find(|&c| !known(c)) {
        format!("the name has the character {other:?}")
    } else if name.len() > MAX_NAME_LENGTH {
        format!("the name has {} characters", name.len())
    } else if name.starts_with(['.', '_', '-']) {
        format!("the name starts with {:?}", &name[..1])
    } else {
        return None;
    };
    Some(ArenaError::new("/name", message, NAME_ALLOWED))
}

pub(crate) fn side_m(side_m: f64, pointer: &str) -> Result<f64, ArenaError> {
    if (SIDE_RANGE_M[0]..=SIDE_RANGE_M[1]).contains(&side_m) {
        Ok(side_m)
    } else {
        Err(ArenaError::new(
            pointer,
            format!("{side_m} m is out of range"),
            SIDE_ALLOWED,
        ))
    }
}

pub(crate) fn squares(squares: [u32; 2]) -> Option<ArenaError> {
    let [least, most] = SQUARES_RANGE;
    let wrong = squares
        .into_iter()
        .find(|side| !(least..=most).contains(side))?;
    Some(ArenaError::new(
        "/squares",
        format!("{wrong} is out of range"),
        format!("{least} to {most}"),
    ))
}

/// `size_m` is width and height, or `None` if they are wrong themselves.
pub(crate) fn walls(walls_m: &[[f64; 4]], size_m: Option<[f64; 2]>, errors: &mut Vec<ArenaError>) {
    if walls_m.len() > MAX_WALLS {
        errors.push(ArenaError::new(
            "/walls_m",
            format!("{} walls", walls_m.len()),
            format!("at most {MAX_WALLS} walls"),
        ));
        return;
    }
    for (index, wall @ &[x1, y1, x2, y2]) in walls_m.iter().enumerate() {
        let pointer = || format!("/walls_m/{index}");
        let length_m = ((x2 - x1).powi(2) + (y2 - y1).powi(2)).sqrt();
        if !wall.iter().all(|value| value.is_finite()) {
            errors.push(ArenaError::new(
                pointer(),
                "a coordinate is not finite",
                "finite numbers (metres)",
            ));
        } else if size_m.is_some_and(|size_m| {
            !inside([x1, y1], size_m, WALL_TOLERANCE_M)
                || !inside([x2, y2], size_m, WALL_TOLERANCE_M)
        }) {
            errors.push(ArenaError::new(
                pointer(),
                format!("{wall:?} leaves the arena"),
                inside_allowed(size_m),
            ));
        } else if length_m < MIN_WALL_LENGTH_M {
            errors.push(ArenaError::new(
                pointer(),
                format!("the wall is {length_m} m long"),
                format!("at least {MIN_WALL_LENGTH_M} m"),
            ));
        }
    }
}

/// `size_m` is width and height, or `None` if they are wrong themselves.
pub(crate) fn starts(starts: &[Pose], size_m: Option<[f64; 2]>, errors: &mut Vec<ArenaError>) {
    if !(1..=MAX_STARTS).contains(&starts.len()) {
        errors.push(ArenaError::new(
            "/starts",
            format!("{} starts", starts.len()),
            STARTS_ALLOWED,
        ));
        return;
    }
    for (index, start) in starts.iter().enumerate() {
        for (field, value) in [
            ("x_m", start.x_m),
            ("y_m", start.y_m),
            ("heading_rad", start.heading_rad),
        ] {
            if !value.is_finite() {
                errors.push(ArenaError::new(
                    format!("/starts/{index}/{field}"),
                    format!("{value} is not finite"),
                    "a finite number",
                ));
            }
        }
        let place = [start.x_m, start.y_m];
        let finite = place.iter().all(|value| value.is_finite());
        if finite && size_m.is_some_and(|size_m| !inside(place, size_m, 0.0)) {
            errors.push(ArenaError::new(
                format!("/starts/{index}"),
                format!("the start {place:?} is outside the arena"),
                inside_allowed(size_m),
            ));
        }
    }
}

fn inside([x, y]: [f64; 2], [width_m, height_m]: [f64; 2], tolerance_m: f64) -> bool {
    (-tolerance_m..=width_m + tolerance_m).contains(&x)
        && (-tolerance_m..=height_m + tolerance_m).contains(&y)
}

fn inside_allowed(size_m: Option<[f64; 2]>) -> String {
    let [width_m, height_m] = size_m.unwrap_or_default();
    format!("x from 0 to {width_m}, y from 0 to {height_m} (metres)")
}
