//! One run: a robot that learnt by Ev-ITER in the empty arena explores the maze.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::sync::Arc;

use swarm::run::{Outcome, Run};
use swarm::spec::{Method, RunSpec, Training};

/// Runs a short one to its end.
pub fn explore() -> Result<Outcome, Box<dyn Error>> {
    let mut spec = RunSpec::new(
        Method::EvIterC,
        Arc::new(arenas::builtin("maze").ok_or("no such arena")?),
    );
    let arena = Arc::new(arenas::builtin("easy").ok_or("no such arena")?);
    spec.controller.training = Some(Training { arena, epochs: 10 });
    (spec.epochs, spec.steps_per_epoch) = (5, 500);
    // The spec is wrong or right as a whole: errors name each field.
    let mut run = Run::new(spec.validate().map_err(refused)?).map_err(refused)?;
    while run.outcome().is_none() {
        let progress = run.advance(1_000);
        println!("{}: {} epochs", progress.phase.name(), progress.epochs_done);
    }
    run.outcome().ok_or_else(|| "not done".into())
}

fn refused(errors: Vec<swarm::spec::FieldError>) -> String {
    errors.iter().map(|error| format!("{error}\n")).collect()
}

/// Shows it.
pub fn main() -> Result<(), Box<dyn Error>> {
    let outcome = explore()?;
    let (entered, reachable) = (outcome.coverage_reachable[0], outcome.reachable);
    println!("{entered} of {reachable} squares within reach were entered");
    Ok(())
}
