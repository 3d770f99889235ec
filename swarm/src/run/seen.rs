//! What whoever looks on sees of a run beside bodies: where in its plan it is, and what each robot
//! has decided.

use std::sync::Arc;

use arenas::Arena;

use super::machine::Run;
use super::plan::{Decision, Place, StagePlan};
use super::venue::{TARGET, TRAINING};

impl Run {
    /// The stages that the run goes through.
    pub fn plan(&self) -> Vec<StagePlan> {
        self.stages.iter().map(StagePlan::of).collect()
    }

    /// Where the run is.
    pub fn place(&self) -> Place {
        let begun = self.position.steps - u64::from(self.position.step);
        Place {
            arena_epoch: begun / u64::from(self.spec.steps_per_epoch),
            step: self.position.step,
        }
    }

    /// Calls for each robot that knows states and actions, in the order of their numbers.
    pub fn each_decision(&self, each: &mut dyn FnMut(Decision)) {
        self.learners.each_decision(each);
    }

    /// What a robot decides by, where it explores by a table: the score of each action in a state,
    /// and how often it was tried.
    pub fn scores(&self, robot: usize, state: u32) -> Option<Vec<(f32, u32)>> {
        let table = self.learners.table(robot)?;
        let actions = 0..table.actions();
        (state < table.states()).then(|| {
            actions
                .map(|action| (table.score(state, action), table.count(state, action)))
                .collect()
        })
    }

    /// Whether robots are in the training arena.
    pub fn is_in_training(&self) -> bool {
        self.venue() == TRAINING
    }

    /// The arena in which robots train, where it is another.
    pub fn training_arena(&self) -> Option<&Arc<Arena>> {
        self.venues.get(TRAINING).map(|venue| &venue.ground.arena)
    }

    /// The arena in which visits count.
    pub fn target_arena(&self) -> &Arc<Arena> {
        &self.venues[TARGET].ground.arena
    }
}
