//! Robots that a program outside the simulator steers: before every step it is told what they read,
//! and says what each is to do.

use serde::{Deserialize, Serialize};

use super::definition::{Definition, Explores, Trains, explore_only, no_check};
use super::walker::Walker;
use crate::bodies::Reading;
use crate::controllers::Controller;
use crate::dimensions::WHEELS;
use crate::engine::drive::to_tick;
use crate::learn::are_sound;
use crate::parameters::Domain::Whole;
use crate::parameters::parameter_table;
use crate::spec::{Method, MethodParameters, RunSpec};

pub(super) static EXTERNAL: Definition = Definition {
    method: Method::External,
    about: "A program of one's own on the same machine decides, in step with the simulation",
    source: "docs/controllers.md",
    trains: Trains::Never,
    objective: None,
    explores: Explores::Walking,
    parameters: || {
        MethodParameters::new(
            ExternalParameters::TABLE,
            ExternalParameters::default().shown(),
        )
    },
    check: no_check,
    stages: explore_only,
};

parameter_table! {
    /// Parameters of the method `external`.
    ExternalParameters {
        deadline_ms: u32 = 100, Whole { min: 1, max: 600_000 }, "ms", "Longest time that an answer may take; then the run pauses until a controller is back", "a robot's control step is 64 ms";
        controllers: u32 = 1, Whole { min: 1, max: 64 }, "programs", "Programs that share the robots: each has a range of their numbers", "bounded connections";
    }
}

impl ExternalParameters {
    /// Of a spec of this method.
    pub fn of(spec: &RunSpec) -> Self {
        let mut parameters = Self::default();
        let own = &spec.controller.own;
        own.hand_to(|name, value| parameters.set(name, value));
        parameters
    }
}

/// A robot that does what it was told last.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct External {
    command: [f32; WHEELS],
}

impl External {
    /// What it does from now on. Rounded to ticks, as wheels are driven by them: so whatever is
    /// recorded in ticks says exactly what was told.
    pub fn steer(&mut self, command: [f32; WHEELS]) {
        self.command = command.map(to_tick);
    }
}

impl Walker for External {
    fn new(_spec: &RunSpec, _key: u64) -> Self {
        Self {
            command: [0.0; WHEELS],
        }
    }

    fn is_sound(&self) -> bool {
        are_sound(&self.command)
    }
}

impl Controller for External {
    #[inline(always)]
    fn act(&mut self, _step: u64, _reading: &Reading) -> [f32; WHEELS] {
        self.command
    }

    #[inline(always)]
    fn learn(&mut self, _reading: &Reading) {}
}
