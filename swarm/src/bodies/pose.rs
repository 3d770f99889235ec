//! Where robots begin and where movable objects are.

use arenas::Movable;
use serde::{Deserialize, Serialize};

/// A start pose as the step loop wants it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartPose {
    /// Metres.
    pub x_m: f32,
    /// Metres.
    pub y_m: f32,
    /// Cosine of the heading.
    pub cos: f32,
    /// Sine of the heading.
    pub sin: f32,
}

/// Where an object is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectPose {
    /// Centre, metres.
    pub x_m: f32,
    /// Centre, metres.
    pub y_m: f32,
    /// Cosine of the heading.
    pub cos: f32,
    /// Sine of the heading.
    pub sin: f32,
}

impl ObjectPose {
    /// The pose at which an object begins.
    pub fn of(object: &Movable) -> Self {
        let centre = object.centre();
        Self {
            x_m: centre.x as f32,
            y_m: centre.y as f32,
            cos: libm::cos(object.heading_rad()) as f32,
            sin: libm::sin(object.heading_rad()) as f32,
        }
    }
}
