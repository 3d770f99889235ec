//! One robot's state.

use serde::{Deserialize, Serialize};

use super::pose::StartPose;
use super::reading::Reading;
use crate::dimensions::WHEELS;

/// A robot in its arena.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C, align(32))]
pub struct Body {
    /// What its sensors read last.
    pub reading: Reading,
    /// Centre, metres.
    pub x_m: f32,
    /// Centre, metres.
    pub y_m: f32,
    /// Cosine of the heading.
    pub cos: f32,
    /// Sine of the heading.
    pub sin: f32,
    /// Wheel speeds, left and right, rad/s.
    pub wheels_rad_s: [f32; WHEELS],
    /// Last wheel commands, left and right, -1 to 1.
    pub command: [f32; WHEELS],
    /// Square that the centre is in.
    pub(crate) square: u32,
    /// Whether the last move met a wall or robot.
    #[serde(skip)]
    pub(crate) touched: bool,
    /// Centre before the move, metres.
    #[serde(skip)]
    pub(crate) from_m: [f32; 2],
    /// Way driven while visits counted, metres.
    pub distance_m: f64,
    /// Squares that this robot was the first to enter.
    pub first_entries: u32,
}

impl Body {
    /// A robot that has not moved.
    pub fn at_rest(start: &StartPose) -> Self {
        Self {
            reading: Reading::default(),
            x_m: start.x_m,
            y_m: start.y_m,
            cos: start.cos,
            sin: start.sin,
            wheels_rad_s: [0.0; WHEELS],
            command: [0.0; WHEELS],
            square: 0,
            touched: false,
            from_m: [start.x_m, start.y_m],
            distance_m: 0.0,
            first_entries: 0,
        }
    }

    /// Puts the robot at a start pose at rest; what was counted of it stays.
    pub(crate) fn put_back(&mut self, start: &StartPose) {
        *self = Self {
            distance_m: self.distance_m,
            first_entries: self.first_entries,
            ..Self::at_rest(start)
        };
    }
}
