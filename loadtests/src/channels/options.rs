//! What is measured of channels, and on which run.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use serde_json::{Value, json};
use server::documents::{BuiltinArenas, ResolvedRun, resolve};

use crate::cases::scaled_arena;

/// Channels measured: stepping rate with readers, and round trips to controllers.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Measures round trips to controllers instead of the stepping rate.
    #[arg(long)]
    pub(super) round_trip: bool,
    /// Numbers of robots; of the stepping rate the first.
    #[arg(long, value_delimiter = ',')]
    pub(super) robots: Vec<u64>,
    /// Rounds; each measures every way once, in turn.
    #[arg(long, default_value_t = 9)]
    pub(super) rounds: usize,
    /// Seconds that a way takes in a round.
    #[arg(long, default_value_t = 1.0)]
    pub(super) seconds: f64,
    /// A compiled `clients/c/examples/braitenberg.c` to measure too.
    #[arg(long)]
    pub(super) c: Option<PathBuf>,
    /// A Python with the package `evswarm[channels]` to measure too.
    #[arg(long)]
    pub(super) python: Option<PathBuf>,
    /// Is a reader of frames, or a controller, of a run under a root: how the program starts others.
    #[arg(long, num_args = 3, hide = true)]
    pub(super) be: Option<Vec<String>>,
}

/// A run of so many robots in an arena that grows with them.
pub(super) fn spec(robots: u64, controller: &Value) -> Result<ResolvedRun> {
    let arena = serde_json::to_value(scaled_arena(robots)?.to_format())?;
    let spec = json!({
        "arena": arena, "robots": robots, "steps_per_epoch": 1_000, "epochs": 1_000_000,
        "placement": if robots == 1 { "start" } else { "random" }, "seed": 1,
        "controller": controller,
    });
    resolve(&spec, &BuiltinArenas).map_err(|errors| anyhow!("{errors:?}"))
}
