//! What channels cost a run, and how long a question to a controller takes. Prints Markdown tables.
#![allow(clippy::print_stdout, reason = "the tables are the program's output")]

mod others;
mod rates;
mod round_trips;

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use serde_json::{Value, json};
use server::documents::{BuiltinArenas, ResolvedRun, resolve};

use crate::cases::scaled_arena;
use crate::instructions;

/// Channels measured: stepping rate with readers, and round trips to controllers.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Measures round trips to controllers instead of the stepping rate.
    #[arg(long)]
    round_trip: bool,
    /// Numbers of robots; of the stepping rate the first.
    #[arg(long, value_delimiter = ',')]
    robots: Vec<u64>,
    /// Rounds; each measures every way once, in turn.
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// Seconds that a way takes in a round.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// A compiled `clients/c/examples/braitenberg.c` to measure too.
    #[arg(long)]
    c: Option<PathBuf>,
    /// A Python with the package `evswarm[channels]` to measure too.
    #[arg(long)]
    python: Option<PathBuf>,
    /// Is a reader of frames, or a controller, of a run under a root: how the program starts others.
    #[arg(long, num_args = 3, hide = true)]
    be: Option<Vec<String>>,
}

/// Measures and prints.
///
/// # Errors
/// When a run, a channel or another process cannot be had.
pub fn run(options: &Options) -> Result<()> {
    if let Some(be) = &options.be {
        return others::be(be);
    }
    if options.round_trip {
        round_trips::print(options)?;
    } else {
        rates::print(options)?;
    }
    println!(
        "\n{} rounds of {} s a way; load average {}, this program included",
        options.rounds,
        options.seconds,
        instructions::load_average(),
    );
    Ok(())
}

/// A run of so many robots in an arena that grows with them.
fn spec(robots: u64, controller: &Value) -> Result<ResolvedRun> {
    let arena = serde_json::to_value(scaled_arena(robots)?.to_format())?;
    let spec = json!({
        "arena": arena, "robots": robots, "steps_per_epoch": 1_000, "epochs": 1_000_000,
        "placement": if robots == 1 { "start" } else { "random" }, "seed": 1,
        "controller": controller,
    });
    resolve(&spec, &BuiltinArenas).map_err(|errors| anyhow!("{errors:?}"))
}
