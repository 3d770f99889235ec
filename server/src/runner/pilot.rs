//! Who steers a run whose robots are steered from outside.

use swarm::run::Run;

use super::observer::Stop;

/// Says before each step what robots do in it.
pub trait Pilot {
    /// Steers the run's next step.
    ///
    /// # Errors
    /// Why it cannot be made now; the run is as it was.
    fn steer(&mut self, run: &mut Run) -> Result<(), Stop>;
}
