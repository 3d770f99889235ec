//! A group against another.

use std::collections::BTreeMap;

use api::comparison::{Better, ComparedPair};
use api::summary::Interval;

use super::sets::Set;
use crate::statistics::{
    ALPHA, LEVEL, Tested, mean, pairs_needed, probability_above, rank_test, sign_flip_test,
    standard_error, t_interval, welch_interval,
};

/// Values of one stratum, of the first group and of the second.
type Strata = Vec<(Vec<f64>, Vec<f64>)>;

/// `family` is the number of pairs that are tested together. Correction and words are still to come.
pub fn pair(
    sets: [&Set; 2],
    [first, second]: [usize; 2],
    better: Option<Better>,
    family: usize,
) -> ComparedPair {
    let [one, other] = sets;
    let twins: Vec<[Option<f64>; 2]> = one
        .runs
        .iter()
        .filter_map(|(key, value)| Some([*value, *other.runs.get(key)?]))
        .collect();
    // Where the seeds are not the same ones, what few pairs there are would leave most runs out.
    let paired = 2 * twins.len() >= one.runs.len().min(other.runs.len()) && !twins.is_empty();
    let figures = if paired {
        of_pairs(&twins)
    } else {
        of_samples(one, other)
    };
    let improvement = probability_above(&strata(sets, better));
    let spread = figures.spread.filter(|_| figures.difference.is_some());
    ComparedPair {
        first,
        second,
        paired,
        n: figures.n as u64,
        missed: figures.missed as u64,
        difference: figures.difference,
        interval: figures.interval.map(Into::into),
        improvement: improvement.map(|(share, _)| share),
        improvement_interval: improvement.map(|(_, [low, high])| Interval {
            low,
            high,
            level: LEVEL,
            method: "Newcombe".to_owned(),
        }),
        p: figures.tested.map(|tested| tested.p),
        test: figures.tested.map(|tested| tested.method.to_owned()),
        p_holm: None,
        differs: false,
        runs_needed: figures.difference.zip(spread).and_then(|(difference, sd)| {
            pairs_needed(difference, sd, ALPHA / family.max(1) as f64)
        }),
        sentence: String::new(),
    }
}

struct Figures {
    n: usize,
    missed: usize,
    difference: Option<f64>,
    interval: Option<crate::statistics::Interval>,
    /// Standard deviation of the difference of two runs.
    spread: Option<f64>,
    tested: Option<Tested>,
}

fn of_pairs(twins: &[[Option<f64>; 2]]) -> Figures {
    let complete: Vec<f64> = twins
        .iter()
        .filter_map(|[one, other]| Some((*one)? - (*other)?))
        .collect();
    let missed = twins.len() - complete.len();
    let tested = if missed == 0 {
        sign_flip_test(&complete)
    } else {
        // Never is later than any time: only who was first can be compared.
        let order = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
        let signs: Vec<f64> = twins
            .iter()
            .map(|[one, other]| match order(*one).total_cmp(&order(*other)) {
                std::cmp::Ordering::Less => -1.0,
                std::cmp::Ordering::Equal => 0.0,
                std::cmp::Ordering::Greater => 1.0,
            })
            .collect();
        sign_flip_test(&signs).map(|tested| Tested {
            p: tested.p,
            method: "sign test",
        })
    };
    Figures {
        n: twins.len(),
        missed,
        difference: mean(&complete),
        interval: t_interval(&complete),
        spread: standard_error(&complete).map(|error| error * (complete.len() as f64).sqrt()),
        tested,
    }
}

fn of_samples(one: &Set, other: &Set) -> Figures {
    let complete = |set: &Set| set.runs.values().copied().flatten().collect::<Vec<f64>>();
    let all = |set: &Set| {
        let values = set.runs.values();
        values
            .map(|value| value.unwrap_or(f64::INFINITY))
            .collect::<Vec<f64>>()
    };
    let (x, y) = (complete(one), complete(other));
    let deviation = |values: &[f64]| Some(standard_error(values)? * (values.len() as f64).sqrt());
    Figures {
        n: one.runs.len().min(other.runs.len()),
        missed: one.runs.len() + other.runs.len() - x.len() - y.len(),
        difference: mean(&x).zip(mean(&y)).map(|(x, y)| x - y),
        interval: welch_interval(&x, &y),
        spread: deviation(&x).zip(deviation(&y)).map(|(x, y)| x.hypot(y)),
        // Ranks, as never is a rank too.
        tested: rank_test(&ranks(&all(one)), &ranks(&all(other))),
    }
}

/// Finite values in the order of the given ones.
fn ranks(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value.min(f64::MAX)).collect()
}

/// The values of each stratum that both have, the better ones higher; never is worst.
fn strata([one, other]: [&Set; 2], better: Option<Better>) -> Strata {
    let sign = if better == Some(Better::Lower) {
        -1.0
    } else {
        1.0
    };
    let mut strata: BTreeMap<&str, (Vec<f64>, Vec<f64>)> = BTreeMap::new();
    let value = |value: &Option<f64>| match (value, better) {
        (Some(value), _) => Some(sign * value),
        (None, Some(Better::Lower)) => Some(f64::NEG_INFINITY),
        (None, _) => None,
    };
    for ((stratum, _), run) in &one.runs {
        strata.entry(stratum).or_default().0.extend(value(run));
    }
    for ((stratum, _), run) in &other.runs {
        strata.entry(stratum).or_default().1.extend(value(run));
    }
    strata.into_values().collect()
}
