//! What robots share of what they learn, as a spec says it.

use serde::{Deserialize, Serialize};

use crate::parameters::named_choice;

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
