//! Random commands from which `im` takes its clusters, before its own exploration begins.

use serde::{Deserialize, Serialize};

use super::brownian::Brownian;
use super::command_levels::CommandLevels;
use super::controller::Controller;
use super::scaling::Scaling;
use super::watch::Watch;
use crate::bodies::Reading;
use crate::caps::MemoryPlan;
use crate::dimensions::WHEELS;
use crate::spec::{ControllerParameters, SensorScale};

/// Draws commands afresh and watches what they bring.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Babbler {
    brownian: Brownian,
    settings: Settings,
    watch: Watch,
}

/// How it sees sensor values and gives commands. Saved as the scaling alone, as it was before there
/// were levels: [`Babbler::set_up`] gives them back to one that was saved.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(from = "Scaling", into = "Scaling")]
struct Settings {
    scale: SensorScale,
    levels: CommandLevels,
}

impl From<Settings> for Scaling {
    fn from(settings: Settings) -> Self {
        Scaling::new(settings.scale)
    }
}

impl From<Scaling> for Settings {
    fn from(_: Scaling) -> Self {
        Self::of(&ControllerParameters::default())
    }
}

impl Settings {
    fn of(p: &ControllerParameters) -> Self {
        Self {
            scale: p.clusters_see(),
            levels: CommandLevels::new(p.command_levels),
        }
    }
}

impl Babbler {
    /// A robot that has seen nothing.
    pub fn new(p: &ControllerParameters, brownian: Brownian, watch: Watch) -> Self {
        Self {
            brownian,
            settings: Settings::of(p),
            watch,
        }
    }

    /// Whether saved parts fit together, under these caps.
    pub fn is_sound(&self, plan: &MemoryPlan) -> bool {
        self.watch.is_sound(plan)
    }

    /// Takes from the parameters what is not saved.
    pub fn set_up(&mut self, p: &ControllerParameters) {
        self.settings = Settings::of(p);
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
        let command = self.settings.levels.round(self.brownian.command(step));
        let sensors = Scaling::new(self.settings.scale).apply(reading);
        self.watch.observe(&sensors, command);
        command
    }

    #[inline(always)]
    fn learn(&mut self, _reading: &Reading) {}
}
