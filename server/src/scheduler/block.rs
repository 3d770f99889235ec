//! How many steps a run is stepped by at once: sized by the clock, which changes no result.

use std::time::{Duration, Instant};

use swarm::run::{Progress, Run};

/// How long a block of steps should take: short enough for frames, for progress and for a prompt
/// stop.
const BLOCK: Duration = Duration::from_millis(10);

/// A number of steps that is kept at about `BLOCK` of wall time.
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
    /// Steps a run on by a block.
    pub fn advance(&mut self, run: &mut Run) -> Progress {
        let start = Instant::now();
        let progress = run.advance(self.steps);
        self.resize(start.elapsed());
        progress
    }

    /// At most doubles or halves, so that one odd block does not lead to a long one.
    fn resize(&mut self, took: Duration) {
        let factor = BLOCK.as_secs_f64() / took.as_secs_f64().max(1e-9);
        self.steps = ((self.steps as f64 * factor.clamp(0.5, 2.0)) as u64).max(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_settle_at_their_time() {
        for step in [
            Duration::from_nanos(150),
            Duration::from_micros(40),
            Duration::from_secs(1),
        ] {
            let mut block = Block::default();
            for _ in 0..60 {
                block.resize(step * u32::try_from(block.steps).unwrap_or(u32::MAX));
            }
            let wanted = (BLOCK.as_secs_f64() / step.as_secs_f64()).max(1.0);
            let ratio = block.steps as f64 / wanted;
            assert!(
                (0.5..=2.0).contains(&ratio),
                "{step:?}: {} steps",
                block.steps
            );
        }
    }
}
