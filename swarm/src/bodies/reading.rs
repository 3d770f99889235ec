//! What a robot's sensors read at one moment: all that a controller learns of the world.

use serde::{Deserialize, Serialize};

use crate::dimensions::PROXIMITY_SENSORS;

/// One robot's sensor values, a field for each kind of sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct Reading {
    /// Raw values of the proximity sensors ps0 to ps7, 0 to 4095; greater is nearer.
    pub proximity: [f32; PROXIMITY_SENSORS],
}
