//! Runs of a job that stand out: by what they covered against the others of their group, or because
//! what explains them calls them odd.

use api::summary::OddRun;

use super::combinations::{Combination, Told};
use crate::statistics::median;

/// Runs that are listed.
const MOST: usize = 100;
/// Runs of a group from which on it has outliers.
const LEAST_RUNS: usize = 5;
/// Iglewicz and Hoaglin (1993): a modified z-score beyond 3.5 is one of an outlier.
const OUTLIER: f64 = 3.5;
const NORMAL: f64 = 0.6745;

/// The runs of a part that stand out; `labels` begins with those of its combinations. `told` is what
/// is known of why the run at a place did what it did.
pub fn odd_runs<'a>(
    labels: &[String],
    combinations: &[Combination<'_>],
    told: impl Fn(u64) -> Option<&'a Told>,
) -> Vec<OddRun> {
    let mut odd = Vec::new();
    for (number, combination) in combinations.iter().enumerate() {
        let p1: Vec<f64> = (combination.runs.iter())
            .map(|run| f64::from(run.result.p1))
            .collect();
        if p1.is_empty() {
            continue;
        }
        let middle = median(&p1);
        let distances: Vec<f64> = p1.iter().map(|p1| (p1 - middle).abs()).collect();
        let spread = median(&distances);
        let has_outliers = p1.len() >= LEAST_RUNS && spread > 0.0;
        for (run, p1) in combination.runs.iter().zip(p1) {
            let score = has_outliers.then(|| NORMAL * (p1 - middle) / spread);
            let is_outlier = score.is_some_and(|score| score.abs() > OUTLIER);
            let told = told(run.place);
            if is_outlier || told.is_some_and(|told| told.is_odd) {
                odd.push(OddRun {
                    run_id: run.id.clone(),
                    index: run.place,
                    label: labels.get(number).cloned().unwrap_or_default(),
                    seed: run.seed,
                    p1: run.result.p1,
                    median_p1: middle,
                    score,
                    is_outlier,
                    explanation: told.map(|told| told.sentence.clone()),
                });
            }
        }
    }
    odd
}

/// Those of all parts, what covered least first.
pub fn in_order(mut odd: Vec<OddRun>) -> Vec<OddRun> {
    let far = |run: &OddRun| run.score.unwrap_or(0.0);
    odd.sort_by(|a, b| far(a).total_cmp(&far(b)).then(a.index.cmp(&b.index)));
    odd.truncate(MOST);
    odd
}
