//! Movable objects of a run over time.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An object at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectSample {
    /// Counted steps of the arena that were done.
    pub steps: u64,
    /// The same in simulated seconds.
    pub time_s: f64,
    /// Counted epochs that were complete.
    pub epoch: u32,
    /// Its centre, metres.
    pub x_m: f32,
    /// Its centre, metres.
    pub y_m: f32,
    /// Counter-clockwise from the x axis, above -pi to pi.
    pub heading_rad: f32,
    /// Way that it had been moved while visits counted, metres.
    pub moved_m: f64,
}

/// An object over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectTrack {
    /// `box` or `disc`.
    pub kind: String,
    /// In order of time: where visits begin to count, then where there are rows of metrics.
    pub samples: Vec<ObjectSample>,
}

/// The movable objects of a run over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectTracks {
    /// Version of this format.
    pub schema: u32,
    /// In the order of the arena's; empty where it has none.
    pub objects: Vec<ObjectTrack>,
}
