//! Each combination's measures over its seeds.

use api::summary::{Group, Measure};

use super::{Combination, FinishedRun, values};
use crate::documents::Design;
use crate::statistics::{iqm, iqm_interval, mean_interval, summary as moments};

/// Shares of the reachable squares, beside the counts.
const FRACTIONS: [&str; 4] = ["p1_fraction", "p2_fraction", "p5_fraction", "p10_fraction"];

/// Every measure, in order: metrics, what they cost, and shares.
pub fn known_measures() -> impl Iterator<Item = &'static str> {
    let metrics = swarm::metrics::pooled();
    metrics.chain(["cpu_ns_per_robot_step"]).chain(FRACTIONS)
}

/// A measure of one run; `None` where it has none.
pub fn measure(run: &FinishedRun, name: &str) -> Option<f64> {
    let result = &run.result;
    match name {
        "p1" => Some(f64::from(result.p1)),
        "p2" => Some(f64::from(result.p2)),
        "p5" => Some(f64::from(result.p5)),
        "p10" => Some(f64::from(result.p10)),
        "p1_fraction" => Some(result.fractions.p1),
        "p2_fraction" => Some(result.fractions.p2),
        "p5_fraction" => Some(result.fractions.p5),
        "p10_fraction" => Some(result.fractions.p10),
        "collisions_per_robot_step" => {
            (result.steps > 0).then(|| result.collisions as f64 / result.steps as f64)
        }
        "cpu_ns_per_robot_step" => run.cpu_ns_per_robot_step,
        metric => result.metrics.as_ref()?.get(metric),
    }
}

/// A measure of those of some runs that have it.
pub fn measured(runs: &[&FinishedRun], name: &str) -> Vec<f64> {
    runs.iter().filter_map(|run| measure(run, name)).collect()
}

/// One group a combination of a part; `labels`, and `counts` of their runs, begin with those of the
/// part.
pub fn groups(
    design: &Design,
    labels: &[String],
    counts: &[u64],
    combinations: &[Combination<'_>],
) -> Vec<Group> {
    let all = combinations.iter().enumerate();
    all.map(|(number, combination)| Group {
        label: labels.get(number).cloned().unwrap_or_default(),
        values: values(design, &combination.indices, &[]),
        robots: combination.robots,
        runs: counts.get(number).copied().unwrap_or_default(),
        runs_done: combination.runs.len() as u64,
        measures: known_measures()
            .map(|name| pooled(name, &combination.runs))
            .collect(),
    })
    .collect()
}

/// Whether a measure is a time that a run may never get to.
pub fn is_time(name: &str) -> bool {
    name.ends_with("_steps")
}

fn pooled(name: &str, runs: &[&FinishedRun]) -> Measure {
    let values = measured(runs, name);
    let moments = (!values.is_empty()).then(|| moments(&values));
    Measure {
        name: name.to_owned(),
        n: values.len() as u64,
        missed: is_time(name).then(|| (runs.len() - values.len()) as u64),
        mean: moments.map(|moments| moments.mean),
        sd: moments
            .filter(|_| values.len() > 1)
            .map(|moments| moments.sd),
        median: moments.map(|moments| moments.median),
        interval: mean_interval(&values).map(Into::into),
        iqm: iqm(&values),
        iqm_interval: iqm_interval(&[values]).map(Into::into),
    }
}
