//! How a swarm covers its arena over time, how much its robots overlap, and who did what.
//! Formulas: `docs/metrics.md`.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::robot_memory::RobotMemory;
use crate::world::{COVERAGE_LEVELS, World};

/// Epochs in which there are rows within the epoch too, and rows an epoch then.
const EARLY_EPOCHS: u32 = 4;
const ROWS_AN_EPOCH: u32 = 10;
/// Epochs up to which each has a row; after them at most as many rows a doubling of time.
const EVERY_EPOCH_UP_TO: u32 = 64;

/// The swarm after some counted steps. Squares are those within reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MetricsRow {
    /// Counted steps of the arena that are done.
    pub steps: u64,
    /// Counted epochs that are complete.
    pub epoch: u32,
    /// Squares within reach that were entered at least 1, 2, 5 and 10 times.
    pub entered: [u32; 4],
    /// Entropy of the entries over the squares within reach, as a share of the greatest; 0 to 1.
    pub entropy: f64,
    /// How much of what a robot visits another visits too, 0 to 1; `None` for fewer than two robots.
    pub overlap: Option<f64>,
    /// Greatest share of the first entries that one robot has.
    pub contribution_max: f64,
    /// Robot-steps that touched a wall or a robot.
    pub collisions: u64,
    /// Way driven by all robots together, metres.
    pub distance_m: f64,
}

/// The metrics at the end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// The last row.
    pub last: MetricsRow,
    /// Counted steps after which 50, 90 and 99 % of the squares within reach had been entered;
    /// `None` for never.
    pub t_steps: [Option<u64>; 3],
    /// Mean over the counted steps of the share of squares within reach that had been entered.
    pub mean_coverage: f64,
    /// Robots among which the overlap was measured.
    pub overlap_robots: u32,
    /// Robots that would have made equal contributions of the same entropy: between 1 and N.
    pub contributors: f64,
}

/// What one robot did while visits counted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotMetrics {
    /// Squares that it was the first to enter.
    pub first_entries: u32,
    /// Way driven, metres.
    pub distance_m: f64,
    /// What its learner holds.
    pub memory: RobotMemory,
}

/// All that there is to know of a run's metrics at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MetricsLog {
    /// Squares within reach.
    pub reachable: u32,
    /// Rows so far: tenths of the first epochs, then epochs, ever fewer a doubling.
    pub rows: Vec<MetricsRow>,
    /// What each robot did; index is the robot's number.
    pub robots: Vec<RobotMetrics>,
    /// For each square within reach 1 + the counted steps after which it was first entered, 0 for
    /// never and for squares out of reach; row 0 is the lowest y. Empty before visits count.
    pub first_entry: Vec<u64>,
}

/// The step of an early epoch, after `step`, that the next row within it follows.
pub(super) fn next_within(epoch: u32, step: u32, steps_per_epoch: u32) -> Option<u32> {
    if epoch >= EARLY_EPOCHS {
        return None;
    }
    let steps = u64::from(steps_per_epoch);
    (1..u64::from(ROWS_AN_EPOCH))
        .map(|part| (part * steps / u64::from(ROWS_AN_EPOCH)) as u32)
        .find(|&due| due > step)
        .filter(|&due| due < steps_per_epoch)
}

/// Whether there is a row after so many of all counted epochs.
pub(super) fn has_row(epoch: u32, epochs: u32) -> bool {
    let spacing = epoch.div_ceil(EVERY_EPOCH_UP_TO).next_power_of_two();
    epoch == epochs || epoch.is_multiple_of(spacing)
}

/// n ln n for the numbers of entries that most squares have.
static N_LN_N: LazyLock<Vec<f64>> = LazyLock::new(|| (0..4096).map(n_ln_n).collect());

fn n_ln_n(n: u32) -> f64 {
    match n {
        0 => 0.0,
        n => f64::from(n) * libm::log(f64::from(n)),
    }
}

/// exp of the entropy of shares, and the greatest share; `(0, 0)` when there is nothing to share.
pub(super) fn shares(counts: impl Iterator<Item = u32>) -> (f64, f64) {
    let (mut all, mut most, mut sum) = (0_u64, 0, 0.0);
    for count in counts {
        all += u64::from(count);
        most = most.max(count);
        sum += n_ln_n(count);
    }
    if all == 0 {
        return (0.0, 0.0);
    }
    let all = all as f64;
    (libm::exp(libm::log(all) - sum / all), f64::from(most) / all)
}

/// Of the squares that a sampled robot has been in, the mean share in which another one has been.
fn overlap(seen_by: &[u32], mask: &[bool], sampled: usize) -> Option<f64> {
    if sampled < 2 {
        return None;
    }
    let (mut pairs, mut visits) = (0_u64, 0_u64);
    for (&robots, _) in seen_by.iter().zip(mask).filter(|&(_, &inside)| inside) {
        let robots = u64::from(robots);
        pairs += robots * robots.saturating_sub(1);
        visits += robots;
    }
    let others = (sampled - 1) as f64;
    Some(match visits {
        0 => 0.0,
        visits => pairs as f64 / (others * visits as f64),
    })
}

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

pub(super) fn times(first_entry: &[u64], mask: &[bool], reachable: u32) -> [Option<u64>; 3] {
    [50, 90, 99].map(|percent| {
        let inside = first_entry.iter().zip(mask).filter(|&(_, &inside)| inside);
        time_to_cover(inside.map(|(&first, _)| first), reachable, percent)
    })
}

