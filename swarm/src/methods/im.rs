//! Intrinsic motivation: Ev-ITER's phase 3 that begins with an empty table.

use super::definition::{
    Definition, Explores, Trains, exploration, no_check, no_parameters, training_epochs,
};
use crate::caps::MemoryPlan;
use crate::spec::{Method, RunSpec, StatesFrom};
use crate::stages::{Phase, Stage};

pub(super) static IM: Definition = Definition {
    method: Method::Im,
    about: "Intrinsic motivation: the phase-3 controller with an empty repository",
    source: "chapter 5, Alg. 5",
    trains: Trains::WithPhase1States,
    objective: None,
    explores: Explores::ByTable,
    parameters: no_parameters,
    check: no_check,
    stages,
};

fn stages(spec: &RunSpec, _plan: &MemoryPlan) -> Vec<Stage> {
    let parameters = &spec.controller.parameters;
    let (phase, epochs) = match parameters.states_from {
        StatesFrom::Babbling => (Phase::Babbling, parameters.babbling_epochs),
        StatesFrom::Phase1 => (Phase::Evolution, training_epochs(spec)),
    };
    vec![Stage::of(spec, phase, epochs), exploration(spec)]
}
