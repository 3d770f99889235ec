//! What recording costs: steps a second with and without it in the same run, bytes, and how soon a
//! slice of a long recording is there. Prints Markdown tables.
#![allow(clippy::print_stdout, reason = "the tables are the program's output")]

mod rates;
mod seeks;
mod subject;

use anyhow::Result;

use crate::instructions;

/// Recording measured: rates, sizes, and random slices of a long recording.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Numbers of robots whose rates are measured.
    #[arg(long, value_delimiter = ',', default_values_t = [1, 100, 1_000])]
    robots: Vec<u64>,
    /// Rounds; each steps every way of recording once, in turn.
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// Seconds a way takes in a round, about.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Robot-steps of the recording that slices are read from, with its 1,000 robots.
    #[arg(long, default_value_t = 100_000_000)]
    robot_steps: u64,
    /// Slices that are read.
    #[arg(long, default_value_t = 2_000)]
    slices: u32,
    /// Folder for the recordings, on the disk that is to be measured [default: a temporary one].
    #[arg(long)]
    folder: Option<std::path::PathBuf>,
}

/// Measures and prints.
///
/// # Errors
/// When a run cannot be stepped or a recording not be written or read.
pub fn run(options: &Options) -> Result<()> {
    let home = match &options.folder {
        Some(folder) => tempfile::tempdir_in(folder)?,
        None => tempfile::tempdir()?,
    };
    println!(
        "| Robots | Recorded | Million robot-steps a second | Against off | CPU of the stepping \
         thread, ns a robot-step | Bytes a robot-step recorded |\n|---|---|---|---|---|---|"
    );
    for &robots in &options.robots {
        for row in rates::rows(options, home.path(), robots)? {
            println!("{row}");
        }
    }
    println!(
        "\n{} rounds of about {} s a way, medians; load average {}, this program included",
        options.rounds,
        options.seconds,
        instructions::load_average().unwrap_or_else(|| "unknown".into()),
    );
    println!();
    for line in seeks::lines(options, home.path())? {
        println!("{line}");
    }
    Ok(())
}
