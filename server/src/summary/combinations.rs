//! What is summed up: a job's finished runs, and its combinations with theirs.

use std::collections::BTreeMap;

use api::RunResult;
use serde_json::Value;

use crate::documents::{Design, indices_at};
use crate::statistics::{Interval, LEVEL};

/// A finished run of a job.
#[derive(Clone, Debug)]
pub struct FinishedRun {
    /// Hash of its spec, in hex.
    pub id: String,
    /// Place in the job.
    pub place: u64,
    /// Which of the job's combinations it has, counted part by part.
    pub combination: usize,
    /// Seed.
    pub seed: u64,
    /// What it found.
    pub result: RunResult,
    /// Processor time a robot-step, nanoseconds.
    pub cpu_ns_per_robot_step: Option<f64>,
}

/// Times of first entries (1 + steps, 0 for never) of the squares within reach, and their number.
pub type FirstEntries = (Vec<u64>, u32);

impl From<Interval> for api::summary::Interval {
    fn from(interval: Interval) -> Self {
        Self {
            low: interval.low,
            high: interval.high,
            level: LEVEL,
            method: interval.method.to_owned(),
        }
    }
}

/// Why a run did what it did, in short.
#[derive(Clone, Debug)]
pub struct Told {
    /// Whether that is odd.
    pub is_odd: bool,
    /// In words.
    pub sentence: String,
}

/// What is summed up.
#[derive(Clone, Debug)]
pub struct Input {
    /// Id of the job.
    pub job_id: String,
    /// Its name.
    pub name: String,
    /// What it varies, part by part.
    pub designs: Vec<Design>,
    /// Runs in all.
    pub runs: u64,
    /// A label for each combination, part by part.
    pub labels: Vec<String>,
    /// Runs of each combination, done or not; of those that were deleted nothing is known.
    pub counts: Vec<u64>,
    /// Robots of each part where its design does not vary them; 0 for one that has no run any more.
    pub robots: Vec<u32>,
    /// The runs that are done, in order.
    pub finished: Vec<FinishedRun>,
    /// By their places, what is known of why they did what they did.
    pub told: BTreeMap<u64, Told>,
}

/// A combination with its finished runs.
pub struct Combination<'a> {
    /// Index into each axis.
    pub indices: Vec<usize>,
    /// Robots.
    pub robots: u32,
    /// Its finished runs.
    pub runs: Vec<&'a FinishedRun>,
}

/// The combinations of a part, which are those of the job from `first` on.
pub fn combinations<'a>(
    input: &'a Input,
    design: &Design,
    robots: u32,
    first: usize,
) -> Vec<Combination<'a>> {
    let axes = &design.axes;
    let mut combinations: Vec<Combination<'_>> = (0..design.combinations())
        .map(|place| {
            let indices = indices_at(axes.iter().map(|axis| axis.values.len()), place);
            let values = values(design, &indices, &[]);
            let varied = values.get("robots").and_then(Value::as_f64);
            Combination {
                indices,
                robots: varied.map_or(robots, |robots| robots as u32),
                runs: Vec::new(),
            }
        })
        .collect();
    for run in &input.finished {
        let number = run.combination.checked_sub(first);
        if let Some(combination) = number.and_then(|number| combinations.get_mut(number)) {
            combination.runs.push(run);
        }
    }
    combinations
}

/// What a combination has of the matrix by dotted path, but for some axes; and its part's name.
pub fn values(design: &Design, indices: &[usize], without: &[usize]) -> BTreeMap<String, Value> {
    let part = design
        .part
        .iter()
        .map(|name| ("part".to_owned(), Value::from(name.as_str())));
    let axes = design.axes.iter().zip(indices).enumerate();
    axes.filter(|(number, _)| !without.contains(number))
        .flat_map(|(_, (axis, &index))| axis.paths.iter().cloned().zip(axis.values[index].clone()))
        .chain(part)
        .collect()
}

/// Combinations that differ in some axes alone, in order.
pub fn alike<'a, 'b>(
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
pub fn axis_of(design: &Design, path: &str) -> Option<usize> {
    design
        .axes
        .iter()
        .position(|axis| axis.paths.iter().any(|known| known == path))
}
