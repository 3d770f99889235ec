//! The table of metrics, and the formula of each.

use super::counted::{Counted, n_ln_n};
use super::metric::Metric;
use super::metric::Shown::{AtEnd, OverTime, Summary};
use super::metric::Source::{Counted as From, Fields};
use super::metric::Value::{Count, Real};

/// Every metric, in the order in which they show. `docs/metrics.md` has the same table, and says
/// what the symbols are.
pub const METRICS: &[Metric] = &[
    Metric {
        name: "fraction_1",
        unit: "1",
        formula: r"union coverage, in JSON `fractions.p1`: share of `R` with `v_s(t)` >= 1",
        shown: &[OverTime, AtEnd],
        source: Fields,
    },
    Metric {
        name: "fraction_2",
        unit: "1",
        formula: r"in JSON `fractions.p2`: the same with `v_s(t)` >= 2",
        shown: &[OverTime, AtEnd],
        source: Fields,
    },
    Metric {
        name: "fraction_5",
        unit: "1",
        formula: r"in JSON `fractions.p5`: the same with `v_s(t)` >= 5",
        shown: &[OverTime, AtEnd],
        source: Fields,
    },
    Metric {
        name: "fraction_10",
        unit: "1",
        formula: r"in JSON `fractions.p10`: the same with `v_s(t)` >= 10",
        shown: &[OverTime, AtEnd],
        source: Fields,
    },
    Metric {
        name: "p1",
        unit: "squares",
        formula: r"squares of the arena, also those outside `R`, with `v_s` >= 1",
        shown: &[AtEnd, Summary],
        source: Fields,
    },
    Metric {
        name: "p2",
        unit: "squares",
        formula: r"the same with `v_s` >= 2",
        shown: &[AtEnd, Summary],
        source: Fields,
    },
    Metric {
        name: "p5",
        unit: "squares",
        formula: r"the same with `v_s` >= 5",
        shown: &[AtEnd, Summary],
        source: Fields,
    },
    Metric {
        name: "p10",
        unit: "squares",
        formula: r"the same with `v_s` >= 10",
        shown: &[AtEnd, Summary],
        source: Fields,
    },
    Metric {
        name: "t50_steps",
        unit: "steps",
        formula: r"time to cover 50 %: least `t` at which at least 50 % of `R` (rounded up) has `v_s(t)` >= 1; null when never",
        shown: &[AtEnd, Summary],
        source: From(|now| {
            time_to_cover(
                now.times_of_first_entries().iter().copied(),
                now.reachable,
                50,
            )
            .map(Count)
        }),
    },
    Metric {
        name: "t90_steps",
        unit: "steps",
        formula: r"the same with 90 %",
        shown: &[AtEnd, Summary],
        source: From(|now| {
            time_to_cover(
                now.times_of_first_entries().iter().copied(),
                now.reachable,
                90,
            )
            .map(Count)
        }),
    },
    Metric {
        name: "t99_steps",
        unit: "steps",
        formula: r"the same with 99 %",
        shown: &[AtEnd, Summary],
        source: From(|now| {
            time_to_cover(
                now.times_of_first_entries().iter().copied(),
                now.reachable,
                99,
            )
            .map(Count)
        }),
    },
    Metric {
        name: "mean_coverage",
        unit: "1",
        formula: r"mean over the counted steps of `fraction_1`: sum over `s` in `R` of (T - f_s) / (T \|R\|), f_s the step of the first entry, T the counted steps",
        shown: &[AtEnd, Summary],
        source: From(|now| {
            let (entered, steps) = (now.times_of_first_entries(), now.tally().steps());
            Some(Real(mean_coverage(entered, now.reachable, steps)))
        }),
    },
    Metric {
        name: "entropy",
        unit: "1",
        formula: r"entropy of visits: -sum over `R` of p_s ln p_s / ln \|R\|, p_s = v_s / sum of v",
        shown: &[OverTime, AtEnd, Summary],
        source: From(|now| Some(Real(entropy(now)))),
    },
    Metric {
        name: "overlap",
        unit: "1",
        formula: r"sum of k_s (k_s - 1) / ((n - 1) sum of k_s) over `R`, k_s the robots of n that have been in `s`: of the squares of a robot, the mean share in which another given robot has been too. 0: no square in common; 1: all the same; null for one robot",
        shown: &[OverTime, AtEnd, Summary],
        source: From(|now| {
            let tally = now.tally();
            overlap(now.inside(tally.seen_by().iter().copied()), tally.sampled()).map(Real)
        }),
    },
    Metric {
        name: "overlap_robots",
        unit: "robots",
        formula: r"n of `overlap`",
        shown: &[AtEnd],
        source: From(|now| Some(Count(now.tally().sampled() as u64))),
    },
    Metric {
        name: "contribution_max",
        unit: "1",
        formula: r"the greatest contribution of a robot: its first entries / first entries of all",
        shown: &[OverTime, AtEnd],
        source: From(|now| Some(Real(greatest_share(now.first_entries())))),
    },
    Metric {
        name: "contributors",
        unit: "robots",
        formula: r"exp(-sum of c_i ln c_i), c_i the contributions: how many robots with equal shares would be as even, 1 to N",
        shown: &[AtEnd],
        source: From(|now| Some(Real(even_shares(now.first_entries())))),
    },
    Metric {
        name: "collisions",
        unit: "robot-steps",
        formula: r"robot-steps of the counted epochs that touched a wall or a robot; at the end beside the metrics",
        shown: &[OverTime],
        source: From(|now| Some(Count(now.collisions()))),
    },
    Metric {
        name: "collisions_per_robot_step",
        unit: "1",
        formula: r"`collisions` / robot-steps of the run, uncounted phases included",
        shown: &[Summary],
        source: Fields,
    },
    Metric {
        name: "distance_m",
        unit: "m",
        formula: r"distance travelled: sum over robots and steps of the straight way from where the step began to where it ended, walls and other robots included; being put back is no way",
        shown: &[OverTime, AtEnd, Summary],
        source: From(|now| Some(Real(now.bodies().map(|body| body.distance_m).sum()))),
    },
    Metric {
        name: "mean_squared_displacement_m2",
        unit: "m2",
        formula: r"mean over the robots of the squared straight distance from the start pose: sum over i of \|x_i(t) - x_i(0)\|^2 / N. With `episodes` `reset` that is where each epoch begins; with `continue` where the robot stood before the first step of the run, uncounted phases included",
        shown: &[OverTime, AtEnd, Summary],
        source: From(|now| Some(Real(mean_squared_displacement_m2(now)))),
    },
];

