//! From a question of the simulator to the answer of a controller in another process, as the run's
//! thread sees it.
#![allow(clippy::print_stdout, reason = "the table is the program's output")]

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use serde_json::json;
use server::channels::External;
use swarm::methods::BRAITENBERG_WEIGHTS;
use swarm::run::Run;

use super::options::{Options, spec};
use super::others::Other;
use crate::measure::quantile;

/// A Braitenberg vehicle for all robots at once, in Python.
fn python_program() -> String {
    format!(
        r"
import sys
from pathlib import Path
import numpy as np
from evswarm.channels import Controller, steer

WEIGHTS = np.array({BRAITENBERG_WEIGHTS:?}, np.float32)

class Braitenberg(Controller):
    def act(self, readings):
        part = np.float32(1) - readings.sensors / np.float32(512)
        return np.clip(np.float32(0.5) * (part @ WEIGHTS), -1, 1)

steer(sys.argv[1], Braitenberg(), root=Path(sys.argv[2]), idle_s=600)
"
    )
}

pub fn print(options: &Options) -> Result<()> {
    let robots = match options.robots.is_empty() {
        true => vec![1, 100, 1_000, 10_000],
        false => options.robots.clone(),
    };
    println!("| Robots | Controller in | p50, us | p99, us | Questions |\n|---|---|---|---|---|");
    for &robots in &robots {
        measure(options, robots, "Rust", |name, root| {
            Other::start("controller", name, root)
        })?;
        if let Some(program) = &options.c {
            measure(options, robots, "C", |name, root| {
                // It looks under the user's root, which is a folder within this one.
                let home = root.parent().context("a root has a parent")?;
                Other::of(Command::new(program).arg(name).env("XDG_RUNTIME_DIR", home))
            })?;
        }
        if let Some(python) = &options.python {
            measure(options, robots, "Python", |name, root| {
                let program = python_program();
                Other::of(Command::new(python).args(["-c", &program, name]).arg(root))
            })?;
        }
    }
    Ok(())
}

fn measure(
    options: &Options,
    robots: u64,
    language: &str,
    start: impl FnOnce(&str, &Path) -> Result<Other>,
) -> Result<()> {
    let method = json!({ "method": "external", "deadline_ms": 60_000 });
    let spec = spec(robots, &method)?.run_spec();
    let mut run = Run::new(spec.clone()).map_err(|errors| anyhow!("{errors:?}"))?;
    let home = tempfile::tempdir()?;
    let root = home.path().join("evswarm");
    let external = External::open(&root, "measured", &spec)?;
    let mut external = external.context("the run is not steered from outside")?;
    let _controller = start("measured", &root)?;
    let mut took_us = Vec::new();
    let seconds = options.seconds * options.rounds.max(1) as f64;
    let mut ask = |run: &mut Run| -> Result<f64> {
        let asked = Instant::now();
        external.steer(run, &())?;
        let took = asked.elapsed().as_secs_f64() * 1e6;
        run.advance(1);
        Ok(took)
    };
    // The first wait for the controller to come, and for memory to be touched.
    for _ in 0..100 {
        ask(&mut run)?;
    }
    let since = Instant::now();
    while since.elapsed().as_secs_f64() < seconds {
        took_us.push(ask(&mut run)?);
    }
    took_us.sort_by(f64::total_cmp);
    println!(
        "| {robots} | {language} | {:.1} | {:.1} | {} |",
        quantile(&took_us, 0.5),
        quantile(&took_us, 0.99),
        took_us.len(),
    );
    Ok(())
}
