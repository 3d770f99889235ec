//! The stages that a method goes through, and how many epochs each takes.

use crate::caps::MemoryPlan;
use crate::named_choice;
use crate::random::Site;
use crate::spec::{Method, RunSpec, StatesFrom};

named_choice! {
    /// What a run is doing.
    Phase {
        /// Random commands from which `im` takes its clusters.
        Babbling = "babbling",
        /// Phase 1: evolution of crawlers.
        Evolution = "evolution",
        /// Phase 2: the archive is replayed into the repository.
        Repository = "repository",
        /// Phase 3, or a baseline's own epochs: visits count.
        Exploration = "exploration",
        /// All epochs are done.
        Done = "done",
    }
}

/// A stretch of epochs of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stage {
    /// What happens.
    pub kind: StageKind,
    /// How many epochs of it.
    pub epochs: u32,
    /// Arena in which an epoch begins.
    pub site: Site,
}

/// What happens in a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StageKind {
    /// Random commands in the target arena; visits do not count.
    Babble,
    /// Evolution in the training arena; visits do not count.
    Evolve,
    /// The archive of phase 1 again, in the training arena.
    Replay,
    /// The phase-3 controller, or random commands, in the target arena.
    Explore,
    /// An evolved baseline whose training arena is its target: visits count as it evolves.
    EvolveInTarget,
    /// An evolved baseline: each candidate is evaluated in the training arena, then shown for an
    /// epoch in the target arena, where visits count.
    EvolveAndShow,
}

impl StageKind {
    /// Arena epochs that one epoch of the stage takes.
    pub fn arena_epochs(self) -> u64 {
        if self == StageKind::EvolveAndShow {
            2
        } else {
            1
        }
    }

    /// Where its epochs begin, unless all of the run is on line.
    fn site(self) -> Site {
        match self {
            Self::Evolve | Self::Replay | Self::EvolveAndShow => Site::Training,
            Self::Babble | Self::Explore | Self::EvolveInTarget => Site::Target,
        }
    }

    /// Whether robots watch what states and actions are made of.
    pub fn watches(self) -> bool {
        matches!(self, Self::Babble | Self::Evolve)
    }

    /// Whether its epochs are those that the spec counts.
    pub fn counts(self) -> bool {
        matches!(
            self,
            Self::Explore | Self::EvolveInTarget | Self::EvolveAndShow
        )
    }

    /// The phase it belongs to.
    pub fn phase(self) -> Phase {
        match self {
            Self::Babble => Phase::Babbling,
            Self::Evolve => Phase::Evolution,
            Self::Replay => Phase::Repository,
            Self::Explore | Self::EvolveInTarget | Self::EvolveAndShow => Phase::Exploration,
        }
    }
}

/// The stages of a spec under a memory plan, in order.
pub(crate) fn stages(spec: &RunSpec, plan: &MemoryPlan) -> Vec<Stage> {
    let on_line = spec.is_on_line();
    let stage = |kind: StageKind, epochs| Stage {
        kind,
        epochs,
        site: if on_line { Site::Target } else { kind.site() },
    };
    let p = &spec.controller.parameters;
    let training = spec.controller.training.as_ref();
    let training_epochs = training.map_or(0, |t| t.epochs);
    let explore = stage(StageKind::Explore, spec.epochs);
    match spec.controller.method {
        Method::Brownian => vec![explore],
        Method::Im => match p.states_from {
            StatesFrom::Babbling => vec![stage(StageKind::Babble, p.babbling_epochs), explore],
            StatesFrom::Phase1 => vec![stage(StageKind::Evolve, training_epochs), explore],
        },
        method if method.is_evolved_baseline() => {
            let elsewhere = training.is_some_and(|t| *t.arena != *spec.arena);
            let kind = if elsewhere {
                StageKind::EvolveAndShow
            } else {
                StageKind::EvolveInTarget
            };
            vec![stage(kind, spec.epochs)]
        }
        _ => vec![
            stage(StageKind::Evolve, training_epochs),
            stage(StageKind::Replay, training_epochs.min(plan.genomes)),
            explore,
        ],
    }
}

/// Arena epochs of all stages together.
pub(crate) fn arena_epochs(stages: &[Stage]) -> u64 {
    stages
        .iter()
        .map(|stage| stage.kind.arena_epochs() * u64::from(stage.epochs))
        .sum()
}
