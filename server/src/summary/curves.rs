//! Coverage over epochs, pooled by group: means with pointwise bands, over all runs of a group.

use api::SCHEMA;
use api::curves::{GroupCurves, JobCurves, RunCurve};

use super::Input;
use super::comparison::{ComparisonError, Set, sets};
use crate::statistics::{LEVEL, mean, mean_interval, median};

/// Most runs whose curves are read for one answer.
pub const MOST_RUNS: usize = 5_000;
/// Most groups that have curves.
pub const MOST_GROUPS: usize = 200;
/// Most single runs of a group that are shown.
const MOST_SINGLE_RUNS: usize = 50;

/// What curves can show.
pub const MEASURES: [&str; 8] = [
    "p1",
    "p2",
    "p5",
    "p10",
    "p1_fraction",
    "p2_fraction",
    "p5_fraction",
    "p10_fraction",
];

/// Which curves are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// One of [`MEASURES`].
    pub measure: &'a str,
    /// A varied field whose values are the groups.
    pub by: Option<&'a str>,
    /// Most abscissae.
    pub points: usize,
    /// Whether single runs are shown too.
    pub runs: bool,
}

/// Why there are no such curves.
#[derive(Debug, thiserror::Error)]
pub enum CurvesError<E: std::error::Error> {
    /// The groups cannot be made.
    #[error(transparent)]
    Groups(#[from] ComparisonError),
    /// There are more runs than are read for one answer.
    #[error("the job has {0} finished runs; curves are pooled of at most {MOST_RUNS}")]
    Runs(usize),
    /// A curve cannot be read.
    #[error(transparent)]
    Curve(E),
}

/// The curves of a job whose longest finished run has `epochs`. `curve` gives, for the run at a
/// place, the measure after each epoch from the first on.
///
/// # Errors
/// The groups cannot be made, there are too many runs, or a curve cannot be read.
pub fn curves<E: std::error::Error>(
    input: &Input,
    wanted: Wanted<'_>,
    epochs: u32,
    mut curve: impl FnMut(u64) -> Result<Vec<f64>, E>,
) -> Result<JobCurves, CurvesError<E>> {
    if input.finished.len() > MOST_RUNS {
        return Err(CurvesError::Runs(input.finished.len()));
    }
    let at = abscissae(epochs, wanted.points);
    let mut groups = Vec::new();
    for set in sets(input, wanted.measure, wanted.by, MOST_GROUPS)? {
        let mut runs = Vec::with_capacity(set.places.len());
        for &(place, seed) in &set.places {
            let values = curve(place).map_err(CurvesError::Curve)?;
            runs.push(RunCurve {
                seed,
                values: at
                    .iter()
                    .map(|&epoch| values.get(epoch as usize - 1).copied())
                    .collect(),
            });
        }
        groups.push(group(set, runs, at.len(), wanted.runs));
    }
    Ok(JobCurves {
        schema: SCHEMA,
        job_id: input.job_id.clone(),
        name: input.name.clone(),
        measure: wanted.measure.to_owned(),
        x: "epoch".to_owned(),
        by: wanted.by.map(str::to_owned),
        level: LEVEL,
        at,
        groups,
    })
}

/// Evenly from the first epoch to the last, each once.
fn abscissae(epochs: u32, points: usize) -> Vec<u32> {
    let (last, points) = (u64::from(epochs), points.max(2) as u64);
    if last <= points {
        return (1..=epochs).collect();
    }
    let place = |point: u64| 1 + point * (last - 1) / (points - 1);
    (0..points).map(|point| place(point) as u32).collect()
}

fn group(set: Set, mut runs: Vec<RunCurve>, points: usize, show_runs: bool) -> GroupCurves {
    let mut group = GroupCurves {
        label: set.label,
        values: set.values,
        runs_done: runs.len() as u64,
        n: Vec::with_capacity(points),
        mean: Vec::with_capacity(points),
        low: Vec::with_capacity(points),
        high: Vec::with_capacity(points),
        median: Vec::with_capacity(points),
        runs: Vec::new(),
    };
    for point in 0..points {
        let values: Vec<f64> = runs.iter().filter_map(|run| run.values[point]).collect();
        let interval = mean_interval(&values);
        group.n.push(values.len() as u64);
        group.mean.push(mean(&values));
        group.low.push(interval.map(|interval| interval.low));
        group.high.push(interval.map(|interval| interval.high));
        let median = (!values.is_empty()).then(|| median(&values));
        group.median.push(median);
    }
    if show_runs {
        runs.truncate(MOST_SINGLE_RUNS);
        group.runs = runs;
    }
    group
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::convert::Infallible;

    use serde_json::json;

    use super::*;
    use crate::summary::tests::{axis, finished, input};

    fn wanted(runs: bool) -> Wanted<'static> {
        Wanted {
            measure: "p1",
            by: None,
            points: 3,
            runs,
        }
    }

    #[test]
    fn curves_are_pooled_over_all_runs_of_a_group() {
        let runs = (0..6).map(|place| finished(place, place % 3, None, 0.5));
        let axes = vec![axis(&["epochs"], json!([[3], [5]]))];
        let job = input(3, axes, runs.collect());
        // Runs of the first group stop at 3 epochs; each grows by its place.
        let curve = |place: u64| {
            let epochs = if place < 3 { 3 } else { 5 };
            Ok::<_, Infallible>(
                (1..=epochs)
                    .map(|epoch| f64::from(epoch * (1 + place as u32)))
                    .collect(),
            )
        };
        let pooled = curves(&job, wanted(true), 5, curve).unwrap();
        assert_eq!((pooled.at.clone(), pooled.groups.len()), (vec![1, 3, 5], 2));
        let [short, long] = &pooled.groups[..] else {
            panic!()
        };
        assert_eq!((&short.n, &long.n), (&vec![3, 3, 0], &vec![3, 3, 3]));
        assert_eq!(short.mean, [Some(2.0), Some(6.0), None]);
        assert_eq!(long.median[2], Some(25.0));
        assert!(short.low[0].unwrap() < 2.0 && short.high[0].unwrap() > 2.0);
        assert_eq!((short.low[2], short.runs.len()), (None, 3));
        assert_eq!(short.runs[1].values, [Some(2.0), Some(6.0), None]);
        let without = curves(&job, wanted(false), 5, curve).unwrap();
        assert!(without.groups[0].runs.is_empty());
        let none = curves(&input(1, Vec::new(), Vec::new()), wanted(true), 0, curve).unwrap();
        assert!(none.at.is_empty() && none.groups[0].mean.is_empty());
    }

    #[test]
    fn abscissae_are_first_and_last_and_between() {
        assert_eq!(abscissae(4, 200), [1, 2, 3, 4]);
        assert_eq!(abscissae(1_000, 3), [1, 500, 1_000]);
        let many = abscissae(u32::MAX, 500);
        assert!(many.len() == 500 && many.last() == Some(&u32::MAX));
        assert!(many.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
