//! How many steps a run is stepped by at once: sized by the clock, which changes no result.

use std::time::{Duration, Instant};

use swarm::run::{Phase, Progress, Run, Witness};

use super::observer::Stop;
use super::pilot::Pilot;

/// How long a block of steps should take: short enough for frames, for progress and for a prompt
/// stop.
const BLOCK: Duration = Duration::from_millis(10);

/// A number of steps that is kept at about [`BLOCK`] of wall time.
#[derive(Debug)]
pub struct Block {
    steps: u64,
}

impl Default for Block {
    fn default() -> Self {
        Self { steps: 1 }
    }
}

impl Block {
    /// Steps a run on by a block of at most so many steps.
    pub fn advance(
        &mut self,
        run: &mut Run,
        most: u64,
        witness: Option<&mut dyn Witness>,
    ) -> Progress {
        let start = Instant::now();
        let steps = self.steps.min(most);
        let progress = run.advance_before(steps, witness);
        self.resize(steps, start.elapsed());
        progress
    }

    /// As [`Block::advance`], steered before each step.
    ///
    /// # Errors
    /// Why the pilot wants no more steps.
    pub fn fly(
        &mut self,
        run: &mut Run,
        most: u64,
        pilot: &mut dyn Pilot,
        mut witness: Option<&mut dyn Witness>,
    ) -> Result<Progress, Stop> {
        let start = Instant::now();
        let steps = self.steps.min(most);
        let mut progress = run.progress();
        for _ in 0..steps {
            if progress.phase == Phase::Done {
                break;
            }
            pilot.steer(run)?;
            progress = match &mut witness {
                None => run.advance(1),
                Some(witness) => run.advance_before(1, Some(&mut **witness)),
            };
        }
        self.resize(steps, start.elapsed());
        Ok(progress)
    }

    /// To the pace of the last block. At most doubles or halves, so that one odd block does not
    /// lead to a long one; a block that was cut short says little, but says it at the right rate.
    fn resize(&mut self, steps: u64, took: Duration) {
        let wanted = steps as f64 * BLOCK.as_secs_f64() / took.as_secs_f64().max(1e-9);
        let size = self.steps as f64;
        self.steps = (wanted.clamp(size * 0.5, size * 2.0) as u64).max(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Size of a block after many steps that take so long each.
    fn settled(step: Duration, most: u64) -> u64 {
        let mut block = Block::default();
        for _ in 0..60 {
            let steps = block.steps.min(most);
            block.resize(steps, step * u32::try_from(steps).unwrap_or(u32::MAX));
        }
        block.steps
    }

    #[test]
    fn blocks_settle_at_their_time() {
        for most in [u64::MAX, 7] {
            for step in [
                Duration::from_nanos(150),
                Duration::from_micros(40),
                Duration::from_secs(1),
            ] {
                let wanted = (BLOCK.as_secs_f64() / step.as_secs_f64()).max(1.0);
                let steps = settled(step, most);
                let ratio = steps as f64 / wanted;
                assert!((0.5..=2.0).contains(&ratio), "{step:?}: {steps} steps");
            }
        }
    }
}