/// Counted steps after which `percent` % of the squares within reach had been entered, from the
/// times of first entries (1 + steps, 0 for never); `None` for never.
pub fn time_to_cover(
    first_entries: impl Iterator<Item = u64>,
    reachable: u32,
    percent: u32,
) -> Option<u64> {
    let mut first: Vec<u64> = first_entries.filter(|&first| first > 0).collect();
    let needed = (u64::from(reachable) * u64::from(percent))
        .div_ceil(100)
        .max(1) as usize;
    if needed > first.len() {
        return None;
    }
    let (_, last, _) = first.select_nth_unstable(needed - 1);
    Some(*last - 1)
}

/// Mean over `steps` counted steps of the share of `reachable` squares that had been entered, from
/// the times of first entries (1 + steps).
fn mean_coverage(first_entries: &[u64], reachable: u32, steps: u64) -> f64 {
    if reachable == 0 || steps == 0 {
        return 0.0;
    }
    let covered: f64 = first_entries
        .iter()
        .map(|&first| (steps + 1).saturating_sub(first) as f64)
        .sum();
    covered / steps as f64 / f64::from(reachable)
}

/// Entropy of the entries over the squares within reach, as a share of the greatest.
fn entropy(now: &Counted<'_>) -> f64 {
    if now.entries == 0 || now.reachable < 2 {
        return 0.0;
    }
    let entries = now.entries as f64;
    let nats = libm::log(entries) - now.n_ln_n / entries;
    (nats / libm::log(f64::from(now.reachable))).clamp(0.0, 1.0)
}

/// Of the squares that a sampled robot has been in, the mean share in which another one has been.
fn overlap(seen_by: impl Iterator<Item = u32>, sampled: usize) -> Option<f64> {
    if sampled < 2 {
        return None;
    }
    let (mut pairs, mut visits) = (0_u64, 0_u64);
    for robots in seen_by.map(u64::from) {
        pairs += robots * robots.saturating_sub(1);
        visits += robots;
    }
    let others = (sampled - 1) as f64;
    Some(match visits {
        0 => 0.0,
        visits => pairs as f64 / (others * visits as f64),
    })
}

/// Mean over the robots of the squared distance from their start poses.
fn mean_squared_displacement_m2(now: &Counted<'_>) -> f64 {
    let starts = now.world.starts();
    let squared_m2 = now.bodies().zip(starts).map(|(body, start)| {
        let dx_m = f64::from(body.x_m) - f64::from(start.x_m);
        let dy_m = f64::from(body.y_m) - f64::from(start.y_m);
        dx_m * dx_m + dy_m * dy_m
    });
    squared_m2.sum::<f64>() / starts.len().max(1) as f64
}

