//! What does not drift with the machine: instructions a robot-step (valgrind's callgrind), and the
//! peak memory of a process that does nothing but the case.

use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use crate::cases::Case;

/// The counts of one case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Count {
    /// The case.
    pub name: String,
    /// Instructions a robot-step.
    pub instructions: f64,
    /// Peak resident memory of the process, bytes.
    pub peak_bytes: u64,
}

/// Peak resident memory of this process, bytes (Linux).
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

/// Load average of the last minute (Linux), in words where there is none.
pub fn load_average() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let last_minute = text.split_whitespace().next();
    last_minute.unwrap_or("unknown").to_owned()
}

fn number_after(text: &str, label: &str) -> Option<u64> {
    let line = text.lines().find(|line| line.contains(label))?;
    line.rsplit(' ').next()?.replace(',', "").parse().ok()
}

/// Runs this program on one case for some steps, under another program if one is given.
fn child(case: &Case, steps: u64, under: &[&str]) -> Result<String> {
    let this = std::env::current_exe()?;
    let steps = steps.to_string();
    let arguments = ["--case", &case.name, "--steps", &steps];
    let mut command = match under.split_first() {
        Some((program, rest)) => {
            let mut command = Command::new(program);
            command.args(rest).arg(this);
            command
        }
        None => Command::new(this),
    };
    let output = command
        .args(arguments)
        .output()
        .context("starting the case (counting needs valgrind)")?;
    if !output.status.success() {
        bail!("{}: {}", case.name, String::from_utf8_lossy(&output.stderr));
    }
    Ok(String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Peak resident memory of a process that sets the case up and takes a few steps, bytes.
///
/// # Errors
/// When the case cannot be set up.
pub fn peak(case: &Case) -> Result<u64> {
    let text = child(case, 4, &[])?;
    number_after(&text, "peak_bytes").context("no peak in the child's output")
}

/// Counts a case: the difference between two runs of different length, so that setting up does not
/// count.
///
/// # Errors
/// When valgrind is missing or the case cannot be set up.
pub fn count(case: &Case) -> Result<Count> {
    let few = (10_000 / case.robots).max(4);
    let many = 3 * few;
    let valgrind = [
        "valgrind",
        "--tool=callgrind",
        "--callgrind-out-file=/dev/null",
    ];
    let collected = |steps| -> Result<u64> {
        let text = child(case, steps, &valgrind)?;
        number_after(&text, "Collected :").context("no count in valgrind's output")
    };
    let difference = collected(many)? - collected(few)?;
    let text = child(case, many, &[])?;
    Ok(Count {
        name: case.name.clone(),
        instructions: difference as f64 / ((many - few) * case.robots) as f64,
        peak_bytes: number_after(&text, "peak_bytes").context("no peak in the child's output")?,
    })
}
