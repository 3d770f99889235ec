//! What was kept of a run that no worker holds, as those who watch it see it.

use api::State;
use api::learnt::Learnt;
use arenas::Squares;
use bytes::Bytes;
use swarm::run::Run;

use super::{Assembler, FindingsError};
use crate::store::RunView;
use crate::watching::{covered, shown};

impl Assembler {
    /// What a robot has learnt as the run's checkpoint has it, or before the first step; `None` where
    /// it learns nothing or there is no such robot.
    ///
    /// # Errors
    /// When its state is not kept, or its checkpoint or spec cannot be used.
    pub fn learnt(&self, run: &RunView, robot: u32) -> Result<Option<Learnt>, FindingsError> {
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
        Ok(shown(&opened, robot, false))
    }

    /// What it covered, as a message of its stream of frames.
    ///
    /// # Errors
    /// When that is not kept or cannot be read.
    pub fn covered(&self, run: &RunView) -> Result<Bytes, FindingsError> {
        let found = self.stored(run)?;
        let spec = self.resolved(run)?;
        let squares = Squares::of(spec.arena());
        let none = vec![0; squares.count()];
        let is_whole = found.visits.len() == none.len();
        let visits = if is_whole { &found.visits } else { &none };
        let steps = found.metrics.rows.last().map_or(0, |row| row.steps);
        Ok(covered(steps, &squares, visits, &found.metrics.first_entry))
    }
}
