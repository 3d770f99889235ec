//! `evswarm check` and `evswarm backup`: data directories, also those that a server uses.

use std::path::PathBuf;

use anyhow::{Context, anyhow};
use clap::Args;

use super::{Failure, output};
use crate::store;

#[derive(Debug, Args)]
pub struct CheckArguments {
    /// The data directory.
    #[arg(long)]
    data: PathBuf,
}

#[derive(Debug, Args)]
pub struct BackupArguments {
    /// The data directory.
    #[arg(long)]
    data: PathBuf,
    /// Directory to make, which `evswarm serve --data` can then use.
    #[arg(long)]
    to: PathBuf,
}

pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let checked = store::check(&arguments.data)?;
    for fault in &checked.faults {
        output::say(fault)?;
    }
    let (results, checkpoints) = (checked.results, checked.checkpoints);
    let looked = format!("{results} results and {checkpoints} checkpoints looked at");
    match checked.faults.len() {
        0 => output::say(format_args!("no fault: {looked}")),
        1 => Err(anyhow!("1 fault: {looked}").into()),
        faults => Err(anyhow!("{faults} faults: {looked}").into()),
    }
}

pub fn backup(arguments: &BackupArguments) -> Result<(), Failure> {
    let to = arguments.to.display();
    store::backup(&arguments.data, &arguments.to).with_context(|| format!("no backup in {to}"))?;
    output::say(format_args!("copied to {to}"))
}
