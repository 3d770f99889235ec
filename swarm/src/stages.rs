//! The stages that a method goes through, and how many epochs each takes.

use crate::caps::MemoryPlan;
use crate::parameters::named_choice;
use crate::random::Site;
use crate::spec::{Method, RunSpec, StatesFrom};

named_choice! {
    /// What a run is doing.
    Phase {
        /// Random commands in the target arena from which `im` takes its clusters; visits do not
        /// count.
        Babbling = "babbling",
        /// Phase 1: evolution of crawlers in the training arena; visits do not count.
        Evolution = "evolution",
        /// Phase 2: the archive of phase 1 is replayed, in the training arena, into the repository.
        Repository = "repository",
        /// Phase 3, or a baseline's own epochs: visits count.
        Exploration = "exploration",
        /// All epochs are done.
        Done = "done",
    }
}

impl Phase {
    /// Whether robots watch what states and actions are made of.
    pub(crate) fn watches(self) -> bool {
        matches!(self, Self::Babbling | Self::Evolution)
    }
}

/// A stretch of epochs of one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stage {
    /// What happens; never `Done`.
    pub phase: Phase,
    /// How many epochs of it.
    pub epochs: u32,
    /// Arena in which an epoch begins.
    pub site: Site,
    /// Whether what was evaluated in the training arena is then shown for an epoch in the target
    /// arena, where visits count: an evolved baseline that trains elsewhere.
    pub shows: bool,
}

impl Stage {
    /// Arena epochs that one epoch of the stage takes.
    fn arena_epochs(self) -> u64 {
        if self.shows { 2 } else { 1 }
    }

    /// Whether its epochs are those that the spec counts.
    pub fn counts(self) -> bool {
        self.phase == Phase::Exploration
    }
}

/// The stages of a spec under a memory plan, in order.
pub(crate) fn stages(spec: &RunSpec, plan: &MemoryPlan) -> Vec<Stage> {
    let on_line = spec.is_on_line();
    let stage = |phase: Phase, epochs| Stage {
        phase,
        epochs,
        site: match phase {
            Phase::Evolution | Phase::Repository if !on_line => Site::Training,
            _ => Site::Target,
        },
        shows: false,
    };
    let p = &spec.controller.parameters;
    let training = spec.controller.training.as_ref();
    let training_epochs = training.map_or(0, |t| t.epochs);
    let explore = stage(Phase::Exploration, spec.epochs);
    match spec.controller.method {
        Method::Brownian => vec![explore],
        Method::Im => match p.states_from {
            StatesFrom::Babbling => vec![stage(Phase::Babbling, p.babbling_epochs), explore],
            StatesFrom::Phase1 => vec![stage(Phase::Evolution, training_epochs), explore],
        },
        method if method.is_evolved_baseline() => {
            // Where its training arena is its target, visits count as it evolves.
            let elsewhere = training.is_some_and(|t| *t.arena != *spec.arena);
            let site = if elsewhere {
                Site::Training
            } else {
                Site::Target
            };
            vec![Stage {
                site,
                shows: elsewhere,
                ..explore
            }]
        }
        _ => vec![
            stage(Phase::Evolution, training_epochs),
            stage(Phase::Repository, training_epochs.min(plan.genomes)),
            explore,
        ],
    }
}

/// Arena epochs of all stages together.
pub(crate) fn arena_epochs(stages: &[Stage]) -> u64 {
    stages
        .iter()
        .map(|stage| stage.arena_epochs() * u64::from(stage.epochs))
        .sum()
}
