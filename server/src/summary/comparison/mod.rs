//! Every group of a job against every other: differences paired by seed, tests, and which is best.
//! Methods and reasons: `docs/statistics.md`.

mod error;
mod pair;
mod sets;
mod table;
#[cfg(test)]
mod tests;
mod words;

use api::SCHEMA;
use api::comparison::{Better, ComparedGroup, Comparison};

pub use error::{ComparisonError, MOST_GROUPS};
pub use sets::{Set, sets};
pub use table::{csv, markdown};

use super::Input;
use super::groups::{is_time, known_measures};
use crate::statistics::{ALPHA, holm, iqm, iqm_interval, mean_interval, summary as moments};

/// What is compared if nothing is said: the share of the reachable squares that were entered.
pub const DEFAULT_MEASURE: &str = "p1_fraction";
/// Points of a performance profile.
const TAUS: usize = 51;

/// A job's groups by a measure; `by` is a varied field whose values are the groups.
///
/// # Errors
/// The measure or the field is not known, or there are too many groups.
pub fn comparison(
    input: &Input,
    measure: &str,
    by: Option<&str>,
) -> Result<Comparison, ComparisonError> {
    if !known_measures().any(|known| known == measure) {
        return Err(ComparisonError::Measure {
            asked: measure.to_owned(),
            known: known_measures().collect::<Vec<_>>().join(", "),
        });
    }
    let sets = sets(input, measure, by, MOST_GROUPS)?;
    let better = better(measure);
    let taus = taus(&sets);
    let groups: Vec<ComparedGroup> = sets
        .iter()
        .map(|set| group(set, measure, better, &taus))
        .collect();
    let places =
        (0..sets.len()).flat_map(|one| (one + 1..sets.len()).map(move |other| (one, other)));
    let family = sets.len() * sets.len().saturating_sub(1) / 2;
    let mut pairs: Vec<_> = places
        .map(|(one, other)| pair::pair([&sets[one], &sets[other]], [one, other], better, family))
        .collect();
    // A pair without a test is in no family.
    let tested: Vec<f64> = pairs.iter().filter_map(|pair| pair.p).collect();
    let mut corrected = holm(&tested).into_iter();
    for pair in &mut pairs {
        pair.p_holm = pair.p.and_then(|_| corrected.next());
        pair.differs = pair.p_holm.is_some_and(|p| p < ALPHA);
        if pair.differs {
            pair.runs_needed = None;
        }
        let labels = [pair.first, pair.second].map(|place| groups[place].label.as_str());
        pair.sentence = words::of_pair(pair, labels, measure);
    }
    let words::Verdict {
        best,
        sentence,
        runs_needed,
    } = words::verdict(&groups, &pairs, measure, better);
    Ok(Comparison {
        schema: SCHEMA,
        job_id: input.job_id.clone(),
        name: input.name.clone(),
        measure: measure.to_owned(),
        better,
        by: by.map(str::to_owned),
        alpha: ALPHA,
        groups,
        taus,
        pairs,
        best,
        verdict: sentence,
        runs_needed,
    })
}

/// What of a measure is better: coverage is, and what takes time or bumps is not.
fn better(measure: &str) -> Option<Better> {
    let higher = ["mean_coverage", "entropy"];
    let lower = ["collisions_per_robot_step", "cpu_ns_per_robot_step"];
    let squares = ["p1", "p2", "p5", "p10"];
    let level = measure.strip_suffix("_fraction").unwrap_or(measure);
    if squares.contains(&level) || higher.contains(&measure) {
        Some(Better::Higher)
    } else if lower.contains(&measure) || is_time(measure) {
        Some(Better::Lower)
    } else {
        None
    }
}

fn group(set: &Set, measure: &str, better: Option<Better>, taus: &[f64]) -> ComparedGroup {
    let strata = set.strata();
    let values: Vec<f64> = strata.concat();
    let moments = (!values.is_empty()).then(|| moments(&values));
    let runs = set.runs.len();
    let share = |count: usize| count as f64 / runs.max(1) as f64;
    ComparedGroup {
        label: set.label.clone(),
        values: set.values.clone(),
        runs_done: runs as u64,
        n: values.len() as u64,
        missed: is_time(measure).then(|| (runs - values.len()) as u64),
        mean: moments.map(|moments| moments.mean),
        sd: moments
            .filter(|_| values.len() > 1)
            .map(|moments| moments.sd),
        median: moments.map(|moments| moments.median),
        interval: mean_interval(&values).map(Into::into),
        iqm: iqm(&values),
        iqm_interval: iqm_interval(&strata).map(Into::into),
        profile: taus
            .iter()
            .map(|tau| {
                let within = values.iter().filter(|value| match better {
                    Some(Better::Lower) => *value <= tau,
                    _ => *value > tau,
                });
                share(within.count())
            })
            .collect(),
    }
}

/// Even from the lowest to the highest value of any run.
fn taus(sets: &[Set]) -> Vec<f64> {
    let values = || sets.iter().flat_map(|set| set.strata().concat());
    let Some(low) = values().min_by(f64::total_cmp) else {
        return Vec::new();
    };
    let high = values().max_by(f64::total_cmp).unwrap_or(low);
    if low == high {
        return vec![low];
    }
    let step = (high - low) / (TAUS - 1) as f64;
    (0..TAUS).map(|place| low + step * place as f64).collect()
}