/// Mean over `steps` counted steps of the share of `reachable` squares that had been entered.
pub(super) fn mean_coverage(
    first_entries: impl Iterator<Item = u64>,
    reachable: u32,
    steps: u64,
) -> f64 {
    if reachable == 0 || steps == 0 {
        return 0.0;
    }
    let covered: f64 = first_entries
        .filter(|&first| first > 0)
        .map(|first| (steps + 1).saturating_sub(first) as f64)
        .sum();
    covered / steps as f64 / f64::from(reachable)
}

/// The row of a world at this moment.
pub(super) fn row(world: &World, mask: &[bool], reachable: u32, epoch: u32) -> MetricsRow {
    let state = world.state();
    let mut entered = [0; 4];
    let (mut entries, mut sum) = (0_u64, 0.0);
    let table = &N_LN_N[..];
    for (count, _) in world.entries().zip(mask).filter(|&(_, &inside)| inside) {
        for (squares, least) in entered.iter_mut().zip(COVERAGE_LEVELS) {
            *squares += u32::from(count >= least);
        }
        entries += u64::from(count);
        sum += match table.get(count as usize) {
            Some(known) => *known,
            None => n_ln_n(count),
        };
    }
    let entropy = match entries {
        0 => 0.0,
        _ if reachable < 2 => 0.0,
        entries => {
            let entries = entries as f64;
            let nats = libm::log(entries) - sum / entries;
            (nats / libm::log(f64::from(reachable))).clamp(0.0, 1.0)
        }
    };
    MetricsRow {
        steps: state.tally.steps(),
        epoch,
        entered,
        entropy,
        overlap: overlap(state.tally.seen_by(), mask, state.tally.sampled()),
        contribution_max: greatest_share(world),
        collisions: state.collisions,
        distance_m: state.bodies.iter().map(|body| body.distance_m).sum(),
    }
}

fn greatest_share(world: &World) -> f64 {
    let firsts = || world.state().bodies.iter().map(|body| body.first_entries);
    match firsts().map(u64::from).sum::<u64>() {
        0 => 0.0,
        all => f64::from(firsts().max().unwrap_or(0)) / all as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_in_tenths_then_epochs_then_fewer() {
        let mut dues = vec![0];
        while let Some(due) = next_within(3, *dues.last().unwrap_or(&0), 2_000) {
            dues.push(due);
        }
        assert_eq!(
            dues[1..],
            [200, 400, 600, 800, 1000, 1200, 1400, 1600, 1800]
        );
        assert_eq!(next_within(0, 0, 3), Some(1));
        assert_eq!(next_within(0, 2, 3), None);
        assert_eq!(
            (next_within(0, 0, 1), next_within(4, 0, 2_000)),
            (None, None)
        );
        let rows = |from: u32, to: u32| (from..=to).filter(|&e| has_row(e, 1_000_000)).count();
        assert_eq!((rows(1, 64), rows(65, 128), rows(129, 256)), (64, 32, 32));
        assert!(has_row(77, 77) && !has_row(77, 78));
        assert!(rows(1, 1_000_000) < 600);
    }

    #[test]
    fn overlap_by_hand() {
        // Robots 0 and 1 in squares {a, b} and {b, c}; a third in {b}. Of the pairs (i, j) and the
        // squares of i: b is shared in all six, of 2 x 5 chances.
        let mask = [true, true, true, false];
        assert_eq!(overlap(&[1, 3, 1, 3], &mask, 3), Some(0.6));
        assert_eq!(overlap(&[2, 2, 0, 0], &mask, 2), Some(1.0));
        assert_eq!(overlap(&[1, 1, 0, 0], &mask, 2), Some(0.0));
        assert_eq!(overlap(&[0; 4], &mask, 2), Some(0.0));
        assert_eq!(overlap(&[], &mask, 1), None);
    }

    #[test]
    fn times_by_hand() {
        // Ten squares in reach, entered after 0, 1, .. 8 steps; one never; one outside early on.
        let mut first: Vec<u64> = (1..=9).collect();
        first.extend([0, 1]);
        let mut mask = vec![true; 10];
        mask.push(false);
        assert_eq!(times(&first, &mask, 10), [Some(4), Some(8), None]);
        first[9] = 100;
        assert_eq!(times(&first, &mask, 10), [Some(4), Some(8), Some(99)]);
        assert_eq!(times(&[], &[], 0), [None; 3]);
    }

    #[test]
    fn mean_coverage_by_hand() {
        // Four squares over ten steps: there from the start, after five, after ten, never.
        let first = [1, 6, 11, 0];
        assert_eq!(mean_coverage(first.into_iter(), 4, 10), (10.0 + 5.0) / 40.0);
        assert_eq!(mean_coverage(first.into_iter(), 0, 10), 0.0);
    }

    #[test]
    fn contributors_by_hand() {
        let (equal, most) = shares([5, 5, 5, 5].into_iter());
        assert!((equal - 4.0).abs() < 1e-12 && most == 0.25);
        let (alone, most) = shares([7, 0, 0].into_iter());
        assert!((alone - 1.0).abs() < 1e-12 && most == 1.0);
        assert_eq!(shares([0, 0].into_iter()), (0.0, 0.0));
    }
}
