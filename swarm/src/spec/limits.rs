//! The largest runs that are accepted.

/// Most epochs of a run.
pub const MAX_EPOCHS: u32 = 1_000_000;
/// Most steps of an epoch.
pub const MAX_STEPS_PER_EPOCH: u32 = 1_000_000;
/// Most robots of a run.
pub const MAX_ROBOTS: u32 = 100_000;
