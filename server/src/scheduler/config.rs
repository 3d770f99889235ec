//! How a scheduler works.

use std::num::{NonZeroU32, NonZeroUsize};

use crate::channels::ChannelSettings;
use crate::recording::Limits;

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
    /// Most bytes of recordings.
    pub recordings: Limits,
    /// Where runs that ask for it show their frames.
    pub channels: ChannelSettings,
}
