//! Tests of differences, the probability of improvement, and how many runs a difference asks for.

use statrs::distribution::{ContinuousCDF, StudentsT};
use swarm::random::Stream;

use super::interval::{LEVEL, standard_error, t_quantile};
use super::samples::{compare, mean};

/// Level of significance after correction.
pub const ALPHA: f64 = 0.05;
/// Probability with which a difference as large as the one seen is to be found.
const POWER: f64 = 0.8;
/// Most pairs whose signs are all tried: 2^15 ways, as a way and its opposite count alike.
const ALL_SIGNS_UP_TO: usize = 16;
/// Most pairs whose signs are drawn; with more, Student's t is as good.
const SIGNS_UP_TO: usize = 500;
/// Ways that are drawn.
const DRAWN_SIGNS: usize = 20_000;
/// Key of the stream of signs: the same runs give the same p.
const KEY: u64 = 0x7369_676e_666c_6970;
/// Most runs of a group that are advised.
pub const MOST_RUNS: u64 = 200;

/// The p of a two-sided test and its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tested {
    pub p: f64,
    pub method: &'static str,
}

/// Whether paired differences lie about 0: the share of all ways to choose their signs that give a
/// sum at least as far from 0 (Fisher 1935). Exact up to 16 pairs. `None` of no pairs.
pub fn sign_flip_test(differences: &[f64]) -> Option<Tested> {
    let n = differences.len();
    let size: f64 = differences.iter().map(|difference| difference.abs()).sum();
    let sum: f64 = differences.iter().sum();
    // Sums that differ by rounding alone count as equal.
    let least = sum.abs() - 1e-9 * size;
    let (&first, rest) = differences.split_first()?;
    if n <= ALL_SIGNS_UP_TO {
        let mut sums = vec![first];
        for difference in rest {
            let flipped: Vec<f64> = sums.iter().map(|sum| sum - difference).collect();
            sums.iter_mut().for_each(|sum| *sum += difference);
            sums.extend(flipped);
        }
        let far = sums.iter().filter(|sum| sum.abs() >= least).count();
        return Some(Tested {
            p: far as f64 / sums.len() as f64,
            method: "exact sign-flip test",
        });
    }
    if n > SIGNS_UP_TO {
        let (mean, error) = (mean(differences)?, standard_error(differences)?);
        let of = StudentsT::new(0.0, 1.0, n as f64 - 1.0).ok()?;
        return Some(Tested {
            p: match error > 0.0 {
                true => 2.0 * of.cdf(-(mean / error).abs()),
                // No spread at all: nothing to be surprised at where there is no difference either.
                false => f64::from(mean == 0.0),
            },
            method: "t test",
        });
    }
    let mut stream = Stream::new(KEY);
    let far = (0..DRAWN_SIGNS)
        .filter(|_| {
            let mut signed = 0.0;
            for some in differences.chunks(64) {
                let mut signs = stream.bits();
                for difference in some {
                    signed += if signs & 1 == 0 {
                        *difference
                    } else {
                        -difference
                    };
                    signs >>= 1;
                }
            }
            signed.abs() >= least
        })
        .count();
    Some(Tested {
        // The way that was seen is one of those that are possible.
        p: (far + 1) as f64 / (DRAWN_SIGNS + 1) as f64,
        method: "sign-flip test, 20000 draws",
    })
}

/// Whether two samples that are not paired come from one distribution: Mann-Whitney, two-sided, exact
/// up to 100 values together. `None` where one is empty.
pub fn rank_test(x: &[f64], y: &[f64]) -> Option<Tested> {
    if x.is_empty() || y.is_empty() {
        return None;
    }
    let test = compare(x, y);
    Some(Tested {
        p: (2.0 * test.p_greater.min(test.p_less)).min(1.0),
        method: "Mann-Whitney test",
    })
}

/// Probability that a value of the first sample is above one of the second, ties counting half, over
/// all pairs of one stratum; with its interval by Newcombe's method 5 (2006), which holds for few
/// values. `None` where no stratum has values of both.
pub fn probability_above(strata: &[(Vec<f64>, Vec<f64>)]) -> Option<(f64, [f64; 2])> {
    let (mut points, mut pairs, mut n, mut m) = (0.0, 0.0, 0.0, 0.0);
    for (x, y) in strata {
        if x.is_empty() || y.is_empty() {
            continue;
        }
        let mut sorted = y.clone();
        sorted.sort_by(f64::total_cmp);
        for value in x {
            let below = sorted.partition_point(|other| other < value);
            let up_to = sorted.partition_point(|other| other <= value);
            points += (below + up_to) as f64 / 2.0;
        }
        pairs += (x.len() * y.len()) as f64;
        n += x.len() as f64;
        m += y.len() as f64;
    }
    (pairs > 0.0).then(|| {
        let share = points / pairs;
        (share, newcombe(share, n, m))
    })
}

/// Where (share - theta)^2 is z^2 times the variance at theta, on either side of the share.
fn newcombe(share: f64, n: f64, m: f64) -> [f64; 2] {
    let z = t_quantile(0.5 + LEVEL / 2.0, f64::INFINITY);
    let half = (n + m) / 2.0 - 1.0;
    let outside = |theta: f64| {
        let spread = 1.0 + half * (1.0 - theta) / (2.0 - theta) + half * theta / (1.0 + theta);
        (share - theta).powi(2) > z * z * theta * (1.0 - theta) * spread / (n * m)
    };
    let between = |mut inner: f64, mut outer: f64| {
        for _ in 0..60 {
            let middle = (inner + outer) / 2.0;
            if outside(middle) {
                outer = middle;
            } else {
                inner = middle;
            }
        }
        (inner + outer) / 2.0
    };
    [between(share, 0.0), between(share, 1.0)]
}

