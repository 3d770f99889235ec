//! How a scheduler works.

use std::num::NonZeroUsize;

use crate::channels::ChannelSettings;

/// How a scheduler works.
#[derive(Clone, Debug)]
pub struct SchedulerConfig {
    /// Runs stepped at a time.
    pub workers: NonZeroUsize,
    /// Most runs that may be unfinished before jobs are refused.
    pub unfinished_limit: u64,
    /// Most bytes that a run may hold: one that holds more fails, and the process goes on.
    pub run_memory_bytes: u64,
    /// Where runs that ask for it show their frames.
    pub channels: ChannelSettings,
}
