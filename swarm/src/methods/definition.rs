//! What a method is: all that the rest of the program asks of it.

use crate::caps::MemoryPlan;
use crate::spec::{FieldError, Method, MethodParameters, Objective, RunSpec, StatesFrom};
use crate::stages::{Phase, Stage};

/// Whether a method trains in an arena of its own before, or while, it explores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trains {
    /// It takes no training arena.
    Never,
    /// It needs one.
    Always,
    /// It needs one where its states come from an evolved phase 1.
    WithPhase1States,
}

impl Trains {
    /// Whether it does with states from there.
    pub fn with(self, states_from: StatesFrom) -> bool {
        match self {
            Self::Never => false,
            Self::Always => true,
            Self::WithPhase1States => states_from == StatesFrom::Phase1,
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Never => "no",
            Self::Always => "yes",
            Self::WithPhase1States => "with states_from \"phase-1\"",
        }
    }
}

/// How robots of a method explore, and with it what they can share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Explores {
    /// They learn nothing, and share nothing.
    Walking,
    /// They evolve all along, and can share genomes by radio.
    Evolving,
    /// By the table of the phase-3 controller, which they can share by radio, or have in common.
    ByTable,
}

impl Explores {
    /// What they can share, in words.
    pub fn shares(self) -> &'static str {
        match self {
            Self::Walking => "nothing",
            Self::Evolving => "genomes",
            Self::ByTable => "tables",
        }
    }
}

/// A method.
pub struct Definition {
    /// Its name in a spec.
    pub method: Method,
    /// What it does.
    pub about: &'static str,
    /// Equation, section or paper.
    pub source: &'static str,
    /// Whether it trains.
    pub trains: Trains,
    /// What its phase 1, or the baseline itself, evolves for; `None` where nothing evolves.
    pub objective: Option<Objective>,
    /// How its robots explore.
    pub explores: Explores,
    /// Parameters that it alone has, with their defaults.
    pub parameters: fn() -> MethodParameters,
    /// What of a spec does not go together, beyond what holds for all methods.
    pub(crate) check: fn(&RunSpec) -> Option<FieldError>,
    /// Its stages, in order.
    pub(crate) stages: fn(&RunSpec, &MemoryPlan) -> Vec<Stage>,
}

/// For methods without parameters of their own.
pub(super) fn no_parameters() -> MethodParameters {
    MethodParameters::default()
}

/// For methods whose parameters go together whatever they are.
pub(super) fn no_check(_spec: &RunSpec) -> Option<FieldError> {
    None
}

/// Epochs of the training arena.
pub(super) fn training_epochs(spec: &RunSpec) -> u32 {
    let training = spec.controller.training.as_ref();
    training.map_or(0, |training| training.epochs)
}

/// The stage in which visits count.
pub(super) fn exploration(spec: &RunSpec) -> Stage {
    Stage::of(spec, Phase::Exploration, spec.epochs)
}

/// For methods that do nothing but explore.
pub(super) fn explore_only(spec: &RunSpec, _plan: &MemoryPlan) -> Vec<Stage> {
    vec![exploration(spec)]
}
