//! What recording costs: steps a second with and without it in the same run, bytes, and how soon a
//! slice of a long recording is there. Prints Markdown tables.
#![allow(clippy::print_stdout, reason = "the tables are the program's output")]

mod options;
mod rates;
mod seeks;
mod subject;

use anyhow::Result;
pub use options::Options;

use crate::instructions;

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
        instructions::load_average(),
    );
    println!();
    for line in seeks::lines(options, home.path())? {
        println!("{line}");
    }
    Ok(())
}
