//! What sharing changes, all else equal: runs paired by seed.

use api::summary::{Sharing, SharingPoint};
use serde_json::Value;

use super::groups::measure;
use super::{Combination, alike, axis_of, values};
use crate::documents::Design;
use crate::statistics::{mean, t_interval};

/// Fewest pairs from which something is said.
const FEWEST_PAIRS: usize = 3;
const MODE: &str = "sharing.mode";

pub fn sharing(design: &Design, combinations: &[Combination<'_>]) -> Vec<Sharing> {
    let Some(axis) = axis_of(design, MODE) else {
        return Vec::new();
    };
    let mode =
        |combination: &Combination<'_>| match values(design, &combination.indices, &[]).get(MODE) {
            Some(Value::String(mode)) => mode.clone(),
            _ => String::new(),
        };
    let robots_axis = axis_of(design, "robots");
    let varying: Vec<usize> = std::iter::once(axis).chain(robots_axis).collect();
    let mut modes: Vec<String> = Vec::new();
    for combination in combinations {
        let mode = mode(combination);
        if mode != "none" && !modes.contains(&mode) {
            modes.push(mode);
        }
    }
    let mut found = Vec::new();
    for set in alike(combinations, &varying) {
        for wanted in &modes {
            let mut points: Vec<SharingPoint> = Vec::new();
            for with in set.iter().filter(|with| mode(with) == *wanted) {
                let without = set
                    .iter()
                    .find(|without| mode(without) == "none" && without.robots == with.robots);
                points.extend(without.map(|without| point(with, without)));
            }
            if points.is_empty() {
                continue;
            }
            points.sort_by_key(|point| point.robots);
            found.push(Sharing {
                mode: wanted.clone(),
                values: values(design, &set[0].indices, &varying),
                verdict: verdict(wanted, &points),
                points,
            });
        }
    }
    found
}

fn point(with: &Combination<'_>, without: &Combination<'_>) -> SharingPoint {
    let differences: Vec<f64> = with
        .runs
        .iter()
        .filter_map(|run| {
            let twin = without.runs.iter().find(|twin| twin.seed == run.seed)?;
            Some(measure(run, "mean_coverage")? - measure(twin, "mean_coverage")?)
        })
        .collect();
    let interval = t_interval(&differences);
    let verdict = match interval {
        _ if differences.len() < FEWEST_PAIRS => "too few seeds",
        Some(interval) if interval.low > 0.0 => "helps",
        Some(interval) if interval.high < 0.0 => "hurts",
        _ => "no difference found",
    };
    SharingPoint {
        robots: with.robots,
        pairs: differences.len() as u64,
        difference: mean(&differences),
        interval: interval.map(Into::into),
        verdict: verdict.to_owned(),
    }
}

/// The least number of robots at which, and at all larger ones that were tried, sharing helps.
fn verdict(mode: &str, points: &[SharingPoint]) -> String {
    let helping = points
        .iter()
        .rev()
        .take_while(|point| point.verdict == "helps");
    match helping.last() {
        Some(point) => format!(
            "sharing ({mode}) helps from {} robots on, up to the {} tried",
            point.robots,
            points.last().map_or(0, |last| last.robots)
        ),
        None => format!("no N from which on sharing ({mode}) helps was found"),
    }
}
