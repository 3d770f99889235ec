//! `evswarm token`: makes a token, and its line for the file that `evswarm serve --tokens` reads.

use anyhow::{Context, bail};
use base64::Engine;
use base64::prelude::BASE64_URL_SAFE_NO_PAD;
use rustix::rand::{GetRandomFlags, getrandom};

use super::{Failure, output};
use crate::http::{Right, token_line};

/// Random bytes of a token.
const SECRET_BYTES: usize = 32;

/// The token of the environment: what stands on a command line is shown to everyone by `ps`.
pub fn of_environment() -> Option<String> {
    std::env::var("EVSWARM_TOKEN")
        .ok()
        .filter(|token| !token.is_empty())
}

#[derive(Debug, clap::Args)]
pub struct TokenArguments {
    /// Whose it is: letters, digits, - and _.
    name: String,
    /// It allows to read, not to change anything.
    #[arg(long)]
    read_only: bool,
}

/// The line goes to standard output, for `>>`; the token itself, which is kept nowhere, to standard
/// error.
pub fn token(arguments: &TokenArguments) -> Result<(), Failure> {
    let secret = secret(&arguments.name)?;
    let right = match arguments.read_only {
        true => Right::Read,
        false => Right::Write,
    };
    output::say(token_line(&arguments.name, right, &secret))?;
    output::complain(format_args!("the token, told this once: {secret}"));
    Ok(())
}

fn secret(name: &str) -> anyhow::Result<String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.is_empty() || !name.chars().all(is_plain) {
        bail!("a name of letters, digits, - and _ is needed");
    }
    let mut bytes = [0; SECRET_BYTES];
    let got = getrandom(&mut bytes, GetRandomFlags::empty()).context("no random bytes")?;
    // As many as these come at once.
    if got != SECRET_BYTES {
        bail!("the system gave too few random bytes");
    }
    Ok(BASE64_URL_SAFE_NO_PAD.encode(bytes))
}
