//! What a stage of a run is: its phase, how many epochs, where.

use crate::parameters::named_choice;
use crate::random::Site;
use crate::spec::RunSpec;

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
    /// Epochs of a phase; training is in the training arena, unless all of the run is on line.
    pub fn of(spec: &RunSpec, phase: Phase, epochs: u32) -> Self {
        let site = match phase {
            Phase::Evolution | Phase::Repository if !spec.is_on_line() => Site::Training,
            _ => Site::Target,
        };
        Self {
            phase,
            epochs,
            site,
            shows: false,
        }
    }

    /// Arena epochs that one epoch of the stage takes.
    fn arena_epochs(self) -> u64 {
        if self.shows { 2 } else { 1 }
    }

    /// Whether its epochs are those that the spec counts.
    pub fn counts(self) -> bool {
        self.phase == Phase::Exploration
    }
}

/// Arena epochs of all stages together.
pub(crate) fn arena_epochs(stages: &[Stage]) -> u64 {
    stages
        .iter()
        .map(|stage| stage.arena_epochs() * u64::from(stage.epochs))
        .sum()
}
