//! How often intervals hold what they are of, and how often a test finds what is not there, by
//! simulation. The table in `docs/statistics.md` is printed by the ignored test at the end.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use swarm::random::Stream;

use super::*;

const SIZES: [usize; 7] = [3, 4, 5, 7, 10, 15, 30];

/// A distribution of what a run covers, by its mean and how to draw from it.
#[derive(Clone, Copy)]
struct Shape {
    name: &'static str,
    mean: f64,
    draw: fn(&mut Stream) -> f64,
}

const NORMAL: Shape = Shape {
    name: "normal",
    mean: 0.0,
    draw: Stream::normal,
};

/// Skewness -1.1: as the most skewed groups of the reproduction that do not cover everything.
const SKEWED: Shape = Shape {
    name: "Beta(8, 1.5), skewed to the left",
    mean: 8.0 / 9.5,
    draw: |stream| {
        let (a, b) = (gamma(stream, 8.0), gamma(stream, 1.5));
        a / (a + b)
    },
};

/// Bounded on both sides, without tails.
const BOUNDED: Shape = Shape {
    name: "Beta(2, 2), bounded",
    mean: 0.5,
    draw: |stream| {
        let (a, b) = (gamma(stream, 2.0), gamma(stream, 2.0));
        a / (a + b)
    },
};

/// A fifth of the runs stays stuck in a part of the arena.
const STUCK: Shape = Shape {
    name: "a fifth of the runs stuck",
    mean: 0.8 * 0.85 + 0.2 * 0.55,
    draw: |stream| {
        let centre = if stream.uniform() < 0.2 { 0.55 } else { 0.85 };
        centre + 0.08 * stream.normal()
    },
};

const EXPONENTIAL: Shape = Shape {
    name: "exponential",
    mean: 1.0,
    draw: |stream| gamma(stream, 1.0),
};

/// Marsaglia and Tsang (2000); `shape` is at least 1.
fn gamma(stream: &mut Stream, shape: f64) -> f64 {
    let d = shape - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    loop {
        let x = stream.normal();
        let v = (1.0 + c * x).powi(3);
        if v > 0.0 && (1.0 - stream.uniform()).ln() < 0.5 * x * x + d - d * v + d * v.ln() {
            return d * v;
        }
    }
}

fn sample(stream: &mut Stream, shape: Shape, n: usize) -> Vec<f64> {
    (0..n).map(|_| (shape.draw)(stream)).collect()
}

/// Percent of `rounds` in which something is so.
fn percent(rounds: usize, key: u64, mut holds: impl FnMut(&mut Stream) -> bool) -> f64 {
    let mut stream = Stream::new(key);
    let held = (0..rounds).filter(|_| holds(&mut stream)).count();
    100.0 * held as f64 / rounds as f64
}

fn holds(interval: Option<Interval>, truth: f64) -> bool {
    interval.is_some_and(|interval| interval.low <= truth && truth <= interval.high)
}

fn of_mean(shape: Shape, n: usize, rounds: usize) -> f64 {
    percent(rounds, 100 + n as u64, |stream| {
        holds(mean_interval(&sample(stream, shape, n)), shape.mean)
    })
}

fn of_difference(shape: Shape, n: usize, rounds: usize) -> f64 {
    percent(rounds, 200 + n as u64, |stream| {
        holds(t_interval(&differences(stream, shape, n)), 0.0)
    })
}

fn differences(stream: &mut Stream, shape: Shape, n: usize) -> Vec<f64> {
    let draw = |stream: &mut Stream| (shape.draw)(stream);
    (0..n).map(|_| draw(stream) - draw(stream)).collect()
}

#[test]
fn intervals_of_means_hold_from_three_runs_on() {
    for shape in [NORMAL, SKEWED, BOUNDED] {
        for n in SIZES {
            let held = of_mean(shape, n, 5_000);
            assert!(
                (93.0..=97.0).contains(&held),
                "{} n = {n}: {held} %",
                shape.name
            );
        }
    }
}

#[test]
fn intervals_of_paired_differences_hold_from_three_pairs_on() {
    for shape in [NORMAL, SKEWED, STUCK] {
        for n in SIZES {
            let held = of_difference(shape, n, 20_000);
            assert!(
                (93.0..=97.0).contains(&held),
                "{} n = {n}: {held} %",
                shape.name
            );
        }
    }
}

/// Pairs of nothing: with the percentile bootstrap of three pairs, one in four was a difference.
#[test]
fn nothing_is_called_a_difference_at_most_once_in_twenty() {
    for shape in [NORMAL, SKEWED, STUCK] {
        for n in SIZES {
            let rounds = if n <= 10 { 10_000 } else { 500 };
            let found = percent(rounds, 300 + n as u64, |stream| {
                sign_flip_test(&differences(stream, shape, n)).unwrap().p < ALPHA
            });
            let most = if n <= 10 { 5.7 } else { 8.0 };
            assert!(found <= most, "{} n = {n}: {found} %", shape.name);
        }
    }
}

#[test]
#[ignore = "prints the table of docs/statistics.md"]
#[allow(clippy::print_stdout, reason = "it prints a table")]
fn table() {
    for shape in [NORMAL, SKEWED, BOUNDED, STUCK, EXPONENTIAL] {
        for n in SIZES {
            let rounds = 20_000;
            println!(
                "| {} | {n} | {:.1} | {:.1} |",
                shape.name,
                of_mean(shape, n, rounds),
                of_difference(shape, n, rounds)
            );
        }
    }
}
