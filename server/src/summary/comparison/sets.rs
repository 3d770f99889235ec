//! The groups that are compared: their runs, each with the key of those it is paired with.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::ComparisonError;
use crate::documents::Design;
use crate::summary::groups::measure;
use crate::summary::{Input, axis_of, combinations, values};

/// A group.
pub struct Set {
    /// What its runs have in common, in words.
    pub label: String,
    /// The same by dotted path.
    pub values: BTreeMap<String, Value>,
    /// By stratum (what else the job varies, as text) and seed; `None` for a run without the measure.
    pub runs: BTreeMap<(String, u64), Option<f64>>,
    /// Place in the job and seed of each run, in order.
    pub places: Vec<(u64, u64)>,
}

impl Set {
    /// The values that there are, stratum by stratum.
    pub fn strata(&self) -> Vec<Vec<f64>> {
        let mut strata: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for ((stratum, _), value) in &self.runs {
            strata.entry(stratum).or_default().extend(value);
        }
        strata.into_values().collect()
    }
}

/// The groups of a job, in the order of its runs; at most so many.
pub fn sets(
    input: &Input,
    name: &str,
    by: Option<&str>,
    most: usize,
) -> Result<Vec<Set>, ComparisonError> {
    let known = varied(input);
    if let Some(asked) = by.filter(|by| !known.contains(*by)) {
        return Err(ComparisonError::By {
            asked: asked.to_owned(),
            known: listed(&known),
        });
    }
    let mut sets: Vec<Set> = Vec::new();
    let mut number = 0;
    for (design, &robots) in input.designs.iter().zip(&input.robots) {
        let combinations = combinations(input, design, robots, number);
        if by.is_none() && sets.len() + combinations.len() > most {
            return Err(ComparisonError::Groups {
                groups: input.designs.iter().map(Design::combinations).sum(),
                most,
                known: listed(&known),
            });
        }
        for combination in combinations {
            let all = values(design, &combination.indices, &[]);
            let (own, rest) = match by {
                Some(by) => split(design, &combination.indices, all, by),
                None => (all, BTreeMap::new()),
            };
            let stratum = Value::from_iter(rest).to_string();
            let found = sets
                .iter_mut()
                .position(|set| by.is_some() && set.values == own);
            let label = match by {
                Some(by) => own.get(by).map_or(String::new(), plain),
                None => input.labels.get(number).cloned().unwrap_or_default(),
            };
            number += 1;
            let found = found.unwrap_or_else(|| {
                sets.push(Set {
                    label,
                    values: own,
                    runs: BTreeMap::new(),
                    places: Vec::new(),
                });
                sets.len() - 1
            });
            if sets.len() > most {
                return Err(ComparisonError::Groups {
                    groups: sets.len(),
                    most,
                    known: listed(&known),
                });
            }
            for run in combination.runs {
                let value = measure(run, name).filter(|value| value.is_finite());
                sets[found].places.push((run.place, run.seed));
                sets[found].runs.insert((stratum.clone(), run.seed), value);
            }
        }
    }
    Ok(sets)
}

/// What a field has in a combination (with what varies along), and all else that the job varies.
fn split(
    design: &Design,
    indices: &[usize],
    mut all: BTreeMap<String, Value>,
    by: &str,
) -> (BTreeMap<String, Value>, BTreeMap<String, Value>) {
    let axis = axis_of(design, by);
    let along = axis
        .map(|axis| design.axes[axis].paths.as_slice())
        .unwrap_or_default();
    let mut rest = values(design, indices, axis.as_slice());
    if by == "part" {
        rest.remove(by);
    }
    all.retain(|path, _| path == by || along.contains(path));
    (all, rest)
}

/// Every field that the job varies.
fn varied(input: &Input) -> BTreeSet<String> {
    let designs = input.designs.iter();
    let axes = designs.clone().flat_map(|design| &design.axes);
    axes.flat_map(|axis| axis.paths.iter().cloned())
        .chain(designs.filter_map(|design| design.part.as_ref().map(|_| "part".to_owned())))
        .collect()
}

fn listed(known: &BTreeSet<String>) -> String {
    if known.is_empty() {
        return "nothing".to_owned();
    }
    known
        .iter()
        .map(String::as_str)
        .collect::<Vec<_>>()
        .join(", ")
}

fn plain(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}
