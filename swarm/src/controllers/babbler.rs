//! Random commands from which `im` takes its clusters, before its own exploration begins.

use serde::{Deserialize, Serialize};

use super::brownian::Brownian;
use super::controller::Controller;
use super::scaling::Scaling;
use super::watch::Watch;
use crate::bodies::Reading;
use crate::caps::MemoryPlan;
use crate::dimensions::WHEELS;

/// Draws commands afresh and watches what they bring.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Babbler {
    brownian: Brownian,
    scaling: Scaling,
    watch: Watch,
}

impl Babbler {
    /// A robot that has seen nothing.
    pub fn new(brownian: Brownian, scaling: Scaling, watch: Watch) -> Self {
        Self {
            brownian,
            scaling,
            watch,
        }
    }

    /// Most bytes held.
    pub fn bytes_for(plan: &MemoryPlan) -> u64 {
        size_of::<Self>() as u64 + Watch::heap_bytes_for(plan)
    }

    /// Bytes held, exactly counted.
    pub fn bytes(&self) -> u64 {
        size_of::<Self>() as u64 + self.watch.heap_bytes()
    }

    /// Vectors that found no room for a cluster of their own.
    pub fn clusters_saturated(&self) -> u64 {
        self.watch.saturated()
    }

    /// Clusters of sensor vectors and of commands so far.
    pub fn clusters(&self) -> (u32, u32) {
        (self.watch.sensors.len(), self.watch.actuators.len())
    }

    /// What it saw.
    pub fn finish(self) -> Watch {
        self.watch
    }
}

impl Controller for Babbler {
    #[inline(always)]
    fn act(&mut self, step: u64, reading: &Reading) -> [f32; WHEELS] {
        let command = self.brownian.command(step);
        self.watch.observe(&self.scaling.apply(reading), command);
        command
    }

    #[inline(always)]
    fn learn(&mut self, _reading: &Reading) {}
}