/// The greatest of some counts as a share of all; 0 when there is nothing to share.
fn greatest_share(counts: impl Iterator<Item = u32>) -> f64 {
    let (mut all, mut most) = (0_u64, 0);
    for count in counts {
        all += u64::from(count);
        most = most.max(count);
    }
    match all {
        0 => 0.0,
        all => f64::from(most) / all as f64,
    }
}

/// exp of the entropy of the shares that some counts are of all; 0 when there is nothing to share.
fn even_shares(counts: impl Iterator<Item = u32>) -> f64 {
    let (mut all, mut sum) = (0_u64, 0.0);
    for count in counts {
        all += u64::from(count);
        sum += n_ln_n(count);
    }
    match all {
        0 => 0.0,
        all => libm::exp(libm::log(all as f64) - sum / all as f64),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn overlap_by_hand() {
        // Robots 0 and 1 in squares {a, b} and {b, c}; a third in {b}. Of the pairs (i, j) and the
        // squares of i: b is shared in all six, of 2 x 5 chances.
        assert_eq!(overlap([1, 3, 1].into_iter(), 3), Some(0.6));
        assert_eq!(overlap([2, 2, 0].into_iter(), 2), Some(1.0));
        assert_eq!(overlap([1, 1, 0].into_iter(), 2), Some(0.0));
        assert_eq!(overlap([0; 3].into_iter(), 2), Some(0.0));
        assert_eq!(overlap([].into_iter(), 1), None);
    }

    #[test]
    fn times_by_hand() {
        // Ten squares in reach, entered after 0, 1, .. 8 steps; one never.
        let mut first: Vec<u64> = (1..=9).collect();
        first.push(0);
        let times =
            |first: &[u64]| [50, 90, 99].map(|q| time_to_cover(first.iter().copied(), 10, q));
        assert_eq!(times(&first), [Some(4), Some(8), None]);
        first[9] = 100;
        assert_eq!(times(&first), [Some(4), Some(8), Some(99)]);
        assert_eq!(time_to_cover([].into_iter(), 0, 50), None);
    }

    #[test]
    fn mean_coverage_by_hand() {
        // Four squares over ten steps: there from the start, after five, after ten, never.
        let first = [1, 6, 11];
        assert_eq!(mean_coverage(&first, 4, 10), (10.0 + 5.0) / 40.0);
        assert_eq!(mean_coverage(&first, 0, 10), 0.0);
    }

    #[test]
    fn shares_by_hand() {
        let equal = || [5, 5, 5, 5].into_iter();
        assert!((even_shares(equal()) - 4.0).abs() < 1e-12 && greatest_share(equal()) == 0.25);
        let alone = || [7, 0, 0].into_iter();
        assert!((even_shares(alone()) - 1.0).abs() < 1e-12 && greatest_share(alone()) == 1.0);
        assert_eq!(even_shares([0, 0].into_iter()), 0.0);
        assert_eq!(greatest_share([0, 0].into_iter()), 0.0);
    }

    #[test]
    fn displacement_is_from_where_robots_were_put() {
        use crate::metrics::Value;
        use crate::run::Run;
        use crate::spec::{Episodes, Method, Placement, RunSpec};

        for episodes in [Episodes::Reset, Episodes::Continue] {
            let arena = std::sync::Arc::new(arenas::builtin("easy").unwrap());
            let spec = RunSpec {
                epochs: 2,
                steps_per_epoch: 100,
                robots: 3,
                placement: Placement::Grid,
                episodes,
                ..RunSpec::new(Method::Brownian, arena)
            };
            let mut run = Run::new(spec.validate().unwrap()).unwrap();
            let places = |run: &Run| -> Vec<[f32; 2]> {
                run.robots().iter().map(|b| [b.x_m, b.y_m]).collect()
            };
            let starts = places(&run);
            // Rows within the first epoch and, where robots may have been put back, the second.
            for (steps, rows) in [(10, 1), (140, 15)] {
                run.advance(steps);
                let expected: f64 = places(&run)
                    .iter()
                    .zip(&starts)
                    .flat_map(|(now, start)| [now[0] - start[0], now[1] - start[1]])
                    .map(|metres| f64::from(metres) * f64::from(metres))
                    .sum::<f64>()
                    / 3.0;
                let log = run.metrics();
                assert_eq!(log.rows.len(), rows);
                let found = log.rows[rows - 1]
                    .values
                    .get("mean_squared_displacement_m2");
                let Some(Value::Real(found)) = found else {
                    panic!("{found:?}")
                };
                assert!(
                    found > 0.0 && (found - expected).abs() < 1e-6 * expected,
                    "{found} {expected}"
                );
            }
        }
    }
}
