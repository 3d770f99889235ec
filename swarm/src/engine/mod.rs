//! The two physics engines: what moves a robot that wants to go somewhere.

pub mod crowd;
pub mod kinematic;
pub mod rapier;

use arenas::Arena;
use serde::{Deserialize, Serialize};

use crate::robot::RobotModel;
use crate::spec::EngineKind;
use crate::world::StartPose;
use rapier::RapierEngine;

/// The engine of one world, with whatever state it keeps between steps.
#[derive(Serialize, Deserialize)]
pub enum Motor {
    /// Stateless: positions are all there is.
    Kinematic,
    /// Rigid bodies.
    Rapier(Box<RapierEngine>),
}

impl Motor {
    /// The engine of a kind for robots at their start poses.
    pub fn new(kind: EngineKind, arena: &Arena, model: &RobotModel, starts: &[StartPose]) -> Self {
        match kind {
            EngineKind::Kinematic => Motor::Kinematic,
            EngineKind::Rapier => {
                let x_m: Vec<f32> = starts.iter().map(|s| s.x_m).collect();
                let y_m: Vec<f32> = starts.iter().map(|s| s.y_m).collect();
                Motor::Rapier(Box::new(RapierEngine::new(arena, model, &x_m, &y_m)))
            }
        }
    }

    /// Puts robots elsewhere at once, without any memory of earlier contacts.
    pub fn place(&mut self, x_m: &[f32], y_m: &[f32]) {
        if let Motor::Rapier(engine) = self {
            engine.place(x_m, y_m);
        }
    }
}