/// Pairs (or runs of each of two groups) at which a test at level `alpha` finds a difference of this
/// mean and standard deviation with probability 0.8, and at which the exact test can be significant
/// at all; `None` beyond [`MOST_RUNS`].
pub fn pairs_needed(mean: f64, sd: f64, alpha: f64) -> Option<u64> {
    let enough = |n: f64| {
        let reach = t_quantile(1.0 - alpha / 2.0, n - 1.0) + t_quantile(POWER, n - 1.0);
        n.sqrt() * mean.abs() >= reach * sd && 2.0_f64.powf(1.0 - n) < alpha
    };
    if mean == 0.0 {
        return None;
    }
    (2..=MOST_RUNS).find(|&n| enough(n as f64))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use proptest::prelude::*;

    use super::*;

    fn close(one: f64, other: f64) {
        assert!((one - other).abs() < 1e-4, "{one} is not {other}");
    }

    /// Darwin's maize, the example of Fisher (1935): p 0.0526 over 2^15 ways, 863 of 16,384.
    #[test]
    fn fishers_example() {
        let darwin = [
            49.0, -67.0, 8.0, 16.0, 6.0, 23.0, 28.0, 41.0, 14.0, 29.0, 56.0, 24.0, 75.0, 60.0,
            -48.0,
        ];
        let exact = sign_flip_test(&darwin).unwrap();
        close(exact.p, 863.0 / 16_384.0);
        // Drawn signs are near: the same differences and two zeros.
        let longer = [&darwin[..], &[0.0, 0.0]].concat();
        let drawn = sign_flip_test(&longer).unwrap();
        assert!(drawn.method.contains("draws") && (drawn.p - exact.p).abs() < 0.006);
        let many: Vec<f64> = (0..600).map(|i| f64::from(i % 7) - 2.9).collect();
        assert!(sign_flip_test(&many).unwrap().p < 0.5);
    }

    #[test]
    fn few_pairs_cannot_be_significant() {
        for (n, p) in [(1, 1.0), (2, 0.5), (3, 0.25), (5, 0.0625), (6, 0.03125)] {
            assert_eq!(sign_flip_test(&vec![0.3; n]).unwrap().p, p, "{n}");
        }
        assert_eq!(sign_flip_test(&[0.0; 5]).unwrap().p, 1.0);
        assert_eq!(sign_flip_test(&[0.0; 600]).unwrap().p, 1.0);
        assert_eq!(sign_flip_test(&[]), None);
        assert_eq!(rank_test(&[], &[1.0]), None);
        assert_eq!(
            rank_test(&[4.0, 5.0, 6.0], &[1.0, 2.0, 3.0]).unwrap().p,
            0.1
        );
    }

    #[test]
    fn improvement_by_hand() {
        let of = |x: &[f64], y: &[f64]| probability_above(&[(x.to_vec(), y.to_vec())]);
        let (share, [low, high]) = of(&[1.0, 3.0, 5.0], &[2.0, 3.0, 0.0]).unwrap();
        close(share, 6.5 / 9.0);
        assert!(low < share && share < high && low > 0.0 && high < 1.0);
        // Three above three is not certain: the interval reaches far below 1.
        let (share, [low, high]) = of(&[4.0, 5.0, 6.0], &[1.0, 2.0, 3.0]).unwrap();
        assert_eq!((share, high), (1.0, 1.0));
        assert!((0.3..0.7).contains(&low), "{low}");
        // Strata are compared within: each is even, though one is far above the other.
        let strata = [(vec![1.0, 2.0], vec![1.0, 2.0]), (vec![9.0], vec![9.0])];
        assert_eq!(probability_above(&strata).unwrap().0, 0.5);
        assert_eq!(of(&[], &[1.0]), None);
    }

    #[test]
    fn runs_that_would_do() {
        // R: power.t.test(delta = 0.5, sd = 1, type = "paired", power = 0.8) gives 33.4.
        let n = pairs_needed(0.5, 1.0, 0.05).unwrap();
        assert!((33..=34).contains(&n), "{n}");
        // However clear: five pairs cannot be significant at 0.05.
        assert_eq!(pairs_needed(1.0, 0.0, 0.05), Some(6));
        assert_eq!(pairs_needed(1.0, 0.0, 0.005), Some(9));
        assert_eq!(pairs_needed(0.01, 1.0, 0.05), None);
        assert_eq!(pairs_needed(0.0, 1.0, 0.05), None);
    }

    proptest! {
        #[test]
        fn turning_a_comparison_about_changes_its_sign_alone(
            x in prop::collection::vec(0_u8..20, 1..20),
            y in prop::collection::vec(0_u8..20, 1..20),
        ) {
            let of = |values: &[u8]| values.iter().map(|&value| f64::from(value)).collect::<Vec<_>>();
            let (x, y) = (of(&x), of(&y));
            let differences: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x - y).collect();
            let turned: Vec<f64> = differences.iter().map(|difference| -difference).collect();
            prop_assert_eq!(sign_flip_test(&differences), sign_flip_test(&turned));
            let (one, other) = (rank_test(&x, &y).unwrap(), rank_test(&y, &x).unwrap());
            prop_assert!((one.p - other.p).abs() < 1e-12);
            let (share, [low, high]) = probability_above(&[(x.clone(), y.clone())]).unwrap();
            let (back, [back_low, back_high]) = probability_above(&[(y, x)]).unwrap();
            prop_assert!((share + back - 1.0).abs() < 1e-12);
            prop_assert!((low + back_high - 1.0).abs() < 1e-9 && (high + back_low - 1.0).abs() < 1e-9);
            prop_assert!(0.0 <= low && low <= share && share <= high && high <= 1.0);
        }
    }
}
