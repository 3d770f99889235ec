//! What requests came to: times and statuses.

use std::collections::BTreeMap;
use std::time::Duration;

/// What requests came to.
#[derive(Debug, Default)]
pub struct Tally {
    /// Times of reads.
    pub reads: Vec<Duration>,
    /// Times of writes.
    pub writes: Vec<Duration>,
    /// Answers by status; 0 for none.
    pub statuses: BTreeMap<u16, u64>,
}

impl Tally {
    /// Adds what others came to.
    pub fn add(&mut self, other: Tally) {
        self.reads.extend(other.reads);
        self.writes.extend(other.writes);
        for (status, count) in other.statuses {
            *self.statuses.entry(status).or_default() += count;
        }
    }
}
