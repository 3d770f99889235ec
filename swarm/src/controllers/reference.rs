//! The reference of model accuracy (section 4.3.4): a robot that takes every action equally often and
//! counts where each led, without forgetting.

use super::codebook::Codebook;
use super::controller::Controller;
use super::scaling::Scaling;
use crate::bodies::Reading;
use crate::dimensions::WHEELS;
use crate::learn::accuracy::TransitionCounts;
use crate::random::{below, draw};

/// A robot with the states, actions and commands of a learner, but that chooses at random.
pub struct Reference<'a> {
    codebook: &'a Codebook,
    scaling: Scaling,
    key: u64,
    counts: TransitionCounts,
    state: u32,
    action: u32,
}

impl<'a> Reference<'a> {
    /// A robot that has counted nothing; `key` is that of its random stream.
    pub fn new(codebook: &'a Codebook, scaling: Scaling, key: u64) -> Self {
        Self {
            codebook,
            scaling,
            key,
            counts: TransitionCounts::new(codebook.states.len(), codebook.actions.len()),
            state: 0,
            action: 0,
        }
    }

    /// Starts a trajectory from the sensors read at its beginning.
    pub fn begin_trajectory(&mut self, reading: &Reading) {
        self.state = self.state_of(reading);
    }

    /// What it has counted.
    pub fn counts(&self) -> &TransitionCounts {
        &self.counts
    }

    #[inline(always)]
    fn state_of(&self, reading: &Reading) -> u32 {
        self.codebook.states.nearest(&self.scaling.apply(reading)).0
    }
}

impl Controller for Reference<'_> {
    #[inline(always)]
    fn act(&mut self, step: u64, _reading: &Reading) -> [f32; WHEELS] {
        let bits = draw(self.key, step);
        self.action = below(bits as u32, self.codebook.actions.len());
        let samples = &self.codebook.samples;
        samples.command(samples.place(self.action, (bits >> 32) as u32))
    }

    #[inline(always)]
    fn learn(&mut self, reading: &Reading) {
        let next = self.state_of(reading);
        self.counts.record(self.state, self.action, next);
        self.state = next;
    }
}
