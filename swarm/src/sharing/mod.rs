//! What robots share of what they learn, and how.
//!
//! Tables can be shared only where state 7 and action 3 mean the same to all: with any sharing the
//! robots of an arena get a common codebook when their phase 1 ends, from an equal part of each
//! robot's sample ([`pool`]), as robots are given the same firmware before they are set out.

pub mod pool;
pub mod radio;

use serde::{Deserialize, Serialize};

use crate::memory::MemoryPlan;
use crate::named_choice;
use crate::pilots::Transition;

named_choice! {
    /// How robots share.
    SharingMode {
        /// Not at all.
        None = "none",
        /// One codebook and one table for all robots of an arena.
        Arena = "arena",
        /// By messages to robots in range, each with a table of its own.
        Radio = "radio",
    }
}

/// Whether, and how, robots share what they learn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Sharing {
    /// Each robot for itself.
    None,
    /// One codebook and one table for all robots of an arena.
    Arena,
    /// By messages to robots in range.
    Radio(RadioLink),
}

impl Sharing {
    /// Its name in a spec.
    pub fn mode(&self) -> SharingMode {
        match self {
            Sharing::None => SharingMode::None,
            Sharing::Arena => SharingMode::Arena,
            Sharing::Radio(_) => SharingMode::Radio,
        }
    }
}

/// A robot's radio. It reaches through walls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadioLink {
    /// Greatest distance between the centres of two robots that hear each other, metres; `None`
    /// for no limit.
    pub range_m: Option<f64>,
    /// Bytes that a robot may tell in a step.
    pub bytes_per_step: u32,
}

/// Fewest bytes a step: one transition of a table of any size.
pub const LEAST_BYTES_PER_STEP: u32 = 6;
/// Most bytes a step.
pub const MOST_BYTES_PER_STEP: u32 = 4_096;
/// Default bytes a step: the newest transition and three earlier ones.
pub const DEFAULT_BYTES_PER_STEP: u32 = 16;
/// Default range: that of mEDEA, 6.4 body diameters.
pub const DEFAULT_RANGE_M: f64 = 0.47;
/// Most robots that a robot hears in a step: messages collide, and a step stays bounded work.
pub const MOST_HEARD: usize = 16;

/// An earlier transition as it is told: with how many of its kind the teller has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Told {
    pub transition: Transition,
    /// n_ij of the teller.
    pub recorded: u32,
}

/// How many transitions a robot tells in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToldTransitions {
    /// Earlier ones, told besides the newest.
    pub earlier: u32,
}

impl ToldTransitions {
    /// Bytes of the message as a robot holds it.
    pub fn bytes(self) -> u64 {
        u64::from(self.earlier) * size_of::<Told>() as u64
    }
}

/// What fits into a step's bytes: the newest transition (i, j, k), then earlier ones (i, j, k and
/// n_ij), each number in one byte, or two where the table is larger than that.
pub fn told_transitions(link: &RadioLink, plan: &MemoryPlan) -> ToldTransitions {
    let largest = plan.sensor_clusters.max(plan.actuator_clusters);
    let width = if largest <= 256 && plan.lambda <= 255 {
        1
    } else {
        2
    };
    ToldTransitions {
        earlier: link.bytes_per_step.saturating_sub(3 * width) / (4 * width),
    }
}

#[cfg(test)]
mod testing {
    use super::MemoryPlan;

    /// A small plan.
    pub(super) fn plan() -> MemoryPlan {
        MemoryPlan {
            sensor_clusters: 9,
            actuator_clusters: 9,
            sensori_motor_clusters: 9,
            sample: 20,
            actuator_sample: 4,
            lambda: 10,
            genomes: 1,
            bytes: 0,
        }
    }
}
