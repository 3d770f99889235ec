//! Brownian moves: each command uniform in the action space (section 5.2.3).

use serde::{Deserialize, Serialize};

use super::controller::Controller;
use crate::bodies::Reading;
use crate::dimensions::WHEELS;
use crate::prefetch::prefetch;
use crate::random::{draw, unit};

/// Draws every command afresh.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Brownian {
    key: u64,
}

impl Brownian {
    /// A controller on the robot's action stream.
    pub fn new(key: u64) -> Self {
        Self { key }
    }

    /// The command of a step.
    #[inline(always)]
    pub fn command(&self, step: u64) -> [f32; WHEELS] {
        let bits = draw(self.key, step);
        [
            2.0 * unit(bits as u32) - 1.0,
            2.0 * unit((bits >> 32) as u32) - 1.0,
        ]
    }
}

impl Controller for Brownian {
    #[inline(always)]
    fn act(&mut self, step: u64, _reading: &Reading) -> [f32; WHEELS] {
        self.command(step)
    }

    #[inline(always)]
    fn learn(&mut self, _reading: &Reading) {}

    #[inline(always)]
    fn expect_acting(&self) {
        prefetch(self);
    }
}
