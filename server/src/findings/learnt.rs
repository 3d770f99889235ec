//! What a robot had learnt when its run was last saved.

use api::learnt::Learnt;
use swarm::run::Run;

use super::{Assembler, FindingsError};
use crate::store::RunView;
use crate::watching::shown;

impl Assembler {
    /// What a robot has learnt as the run's checkpoint has it, or before the first step; `None` where
    /// it learns nothing or there is no such robot.
    ///
    /// # Errors
    /// When the run has ended, or its checkpoint or spec cannot be used.
    pub fn learnt(&self, run: &RunView, robot: u32) -> Result<Option<Learnt>, FindingsError> {
        let state = run.state.state();
        if state.is_final() {
            return Err(FindingsError::NotKept(state));
        }
        let spec = self.resolved(run)?;
        let broken = |why: String| FindingsError::broken(format!("run {}", run.id), why);
        let opened = match self.store.checkpoints().read(&run.id)? {
            Some(saved) => Run::restore(spec.run_spec(), &saved.snapshot)
                .map_err(|error| broken(error.to_string()))?,
            None => Run::new(spec.run_spec())
                .map_err(|errors| broken(format!("its spec: {} fields", errors.len())))?,
        };
        Ok(shown(&opened, robot, false))
    }
}
