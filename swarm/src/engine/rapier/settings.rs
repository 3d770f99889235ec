//! How bodies are made and steps of the solver taken, from a robot model.

use rapier2d::prelude::*;
use serde::{Deserialize, Serialize};

use crate::robot::RobotModel;

/// Substeps of the solver in one step; with fewer, discs sink into wedges.
const SOLVER_ITERATIONS: usize = 4;

/// rapier's `length_unit` of a body with a radius of one metre: 0.1 for an e-puck. It scales the
/// margins of the broad phase and the cap on speed.
const LENGTH_UNIT_PER_RADIUS: f64 = 0.1 / 0.037;

/// Contacts exist from this many steps at top speed on. Two robots that meet close in by two steps
/// at once, and a contact that is not known before it is reached comes too late.
const PREDICTION_STEPS: f64 = 2.1;

/// Longest way that one solver step may take a body, in radii: a disc must not change sides of a
/// wall before the contact turns it back. Steps of faster robots are cut into equal parts.
const LONGEST_PART_RADII: f64 = 0.5;

/// Steps below this many radii leave the contact margin as it is, so that it is never zero.
const SHORTEST_PART_RADII: f64 = 0.05;

/// A body that went farther than twice the longest part and this many radii broke the laws of
/// motion and is put back.
const TRAVEL_SLACK_RADII: f64 = 0.1;

/// No body may go this many radii in one part, whatever pushes it.
const MOST_TRAVEL_RADII: f64 = 0.9;

/// What the bodies are made of and how steps are taken; fixed for the life of an engine.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Settings {
    pub radius_m: f32,
    pub mass_kg: f32,
    pub friction: f32,
    pub bounce: f32,
    /// Solver steps in a control step.
    pub parts: u32,
    pub part_s: f32,
    /// Longest way at top speed in one part.
    pub part_m: f32,
    /// Ways beyond this are undone.
    pub travel_limit_m: f32,
}

impl Settings {
    pub fn new(model: &RobotModel) -> Self {
        let p = &model.parameters;
        let radius_m = p.body_radius_m;
        let step_m = model.max_step_m();
        let parts = (step_m / (LONGEST_PART_RADII * radius_m)).ceil().max(1.0);
        let part_m = (step_m / parts).max(SHORTEST_PART_RADII * radius_m);
        let travel_m = 2.0 * part_m + TRAVEL_SLACK_RADII * radius_m;
        Self {
            radius_m: radius_m as f32,
            mass_kg: p.mass_kg as f32,
            friction: p.contact_friction as f32,
            bounce: p.contact_bounce as f32,
            parts: parts as u32,
            part_s: (p.step_s / parts) as f32,
            part_m: part_m as f32,
            travel_limit_m: travel_m.min(MOST_TRAVEL_RADII * radius_m) as f32,
        }
    }

    pub fn integration(&self) -> IntegrationParameters {
        let length_unit = (f64::from(self.radius_m) * LENGTH_UNIT_PER_RADIUS) as f32;
        IntegrationParameters {
            dt: self.part_s,
            length_unit,
            normalized_prediction_distance: PREDICTION_STEPS as f32 * self.part_m / length_unit,
            // Bodies that overlap leave each other no faster than robots drive.
            normalized_max_corrective_velocity: self.part_m / self.part_s / length_unit,
            num_solver_iterations: SOLVER_ITERATIONS,
            // Recycled contacts keep their normal over a way that is long for a small robot, which
            // would then hang on the ends of walls.
            contact_recycling: false,
            ..IntegrationParameters::default()
        }
    }

    pub fn surface(&self, shape: ColliderBuilder) -> ColliderBuilder {
        shape
            .friction(self.friction)
            .friction_combine_rule(CoefficientCombineRule::Max)
            .restitution(0.0)
    }
}
