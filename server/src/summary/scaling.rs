//! How coverage time changes with the number of robots.

use api::summary::{PowerLaw, Scaling, ScalingPoint, SpeedUp};
use swarm::metrics::time_to_cover;
use swarm::random::Stream;

use super::groups::measured;
use super::{Combination, FirstEntries, alike, axis_of, values};
use crate::documents::Design;
use crate::statistics::{mean, ratio_interval, slope_interval};

const TIMES: [(&str, u32); 3] = [("t50_steps", 50), ("t90_steps", 90), ("t99_steps", 99)];
/// Times that runs of one robot are drawn to stand for robots that do not meet.
const DRAWS: usize = 200;
/// Most runs of one robot that are drawn from.
const MOST_SINGLES: usize = 200;
/// Key of the stream of draws: the same runs give the same figures.
const KEY: u64 = 0x7363_616c_696e_6731;

pub fn scaling(
    design: &Design,
    combinations: &[Combination<'_>],
    mut first_entries: impl FnMut(u64) -> Option<FirstEntries>,
) -> Vec<Scaling> {
    let Some(axis) = axis_of(design, "robots") else {
        return Vec::new();
    };
    let linked = design.axes[axis].paths.len() > 1;
    let sets = alike(combinations, &[axis]).into_iter();
    sets.map(|mut set| {
        set.sort_by_key(|combination| combination.robots);
        let one = set.iter().find(|combination| combination.robots == 1);
        let singles: Vec<FirstEntries> = match one {
            // In an arena that grows along there is nothing to compare with.
            Some(one) if !linked => one
                .runs
                .iter()
                .take(MOST_SINGLES)
                .filter_map(|run| first_entries(run.place))
                .collect(),
            _ => Vec::new(),
        };
        let point = |combination: &&Combination<'_>| ScalingPoint {
            robots: combination.robots,
            cpu_ns_per_robot_step: mean(&measured(&combination.runs, "cpu_ns_per_robot_step")),
            times: TIMES
                .iter()
                .map(|&(name, percent)| {
                    let reference = one.map_or_else(Vec::new, |one| measured(&one.runs, name));
                    let independent = independent(&singles, combination.robots, percent);
                    let times = measured(&combination.runs, name);
                    speed_up(name, combination.robots, times, reference, independent)
                })
                .collect(),
        };
        Scaling {
            values: values(design, &set[0].indices, &[axis]),
            paths: design.axes[axis].paths.clone(),
            points: set.iter().map(point).collect(),
            fits: TIMES
                .iter()
                .filter_map(|(name, _)| power_law(name, &set))
                .collect(),
        }
    })
    .collect()
}

fn speed_up(
    name: &str,
    robots: u32,
    times: Vec<f64>,
    reference: Vec<f64>,
    independent_steps: Option<f64>,
) -> SpeedUp {
    let mean_steps = mean(&times);
    let n = times.len() as u64;
    let speed_up = mean_steps
        .filter(|&steps| steps > 0.0)
        .and_then(|steps| Some(mean(&reference)? / steps));
    SpeedUp {
        name: name.to_owned(),
        n,
        mean_steps,
        speed_up,
        speed_up_interval: ratio_interval(&reference, &times).map(Into::into),
        efficiency: speed_up.map(|speed_up| speed_up / f64::from(robots)),
        independent_steps,
        against_independent: independent_steps
            .zip(mean_steps)
            .filter(|&(_, steps)| steps > 0.0)
            .map(|(independent, steps)| independent / steps),
    }
}

/// Mean time of the union of `robots` runs of one robot, drawn without replacement; `None` where
/// there are too few, or where one union never gets there.
fn independent(singles: &[FirstEntries], robots: u32, percent: u32) -> Option<f64> {
    let robots = robots as usize;
    if robots > singles.len() {
        return None;
    }
    let mut stream = Stream::new(KEY);
    let mut order: Vec<usize> = (0..singles.len()).collect();
    let draws = if robots == singles.len() { 1 } else { DRAWS };
    let mut sum = 0.0;
    for _ in 0..draws {
        for place in 0..robots {
            let other = place + stream.below((order.len() - place) as u64) as usize;
            order.swap(place, other);
        }
        let chosen = &order[..robots];
        let (first, reachable) = &singles[chosen[0]];
        let union = (0..first.len()).map(|square| {
            let entries = chosen.iter().map(|&single| singles[single].0.get(square));
            let earliest = entries.flatten().copied().filter(|&first| first > 0).min();
            earliest.unwrap_or(0)
        });
        sum += time_to_cover(union, *reachable, percent)? as f64;
    }
    Some(sum / draws as f64)
}

/// The line through ln t over ln N.
struct Line {
    ln_a: f64,
    b: f64,
    /// Sum of the squares of ln N about its mean.
    spread: f64,
    /// Of ln t about the line.
    residual: f64,
}

/// `None` for fewer than two numbers of robots.
fn line(robots: &[f64], samples: &[Vec<f64>]) -> Option<Line> {
    let points = || {
        robots.iter().zip(samples).flat_map(|(robots, times)| {
            times
                .iter()
                .map(move |time| (robots.ln(), time.max(1.0).ln()))
        })
    };
    let n = points().count() as f64;
    let (x, y) = points().fold((0.0, 0.0), |(x, y), point| (x + point.0, y + point.1));
    let (x, y) = (x / n, y / n);
    let (xx, xy) = points().fold((0.0, 0.0), |(xx, xy), point| {
        let dx = point.0 - x;
        (xx + dx * dx, xy + dx * (point.1 - y))
    });
    // Equal numbers of robots differ by rounding alone.
    (xx > 1e-9).then(|| {
        let (ln_a, slope) = (y - xy / xx * x, xy / xx);
        Line {
            ln_a,
            b: -slope,
            spread: xx,
            residual: points()
                .map(|point| (point.1 - ln_a - slope * point.0).powi(2))
                .sum(),
        }
    })
}

fn power_law(name: &str, set: &[&Combination<'_>]) -> Option<PowerLaw> {
    let runs: usize = set.iter().map(|combination| combination.runs.len()).sum();
    let (robots, samples): (Vec<f64>, Vec<Vec<f64>>) = set
        .iter()
        .map(|combination| {
            let robots = f64::from(combination.robots);
            (robots, measured(&combination.runs, name))
        })
        .filter(|(_, times)| !times.is_empty())
        .unzip();
    let line = line(&robots, &samples)?;
    let n: usize = samples.iter().map(Vec::len).sum();
    Some(PowerLaw {
        name: name.to_owned(),
        a: line.ln_a.exp(),
        b: line.b,
        b_interval: slope_interval(line.b, line.residual, line.spread, n).map(Into::into),
        n: n as u64,
        missed: (runs - n) as u64,
    })
}
