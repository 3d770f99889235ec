//! The evolved baselines: robots that evolve all along, each for another objective.

use super::definition::{Definition, Explores, Trains, exploration, no_check, no_parameters};
use crate::caps::MemoryPlan;
use crate::random::Site;
use crate::spec::{Method, Objective, RunSpec};
use crate::stages::Stage;

pub(super) static CURIOSITY: Definition = baseline(
    Method::Curiosity,
    Objective::Curiosity,
    "Evolved for the entropy of sensori-motor data (eq. 4.5)",
    "eq. 4.5",
);
pub(super) static CURIOSITY_A: Definition = baseline(
    Method::CuriosityA,
    Objective::CuriosityA,
    "Evolved for the entropy of actuator data (eq. 4.5)",
    "eq. 4.5",
);
pub(super) static DISCOVERY: Definition = baseline(
    Method::Discovery,
    Objective::Discovery,
    "Evolved for the differential entropy of sensori-motor data (eq. 4.6)",
    "eq. 4.6",
);
pub(super) static DISCOVERY_A: Definition = baseline(
    Method::DiscoveryA,
    Objective::DiscoveryA,
    "Evolved for the differential entropy of actuator data (eq. 4.6)",
    "eq. 4.6",
);

const fn baseline(
    method: Method,
    objective: Objective,
    about: &'static str,
    source: &'static str,
) -> Definition {
    Definition {
        method,
        about,
        source,
        trains: Trains::Always,
        objective: Some(objective),
        explores: Explores::Evolving,
        parameters: no_parameters,
        check: no_check,
        stages,
    }
}

/// Where it trains elsewhere, each candidate is evaluated there and shown in the target arena.
fn stages(spec: &RunSpec, _plan: &MemoryPlan) -> Vec<Stage> {
    let training = spec.controller.training.as_ref();
    let elsewhere = training.is_some_and(|training| *training.arena != *spec.arena);
    let site = if elsewhere {
        Site::Training
    } else {
        Site::Target
    };
    vec![Stage {
        site,
        shows: elsewhere,
        ..exploration(spec)
    }]
}
