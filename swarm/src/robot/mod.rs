//! The robot: body, wheels and proximity sensors, as parameters with presets.

#![allow(
    clippy::approx_constant,
    reason = "figures as the data sheet gives them"
)]

pub mod response;

use serde::{Deserialize, Serialize};

use crate::dimensions::PROXIMITY_SENSORS;
use crate::parameters::Domain::Real;
use crate::parameters::{named_choice, parameter_table};
use response::SensorResponse;

named_choice! {
    /// A named set of robot parameters.
    Preset {
        /// The Webots 7 e-puck, which the thesis used.
        Thesis = "thesis",
        /// The e-puck of Webots from 2022 on: other sensor response.
        Webots2022 = "webots-2022",
        /// The e-puck 2: faster wheels, lighter, otherwise `webots-2022`.
        EPuck2 = "epuck2",
        /// `thesis` with the wheels and contact that one change at a time had found: the defaults up to
        /// version 2 of results.
        Stepwise = "stepwise",
        /// `stepwise` under Webots's kinematics mode as the table of its manual has it: robots slide
        /// along walls. (Of the two modes it alone limits the wheels' acceleration.)
        WebotsSliding = "webots-sliding",
        /// The same as the manual's text has it: walls are so rough that nothing slides.
        WebotsRough = "webots-rough",
    }
}

parameter_table! {
    /// Parameters of the robot (`robot` of a run spec), of the `thesis` preset by default.
    RobotParameters {
        body_radius_m: f64 = 0.037, Real { min: 0.005, max: 1.0 }, "m", "Radius of the disc-shaped body", "Webots 7 EPuck.proto";
        mass_kg: f64 = 0.15, Real { min: 0.001, max: 100.0 }, "kg", "Mass (rapier engine)", "Webots 7 EPuck.proto";
        inertia_kg_m2: f64 = 9.786e-5, Real { min: 1e-9, max: 100.0 }, "kg m2", "Vertical inertia (rapier engine)", "Webots 7 EPuck.proto";
        wheel_radius_m: f64 = 0.0205, Real { min: 0.001, max: 0.5 }, "m", "Wheel radius", "Webots 7 EPuck.proto";
        axle_m: f64 = 0.052, Real { min: 0.005, max: 2.0 }, "m", "Distance between the wheels", "Webots 7 EPuck.proto";
        max_wheel_speed_rad_s: f64 = 6.28, Real { min: 0.0, max: 1_000.0 }, "rad/s", "Top wheel speed, reached at command 1", "1000 ticks/s";
        max_wheel_acceleration_rad_s2: f64 = 20.0, Real { min: 0.0, max: 1e6 }, "rad/s2", "Limit of the wheels' acceleration; 0 means none", "docs/reproduction.md (Webots DifferentialWheels: 10)";
        wheel_slip: f64 = 0.1, Real { min: 0.0, max: 1.0 }, "1", "Uniform relative noise on each wheel's speed, plus or minus", "Webots DifferentialWheels (slipNoise)";
        contact_friction: f64 = 0.2, Real { min: 0.0, max: 100.0 }, "1", "Coulomb friction against walls and robots", "docs/reproduction.md (Webots ContactProperties: 1)";
        contact_bounce: f64 = 0.5, Real { min: 0.0, max: 1.0 }, "1", "Restitution against walls and robots", "Webots ContactProperties";
        step_s: f64 = 0.064, Real { min: 0.001, max: 1.0 }, "s", "Control step", "Webots basic time step";
        sensor_noise: f64 = 1.0, Real { min: 0.0, max: 10.0 }, "1", "Factor on the sensors' standard deviation; 0 turns noise off", "option";
        ray_stretch: f64 = 1.013_05, Real { min: 1.0, max: 2.0 }, "1", "Length of a sensor's ray for each metre that it covers over the ground; 1 means level rays", "inferred: the one factor that gives all nine figures of the specification's hand check";
        sensor_gain: f64 = 1.0, Real { min: 0.0, max: 10.0 }, "1", "Factor on every sensor value before clamping", "option";
    }
}

/// Where a sensor sits on the body: x forward, y left, angle counter-clockwise from the heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorMount {
    /// Metres ahead of the axle's middle.
    pub x_m: f64,
    /// Metres to the left.
    pub y_m: f64,
    /// Direction of the ray.
    pub heading_rad: f64,
}

const fn mount(x_m: f64, y_m: f64, heading_rad: f64) -> SensorMount {
    SensorMount {
        x_m,
        y_m,
        heading_rad,
    }
}

/// ps0 to ps7 of the e-puck (Webots EPuck.proto).
pub const E_PUCK_MOUNTS: [SensorMount; PROXIMITY_SENSORS] = [
    mount(0.030, -0.010, -0.3008),
    mount(0.022, -0.025, -0.8008),
    mount(0.000, -0.031, -1.5708),
    mount(-0.030, -0.015, -2.6440),
    mount(-0.030, 0.015, 2.6392),
    mount(0.000, 0.031, 1.5708),
    mount(0.022, 0.025, 0.7992),
    mount(0.030, 0.010, 0.2992),
];

/// A robot, complete: parameters, sensor mounts and sensor response.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotModel {
    /// The preset it started from.
    pub preset: Preset,
    /// Body, wheels and options.
    pub parameters: RobotParameters,
    /// The eight sensors.
    pub mounts: [SensorMount; PROXIMITY_SENSORS],
    /// Distance to value and noise.
    pub response: SensorResponse,
}

impl Default for RobotModel {
    fn default() -> Self {
        Self::preset(Preset::Thesis)
    }
}

impl RobotModel {
    /// The robot of a preset.
    pub fn preset(preset: Preset) -> Self {
        let mut parameters = RobotParameters::default();
        if preset == Preset::EPuck2 {
            parameters.max_wheel_speed_rad_s = 7.536;
            parameters.mass_kg = 0.13;
        }
        let friction = match preset {
            Preset::Thesis | Preset::Webots2022 | Preset::EPuck2 => None,
            Preset::Stepwise => Some(1.0),
            Preset::WebotsSliding => Some(0.0),
            Preset::WebotsRough => Some(100.0),
        };
        if let Some(friction) = friction {
            parameters.contact_friction = friction;
            parameters.contact_bounce = 0.0;
            parameters.max_wheel_acceleration_rad_s2 = 10.0;
            parameters.wheel_slip = 0.0;
        }
        let response = match preset {
            Preset::Webots2022 | Preset::EPuck2 => SensorResponse::webots_2022(),
            _ => SensorResponse::thesis(),
        };
        Self {
            preset,
            parameters,
            mounts: E_PUCK_MOUNTS,
            response,
        }
    }

    /// Distance that a robot covers in one step at top speed.
    pub fn max_step_m(&self) -> f64 {
        let p = &self.parameters;
        p.max_wheel_speed_rad_s * (1.0 + p.wheel_slip) * p.wheel_radius_m * p.step_s
    }

    /// Largest turn in one step (wheels at opposite top speeds).
    pub fn max_turn_rad(&self) -> f64 {
        2.0 * self.max_step_m() / self.parameters.axle_m
    }

    /// Distance from the body's centre that the farthest ray can reach.
    pub fn sensor_reach_m(&self) -> f64 {
        let range = self.response.range_m() / self.parameters.ray_stretch;
        self.mounts
            .iter()
            .map(|m| {
                let (s, c) = (libm::sin(m.heading_rad), libm::cos(m.heading_rad));
                libm::hypot(m.x_m + range * c, m.y_m + range * s)
            })
            .fold(0.0, f64::max)
    }
}
