//! What channels cost a run, and how long a question to a controller takes. Prints Markdown tables.
#![allow(clippy::print_stdout, reason = "the tables are the program's output")]

mod options;
mod others;
mod rates;
mod round_trips;

use anyhow::Result;
pub use options::Options;

use crate::instructions;

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
