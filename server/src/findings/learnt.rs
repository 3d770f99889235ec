//! What was kept of a run that no worker holds, as those who watch it see it.

use api::learnt::Learning;
use api::{ClusterCounts, RunResult, State};
use arenas::Squares;
use bytes::Bytes;
use swarm::run::{Phase, Run};

use super::{Assembler, FindingsError};
use crate::store::RunView;
use crate::watching::covered;

impl Assembler {
    /// What a look at the run says as its checkpoint or its end has it, or before the first step.
    ///
    /// # Errors
    /// When its state is not kept, or its checkpoint or spec cannot be used.
    pub fn looked<T>(
        &self,
        run: &RunView,
        look: impl FnOnce(&Run) -> T,
    ) -> Result<T, FindingsError> {
        let state = run.state.state();
        if matches!(state, State::Failed | State::Cancelled) {
            return Err(FindingsError::NotKept(state));
        }
        let spec = self.resolved(run)?;
        let broken = |why: String| FindingsError::broken(format!("run {}", run.id), why);
        let saved = match self.store.checkpoints().read(&run.id)? {
            Some(saved) => Some(saved),
            None if state == State::Done => self.store.finals().read(&run.id)?,
            None => self.store.origins().read(&run.id)?,
        };
        let opened = match saved {
            Some(saved) => Run::restore(spec.run_spec(), &saved.snapshot)
                .map_err(|error| broken(error.to_string()))?,
            None if state == State::Done => return Err(FindingsError::StateNotKept),
            None => Run::new(spec.run_spec())
                .map_err(|errors| broken(format!("its spec: {} fields", errors.len())))?,
        };
        Ok(look(&opened))
    }

    /// How far robots have learnt as the result of a run tells it, whose last state is not kept;
    /// `None` where they learn nothing.
    ///
    /// # Errors
    /// When its spec cannot be used.
    pub fn learning_at_the_end(&self, run: &RunView) -> Result<Option<Learning>, FindingsError> {
        let learns = |result: &&RunResult| result.clusters != ClusterCounts::default();
        let Some(result) = run.result().filter(learns) else {
            return Ok(None);
        };
        let spec = self.resolved(run)?.run_spec();
        Ok(Some(Learning {
            run_id: run.id.clone(),
            is_live: false,
            phase: Phase::Done.name().to_owned(),
            epochs_done: run.epochs_total,
            epochs_total: run.epochs_total,
            arena_step: None,
            robots: spec.robots,
            budget_bytes: spec.memory_budget_bytes,
            memory: result.memory.clone(),
            clusters: result.clusters,
            model: result.model,
            items: Vec::new(),
            next: None,
        }))
    }

    /// What it covered, as a message of its stream of frames.
    ///
    /// # Errors
    /// When that is not kept or cannot be read.
    pub fn covered(&self, run: &RunView) -> Result<Bytes, FindingsError> {
        // At its end it is the same for all who look.
        match run.state.state() {
            State::Done => self.once(&format!("squares of run {}", run.id), || self.squares(run)),
            _ => self.squares(run),
        }
    }

    fn squares(&self, run: &RunView) -> Result<Bytes, FindingsError> {
        let spec = self.resolved(run)?;
        let _turn = self.turn_for_squares(&spec)?;
        let found = self.stored(run)?;
        let squares = Squares::of(spec.arena());
        let none = vec![0; squares.count()];
        let is_whole = found.visits.len() == none.len();
        let visits = if is_whole { &found.visits } else { &none };
        let steps = found.metrics.rows.last().map_or(0, |row| row.steps);
        Ok(covered(steps, &squares, visits, &found.metrics.first_entry))
    }
}
