//! How a scheduler works.

use std::num::{NonZeroU32, NonZeroUsize};

use crate::channels::ChannelSettings;

/// Most bytes of all recordings together, unless it is said otherwise.
pub const RECORDINGS_BYTES: u64 = 16 << 30;

/// How a scheduler works.
#[derive(Clone, Debug)]
pub struct SchedulerConfig {
    /// Runs stepped at a time.
    pub workers: NonZeroUsize,
    /// Most runs that may be unfinished before jobs are refused.
    pub unfinished_limit: u64,
    /// Most bytes that a run may hold: one that holds more fails, and the process goes on.
    pub run_memory_bytes: u64,
    /// Epochs of an arena after which a checkpoint of each run is kept for later recordings.
    pub keep_every_epochs: Option<NonZeroU32>,
    /// Most bytes of all recordings together.
    pub recordings_bytes: u64,
    /// Where runs that ask for it show their frames.
    pub channels: ChannelSettings,
}
