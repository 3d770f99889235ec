//! How much of its table a robot tells in a step.

use crate::caps::MemoryPlan;
use crate::learn::transition::Transition;
use crate::spec::RadioLink;

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
