//! Standard output and standard error, with errors instead of panics when nobody reads.

use std::fmt::Display;
use std::io::{self, Write};

use anyhow::Context;

use super::Failure;

/// Prints a line.
pub fn say(line: impl Display) -> Result<(), Failure> {
    say_bytes(format!("{line}\n").as_bytes())
}

/// Prints bytes as they are.
pub fn say_bytes(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(bytes)
        .and_then(|()| out.flush())
        .context("cannot write to standard output")
        .map_err(Failure::Other)
}

/// Prints a line to standard error.
pub fn complain(line: impl Display) {
    #[allow(
        clippy::let_underscore_must_use,
        reason = "if standard error is closed there is nobody to tell"
    )]
    let _ = writeln!(io::stderr().lock(), "{line}");
}
