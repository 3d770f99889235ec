//! A job's runs pooled over seeds: measures by combination, scaling over robots, and what sharing
//! changes. Formulas and rules: `docs/metrics.md`.

mod groups;
mod scaling;
mod sharing;
mod table;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use api::{JobSummary, RunResult, SCHEMA};
use serde_json::Value;

pub use table::{csv, markdown};

use crate::spec::{Design, indices_at};

/// A finished run of a job.
#[derive(Clone, Debug)]
pub struct FinishedRun {
    /// Place in the job.
    pub place: u64,
    /// Seed.
    pub seed: u64,
    /// What it found.
    pub result: RunResult,
    /// Processor time a robot-step, nanoseconds.
    pub cpu_ns_per_robot_step: Option<f64>,
}

/// Times of first entries (1 + steps, 0 for never) of the squares within reach, and their number.
pub type FirstEntries = (Vec<u64>, u32);

/// What is summed up.
#[derive(Clone, Debug)]
pub struct Input {
    /// Id of the job.
    pub job_id: String,
    /// Its name.
    pub name: String,
    /// What it varies.
    pub design: Design,
    /// Runs in all.
    pub runs: u64,
    /// A label for each combination.
    pub labels: Vec<String>,
    /// Robots where the design does not vary them.
    pub robots: u32,
    /// The runs that are done, in order.
    pub finished: Vec<FinishedRun>,
}

/// A combination with its finished runs.
struct Combination<'a> {
    /// Index into each axis.
    indices: Vec<usize>,
    robots: u32,
    runs: Vec<&'a FinishedRun>,
}

/// The summary of a job. `first_entries` gives them for the run at a place.
pub fn summary(
    input: &Input,
    first_entries: impl FnMut(u64) -> Option<FirstEntries>,
) -> JobSummary {
    let combinations = combinations(input);
    JobSummary {
        schema: SCHEMA,
        job_id: input.job_id.clone(),
        name: input.name.clone(),
        runs: input.runs,
        runs_done: input.finished.len() as u64,
        groups: groups::groups(input, &combinations),
        scaling: scaling::scaling(&input.design, &combinations, first_entries),
        sharing: sharing::sharing(&input.design, &combinations),
    }
}

fn combinations(input: &Input) -> Vec<Combination<'_>> {
    let axes = &input.design.axes;
    let count: usize = axes.iter().map(|axis| axis.values.len()).product();
    let mut combinations: Vec<Combination<'_>> = (0..count)
        .map(|place| {
            let indices = indices_at(axes.iter().map(|axis| axis.values.len()), place);
            let values = values(&input.design, &indices, &[]);
            let robots = values.get("robots").and_then(Value::as_f64);
            Combination {
                indices,
                robots: robots.map_or(input.robots, |robots| robots as u32),
                runs: Vec::new(),
            }
        })
        .collect();
    let seeds = input.design.seeds.max(1) as u64;
    for run in &input.finished {
        if let Some(combination) = combinations.get_mut((run.place / seeds) as usize) {
            combination.runs.push(run);
        }
    }
    combinations
}

/// What a combination has of the matrix by dotted path, but for some axes.
fn values(design: &Design, indices: &[usize], without: &[usize]) -> BTreeMap<String, Value> {
    let axes = design.axes.iter().zip(indices).enumerate();
    axes.filter(|(number, _)| !without.contains(number))
        .flat_map(|(_, (axis, &index))| axis.paths.iter().cloned().zip(axis.values[index].clone()))
        .collect()
}

/// Combinations that differ in some axes alone, in order.
fn alike<'a, 'b>(
    combinations: &'b [Combination<'a>],
    but_for: &[usize],
) -> Vec<Vec<&'b Combination<'a>>> {
    let mut sets: BTreeMap<Vec<usize>, Vec<&Combination<'a>>> = BTreeMap::new();
    for combination in combinations {
        let indices = combination.indices.iter().copied().enumerate();
        let key = indices
            .filter(|(axis, _)| !but_for.contains(axis))
            .map(|(_, index)| index)
            .collect();
        sets.entry(key).or_default().push(combination);
    }
    sets.into_values().collect()
}

/// The axis that holds a path.
fn axis_of(design: &Design, path: &str) -> Option<usize> {
    design
        .axes
        .iter()
        .position(|axis| axis.paths.iter().any(|known| known == path))
}
