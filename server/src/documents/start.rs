//! The field `start`: where the first robot stands, in place of the arenas' own first start pose.

use std::sync::Arc;

use api::StartSpec;
use arenas::{Arena, Pose};
use serde_json::Value;

use super::fields::{Errors, Object, kind};

/// Farthest that a place may be from the corner, metres.
pub(super) const MOST_M: f64 = 1e6;
/// Farthest that a heading may be from zero, radians.
pub(super) const MOST_RAD: f64 = 1_000.0;

/// A start pose as far as it is given.
pub struct Start {
    shown: StartSpec,
    pointer: String,
}

impl Start {
    /// Reads `start`; `None` where the arenas' own is to be kept.
    pub fn read(spec: &Object<'_>, errors: &mut Errors) -> Option<Self> {
        let value = spec.get("start").filter(|value| !value.is_null())?;
        let pointer = spec.pointer("start");
        let object = Object::open(value, &pointer, ["x_m", "y_m", "heading_rad"], errors)?;
        let mut number = |name: &str, most: f64, least: f64| {
            let value = object.get(name)?;
            let number = value.as_f64().filter(|x| (least..=most).contains(x));
            if number.is_none() {
                let message = match value {
                    Value::Number(number) => format!("{number} is out of range"),
                    _ => format!("must be a number, not {}", kind(value)),
                };
                let allowed = format!("a number from {least} to {most}");
                errors.add(object.pointer(name), message, allowed);
            }
            number
        };
        let shown = StartSpec {
            x_m: number("x_m", MOST_M, 0.0),
            y_m: number("y_m", MOST_M, 0.0),
            heading_rad: number("heading_rad", MOST_RAD, -MOST_RAD),
        };
        Some(Self { shown, pointer })
    }

    /// How it is shown.
    pub fn shown(&self) -> StartSpec {
        self.shown
    }

    /// The arena with this start; what is not given stays as the arena has it.
    pub fn put_into(&self, arena: &Arc<Arena>, errors: &mut Errors) -> Arc<Arena> {
        let own = arena.starts()[0];
        let start = Pose {
            x_m: self.shown.x_m.unwrap_or(own.x_m),
            y_m: self.shown.y_m.unwrap_or(own.y_m),
            heading_rad: self.shown.heading_rad.unwrap_or(own.heading_rad),
        };
        if start.x_m > arena.width_m() || start.y_m > arena.height_m() {
            errors.add(
                self.pointer.clone(),
                format!("it is outside the arena {}", arena.name()),
                format!(
                    "x_m up to {}, y_m up to {}",
                    arena.width_m(),
                    arena.height_m()
                ),
            );
            return Arc::clone(arena);
        }
        if start == own {
            return Arc::clone(arena);
        }
        Arc::new(Arena::clone(arena).with_first_start(start))
    }
}
