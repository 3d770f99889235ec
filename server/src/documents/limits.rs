//! Limits of a run spec as posted.

/// Most counted epochs, and most training epochs.
pub const MAX_EPOCHS: u64 = swarm::spec::MAX_EPOCHS as u64;
/// Most steps an epoch.
pub const MAX_STEPS_PER_EPOCH: u64 = swarm::spec::MAX_STEPS_PER_EPOCH as u64;
/// Most robots.
pub const MAX_ROBOTS: u64 = swarm::spec::MAX_ROBOTS as u64;
/// Largest seed: 2^53 - 1, up to which every JSON reader keeps whole numbers exact.
pub const MAX_SEED: u64 = (1 << 53) - 1;
