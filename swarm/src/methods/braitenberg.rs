//! A Braitenberg vehicle: each wheel's speed is a weighted sum of what the sensors read. The weights
//! are those of the e-puck in Webots's example controller `braitenberg.c`.

use serde::{Deserialize, Serialize};

use super::definition::{Definition, Explores, Trains, explore_only, no_check};
use super::walker::Walker;
use crate::bodies::Reading;
use crate::controllers::Controller;
use crate::dimensions::{PROXIMITY_SENSORS, WHEELS};
use crate::parameters::Domain::Real;
use crate::parameters::parameter_table;
use crate::spec::{Method, MethodParameters, RunSpec};

pub(super) static BRAITENBERG: Definition = Definition {
    method: Method::Braitenberg,
    about: "Braitenberg vehicle: turns away from what its sensors read, straight on where that is nothing",
    source: "Braitenberg, Vehicles (1984); weights of Webots's e-puck in braitenberg.c",
    trains: Trains::Never,
    objective: None,
    explores: Explores::Walking,
    parameters: || {
        MethodParameters::new(
            BraitenbergParameters::TABLE,
            BraitenbergParameters::default().shown(),
        )
    },
    check: no_check,
    stages: explore_only,
};

parameter_table! {
    /// Parameters of the method `braitenberg`.
    BraitenbergParameters {
        gain: f64 = 0.5, Real { min: 0.0, max: 100.0 }, "1", "Command for a weighted sum of 1", "free space gives 0.73 and 0.77 of the top speed";
        range: f64 = 512.0, Real { min: 1.0, max: 4_095.0 }, "1", "Raw value at which a sensor's part is 0; it is negative above", "braitenberg.c";
    }
}

/// What ps0 to ps7 add to the left and to the right wheel.
pub const WEIGHTS: [[f32; WHEELS]; PROXIMITY_SENSORS] = [
    [0.942, -0.22],
    [0.63, -0.1],
    [0.5, -0.06],
    [-0.06, -0.06],
    [-0.06, -0.06],
    [-0.06, 0.5],
    [-0.19, 0.63],
    [-0.13, 0.942],
];

/// A vehicle.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Braitenberg {
    gain: f32,
    range: f32,
}

impl Braitenberg {
    /// The command for a reading: single precision, sensors in their order.
    #[inline(always)]
    fn command(&self, reading: &Reading) -> [f32; WHEELS] {
        let mut sum = [0.0_f32; WHEELS];
        for (weights, value) in WEIGHTS.iter().zip(&reading.proximity) {
            let part = 1.0 - value / self.range;
            for (sum, weight) in sum.iter_mut().zip(weights) {
                *sum += weight * part;
            }
        }
        sum.map(|sum| (self.gain * sum).clamp(-1.0, 1.0))
    }
}

impl Walker for Braitenberg {
    fn new(spec: &RunSpec, _key: u64) -> Self {
        let mut parameters = BraitenbergParameters::default();
        let own = &spec.controller.own;
        own.hand_to(|name, value| parameters.set(name, value));
        Self {
            gain: parameters.gain as f32,
            range: parameters.range as f32,
        }
    }
}

impl Controller for Braitenberg {
    #[inline(always)]
    fn act(&mut self, _step: u64, reading: &Reading) -> [f32; WHEELS] {
        self.command(reading)
    }

    #[inline(always)]
    fn learn(&mut self, _reading: &Reading) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_ahead_turns_it_away_and_nothing_lets_it_drive_on() {
        let vehicle = Braitenberg {
            gain: 0.5,
            range: 512.0,
        };
        let command = |proximity| vehicle.command(&Reading { proximity });
        let [left, right] = command([0.0; PROXIMITY_SENSORS]);
        assert!((left - right).abs() < 0.1 && left > 0.7 && right > 0.7);
        // ps0 to ps2 look to the right, ps5 to ps7 to the left.
        let mut beside = [34.0; PROXIMITY_SENSORS];
        beside[0] = 1_500.0;
        beside[1] = 1_500.0;
        let [left, right] = command(beside);
        assert!(left < right, "to the left: {left} {right}");
        beside.reverse();
        let [left, right] = command(beside);
        assert!(left > right, "to the right: {left} {right}");
        assert_eq!(command([4_095.0; PROXIMITY_SENSORS]), [-1.0, -1.0]);
    }
}
