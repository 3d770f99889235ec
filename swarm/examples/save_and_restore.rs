//! Saves a run in the middle of an epoch and goes on from the bytes: the end is the same, bit for
//! bit, as that of a run never interrupted.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::sync::Arc;

use swarm::ValidSpec;
use swarm::run::Run;
use swarm::spec::{FieldError, Method, RunSpec};

/// The step at which the run is saved.
const SAVED_AT: u64 = 1_234;

fn spec() -> Result<ValidSpec, Box<dyn Error>> {
    let mut spec = RunSpec::new(
        Method::Im,
        Arc::new(arenas::builtin("maze").ok_or("no such arena")?),
    );
    (spec.epochs, spec.steps_per_epoch, spec.robots) = (3, 500, 2);
    spec.placement = swarm::spec::Placement::Random;
    Ok(spec.validate().map_err(refused)?)
}

fn refused(errors: Vec<FieldError>) -> String {
    errors.iter().map(|error| format!("{error}\n")).collect()
}

/// SHA-256 of the final state.
fn end(mut run: Run) -> Option<String> {
    run.advance(u64::MAX);
    run.outcome().map(|outcome| outcome.state_sha256)
}

/// The ends of a run never interrupted, and of one saved and restored.
pub fn both_ends() -> Result<[Option<String>; 2], Box<dyn Error>> {
    let whole = Run::new(spec()?).map_err(refused)?;
    let mut first_part = Run::new(spec()?).map_err(refused)?;
    first_part.advance(SAVED_AT);
    let saved: Vec<u8> = first_part.snapshot();
    drop(first_part);
    let second_part = Run::restore(spec()?, &saved)?;
    println!("{} bytes, saved after {SAVED_AT} steps", saved.len());
    Ok([end(whole), end(second_part)])
}

/// Shows it.
pub fn main() -> Result<(), Box<dyn Error>> {
    let [whole, restored] = both_ends()?;
    println!("never interrupted: {whole:?}\nrestored:          {restored:?}");
    Ok(())
}
