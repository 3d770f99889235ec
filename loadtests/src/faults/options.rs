//! How often the service is killed, and how.

/// Kills of the service, on this machine alone.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Kills at random moments.
    #[arg(long, default_value_t = 200)]
    pub(super) kills: u64,
    /// Kills at named places: claims, checkpoints, results, posts, changes of jobs, migrations.
    #[arg(long, default_value_t = 100)]
    pub(super) at_places: u64,
    /// Threads that step runs.
    #[arg(long, default_value_t = 2)]
    pub(super) threads: usize,
    /// Decides what is done, and when the service is killed.
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
}
