//! A run's plan as it is told to whoever looks on: its stages, its epochs, and what a robot decides.

use crate::random::Site;
use crate::stages::{Phase, Stage};
use crate::validate::ValidSpec;

/// A stretch of epochs of one phase, as a run's plan has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StagePlan {
    /// What happens.
    pub phase: Phase,
    /// Epochs of it.
    pub epochs: u32,
    /// Whether it is in the training arena.
    pub in_training: bool,
    /// Whether each epoch is followed by one that shows the same in the target arena.
    pub shows: bool,
}

impl StagePlan {
    pub(super) fn of(stage: &Stage) -> Self {
        Self {
            phase: stage.phase,
            epochs: stage.epochs,
            in_training: stage.site == Site::Training,
            shows: stage.shows,
        }
    }

    /// Epochs of an arena that it takes, those that only show included.
    pub fn arena_epochs(&self) -> u64 {
        u64::from(self.epochs) * if self.shows { 2 } else { 1 }
    }
}

/// What one epoch of an arena is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EpochKind {
    /// Its phase.
    pub phase: Phase,
    /// Which epoch of the phase, from 0.
    pub number: u32,
    /// Whether it is in the training arena.
    pub in_training: bool,
}

impl EpochKind {
    /// What the epoch of this number is, counted from 0 over all phases; `None` after the last.
    pub fn of(plan: &[StagePlan], arena_epoch: u64) -> Option<Self> {
        let mut first = 0;
        for stage in plan {
            let within = arena_epoch - first;
            if within < stage.arena_epochs() {
                let each = if stage.shows { 2 } else { 1 };
                return Some(Self {
                    phase: stage.phase,
                    number: (within / each) as u32,
                    in_training: stage.in_training && within.is_multiple_of(each),
                });
            }
            first += stage.arena_epochs();
        }
        None
    }
}

/// Where a run is: an epoch of an arena, counted from 0 over all phases, and the steps of it that
/// are done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The epoch.
    pub arena_epoch: u64,
    /// Steps of it.
    pub step: u32,
}

/// What a robot that knows states and actions has decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decision {
    /// The state that it is in: the cluster of what its sensors read now.
    pub state: u32,
    /// The action that it chose last, whose command it was given.
    pub action: u32,
}

impl ValidSpec {
    /// The stages that a run goes through.
    pub fn plan(&self) -> Vec<StagePlan> {
        self.stages().iter().map(StagePlan::of).collect()
    }
}
