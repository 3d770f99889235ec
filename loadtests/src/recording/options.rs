//! What is measured of recording, and how much of it.

/// Recording measured: rates, sizes, and random slices of a long recording.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Numbers of robots whose rates are measured.
    #[arg(long, value_delimiter = ',', default_values_t = [1, 100, 1_000])]
    pub(super) robots: Vec<u64>,
    /// Rounds; each steps every way of recording once, in turn.
    #[arg(long, default_value_t = 9)]
    pub(super) rounds: usize,
    /// Seconds a way takes in a round, about.
    #[arg(long, default_value_t = 1.0)]
    pub(super) seconds: f64,
    /// Robot-steps of the recording that slices are read from, with its 1,000 robots.
    #[arg(long, default_value_t = 100_000_000)]
    pub(super) robot_steps: u64,
    /// Slices that are read.
    #[arg(long, default_value_t = 2_000)]
    pub(super) slices: u32,
    /// Folder for the recordings, on the disk that is to be measured [default: a temporary one].
    #[arg(long)]
    pub(super) folder: Option<std::path::PathBuf>,
}
