//! Ev-ITER: evolution (phase 1), its archive replayed into a table (phase 2), then exploration by
//! that table (phase 3). The variants differ in what phase 1 evolves for.

use super::definition::{
    Definition, Explores, Trains, exploration, no_check, no_parameters, training_epochs,
};
use crate::caps::MemoryPlan;
use crate::spec::{Method, Objective, RunSpec};
use crate::stages::{Phase, Stage};

pub(super) static EV_ITER_C: Definition = variant(
    Method::EvIterC,
    Objective::Curiosity,
    "Ev-ITER after a phase 1 of curiosity",
);
pub(super) static EV_ITER_D: Definition = variant(
    Method::EvIterD,
    Objective::Discovery,
    "Ev-ITER after a phase 1 of discovery",
);
pub(super) static EV_ITER_CA: Definition = variant(
    Method::EvIterCa,
    Objective::CuriosityA,
    "Ev-ITER after a phase 1 of curiosity-a",
);
pub(super) static EV_ITER_DA: Definition = variant(
    Method::EvIterDa,
    Objective::DiscoveryA,
    "Ev-ITER after a phase 1 of discovery-a",
);

const fn variant(method: Method, objective: Objective, about: &'static str) -> Definition {
    Definition {
        method,
        about,
        source: "chapter 4, Alg. 5",
        trains: Trains::Always,
        objective: Some(objective),
        explores: Explores::ByTable,
        parameters: no_parameters,
        check: no_check,
        stages,
    }
}

fn stages(spec: &RunSpec, plan: &MemoryPlan) -> Vec<Stage> {
    let trained = training_epochs(spec);
    vec![
        Stage::of(spec, Phase::Evolution, trained),
        Stage::of(spec, Phase::Repository, trained.min(plan.genomes)),
        exploration(spec),
    ]
}
