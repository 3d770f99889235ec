//! What stands in a data directory.

/// The database's file in a data directory.
pub(super) const DATABASE: &str = "evswarm.sqlite3";
/// The folder of checkpoints.
pub(super) const CHECKPOINTS: &str = "checkpoints";
/// The folder of the states that runs go on from which do not start at their beginning.
pub(super) const ORIGINS: &str = "origins";
/// The folder of the last states of runs that are done.
pub(super) const FINALS: &str = "finals";
/// The folder of recordings.
pub(super) const RECORDINGS: &str = "recordings";
