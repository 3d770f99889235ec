//! Sensor values as learners see them, alone and with commands.

use serde::{Deserialize, Serialize};

use crate::bodies::Reading;
use crate::dimensions::{PROXIMITY_SENSORS, SENSORI_MOTOR, WHEELS};
use crate::lanes::F8;
use crate::spec::SensorScale;

/// Maps raw sensor values to what learners see.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    factor: f32,
    offset: f32,
}

impl Scaling {
    /// The mapping of a spec: 0 to 4096 becomes -1 to 1 or 0 to 1.
    pub fn new(scale: SensorScale) -> Self {
        match scale {
            SensorScale::Signed => Self {
                factor: 1.0 / 2048.0,
                offset: -1.0,
            },
            SensorScale::Unsigned => Self {
                factor: 1.0 / 4096.0,
                offset: 0.0,
            },
        }
    }

    /// The sensor vector of a reading: its proximity values.
    #[inline(always)]
    pub fn apply(self, reading: &Reading) -> [f32; PROXIMITY_SENSORS] {
        (F8(reading.proximity) * F8::splat(self.factor) + F8::splat(self.offset)).0
    }
}

/// The sensori-motor vector of a sensor vector and the command given in answer to it.
#[inline(always)]
pub fn sensori_motor(
    sensors: &[f32; PROXIMITY_SENSORS],
    command: [f32; WHEELS],
) -> [f32; SENSORI_MOTOR] {
    let s = sensors;
    [
        s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], command[0], command[1],
    ]
}
