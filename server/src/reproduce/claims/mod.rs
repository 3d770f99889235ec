//! The claims of the thesis against the runs: tests, corrections and verdicts.

mod claim;
mod table;
mod verdict;

use schemars::JsonSchema;
use serde::Serialize;

use super::engines::{EnginePair, compare_engines};
use super::plan::Settings;
use super::results::Findings;

pub use claim::{Claim, Test, Verdict};
pub use verdict::ALPHA;

/// `claims.json`.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Claims {
    schema: u32,
    /// Of the program.
    version: &'static str,
    /// Level of significance after correction.
    alpha: f64,
    correction: &'static str,
    seeds: u32,
    epochs: u32,
    arenas: Vec<String>,
    /// Tests that were corrected together.
    pub tests: usize,
    /// Each with its tests.
    pub claims: Vec<Claim>,
    /// The main comparison under both engines; in no family of tests.
    pub engines: Vec<EnginePair>,
}

/// Puts every claim to the test.
pub fn judge(settings: &Settings, findings: &Findings, radius_m: f64) -> anyhow::Result<Claims> {
    let mut claims = table::claims(settings, findings, radius_m)?;
    let tests = verdict::decide(&mut claims);
    Ok(Claims {
        schema: api::SCHEMA,
        version: env!("CARGO_PKG_VERSION"),
        alpha: ALPHA,
        correction: "Holm, over all tests with a p of this file",
        seeds: settings.seeds,
        epochs: settings.epochs,
        arenas: settings.arenas.clone(),
        tests,
        claims,
        engines: compare_engines(settings, findings),
    })
}
