//! Statistics of small samples: moments, the Mann-Whitney test, effect size, sign test, Holm.

use statrs::distribution::{Binomial, DiscreteCDF};
use statrs::statistics::{Data, Median, Statistics};
use statrs::stats_tests::Alternative;
use statrs::stats_tests::mannwhitneyu::{MannWhitneyUMethod, mannwhitneyu};

/// Largest two samples together for which the test is exact; beyond it the normal approximation
/// is as good and the exact count slow.
const EXACT_UP_TO: usize = 100;

/// Mean, sample standard deviation (0 for one value) and median.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    pub mean: f64,
    pub sd: f64,
    pub median: f64,
}

/// Of at least one value.
pub fn summary(values: &[f64]) -> Summary {
    Summary {
        mean: values.mean(),
        sd: if values.len() > 1 {
            values.std_dev()
        } else {
            0.0
        },
        median: median(values),
    }
}

/// The mean; `None` of no values.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Of at least one value.
pub fn median(values: &[f64]) -> f64 {
    Data::new(values.to_vec()).median()
}

/// A one-sided comparison of two samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Mann-Whitney U of the first sample: pairs in which it is larger, ties counting half.
    pub u: f64,
    /// Probability of a U at least as large if both samples come from one distribution.
    pub p_greater: f64,
    /// Of one at most as large.
    pub p_less: f64,
    /// Vargha and Delaney's A: U as a share of all pairs; 0.5 means no difference.
    pub a: f64,
    /// Median of the first sample less that of the second.
    pub median_difference: f64,
}

/// Compares two samples of finite values, neither empty.
///
/// Up to 100 values p is exact: the share of all ways to divide the pooled values, ties included,
/// into samples of these sizes. Beyond it is the normal approximation with corrections for ties and
/// continuity.
pub fn compare(x: &[f64], y: &[f64]) -> Comparison {
    let pairs = (x.len() * y.len()) as f64;
    let half_points: usize = x
        .iter()
        .flat_map(|a| {
            y.iter()
                .map(move |b| if a > b { 2 } else { usize::from(a == b) })
        })
        .sum();
    let (p_greater, p_less) = if x.len() + y.len() <= EXACT_UP_TO {
        exact(x, y)
    } else {
        (
            approximate(x, y, Alternative::Greater),
            approximate(x, y, Alternative::Less),
        )
    };
    Comparison {
        u: half_points as f64 / 2.0,
        p_greater,
        p_less,
        a: half_points as f64 / 2.0 / pairs,
        median_difference: median(x) - median(y),
    }
}

/// Exact p for greater and less: the permutation distribution of the rank sum, by the shift
/// algorithm of Streitberg and Roehmel (1986) over doubled mid-ranks.
fn exact(x: &[f64], y: &[f64]) -> (f64, f64) {
    let mut pooled: Vec<f64> = x.iter().chain(y).copied().collect();
    pooled.sort_by(f64::total_cmp);
    // Twice the mean of the first and the last rank, from 1, that equal values take.
    let doubled_rank = |value: f64| {
        let below = pooled.partition_point(|&other| other < value);
        let up_to = pooled.partition_point(|&other| other <= value);
        below + 1 + up_to
    };
    let observed: usize = x.iter().map(|&value| doubled_rank(value)).sum();
    let largest: usize = pooled.iter().map(|&value| doubled_rank(value)).sum();
    // ways[k][s]: number of sets of k pooled values with doubled rank sum s.
    let mut ways = vec![vec![0.0_f64; largest + 1]; x.len() + 1];
    ways[0][0] = 1.0;
    for rank in pooled.iter().map(|&value| doubled_rank(value)) {
        for k in (1..=x.len()).rev() {
            let (fewer, more) = ways.split_at_mut(k);
            let (fewer, more) = (&fewer[k - 1], &mut more[0]);
            for (more, fewer) in more[rank..].iter_mut().zip(fewer) {
                *more += fewer;
            }
        }
    }
    let ways = &ways[x.len()];
    let total: f64 = ways.iter().sum();
    let share = |ways: &[f64]| (ways.iter().sum::<f64>() / total).min(1.0);
    (share(&ways[observed..]), share(&ways[..=observed]))
}

/// p by the normal approximation. (The crate's exact method gives 1 - p for samples of one size.)
fn approximate(x: &[f64], y: &[f64], alternative: Alternative) -> f64 {
    let method = MannWhitneyUMethod::AsymptoticInclContinuityCorrection;
    #[allow(
        clippy::expect_used,
        reason = "no sample is empty and all values are finite"
    )]
    let (_, p) = mannwhitneyu(x, y, method, alternative).expect("two samples of finite values");
    // All values equal: there is nothing to be surprised at.
    if p.is_nan() { 1.0 } else { p }
}

/// Probability of at least `successes` of `trials` (at least one), each as likely as not.
pub fn sign_test(successes: u64, trials: u64) -> f64 {
    let Some(fewer) = successes.checked_sub(1) else {
        return 1.0;
    };
    #[allow(clippy::expect_used, reason = "one half is a probability")]
    let distribution = Binomial::new(0.5, trials).expect("a valid probability");
    distribution.sf(fewer)
}

/// Holm's step-down correction for all tests of a family, in their order.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&one, &other| p[one].total_cmp(&p[other]));
    let mut corrected = vec![0.0; p.len()];
    let mut least = 0.0_f64;
    for (place, &test) in order.iter().enumerate() {
        let remaining = (p.len() - place) as f64;
        least = least.max((p[test] * remaining).min(1.0));
        corrected[test] = least;
    }
    corrected
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(one: f64, other: f64) {
        assert!(
            (one - other).abs() <= 1e-9 * other.abs().max(1e-6),
            "{one} is not {other}"
        );
    }

    /// p as scipy 1.17 gives it: `mannwhitneyu(..., method="exact")`.
    #[test]
    fn without_ties_p_is_that_of_the_exact_distribution() {
        let male = [19.0, 22.0, 16.0, 29.0, 24.0];
        let female = [20.0, 11.0, 17.0, 12.0];
        let test = compare(&male, &female);
        assert_eq!((test.u, test.a), (17.0, 0.85));
        close(test.p_greater, 0.055_555_555_555_555_55);
        close(test.p_less, 0.968_253_968_253_968_3);
        assert_eq!(test.median_difference, 7.5);
        let mirrored = compare(&female, &male);
        close(mirrored.p_less, test.p_greater);
        close(mirrored.a, 0.15);
    }

    #[test]
    fn fifteen_against_fifteen() {
        let x = [
            3962.0, 3512.0, 4432.0, 4395.0, 4258.0, 4095.0, 4413.0, 4374.0, 4325.0, 4212.0, 4418.0,
            4381.0, 4260.0, 4094.0, 4397.0,
        ];
        let y = [
            3241.0, 3252.0, 2711.0, 2270.0, 2062.0, 3489.0, 3090.0, 2420.0, 2098.0, 3647.0, 3273.0,
            2475.0, 2036.0, 4335.0, 4270.0,
        ];
        let test = compare(&x, &y);
        assert_eq!(test.u, 209.0);
        close(test.p_greater, 5.885_859_959_597_085e-6);
        close(test.p_less, 0.999_995_590_440_074);
        // The approximation is too careful this far out, but of the same order.
        close(
            approximate(&x, &y, Alternative::Greater),
            3.418_406_268_000_528e-5,
        );
    }

    /// p over all 126 divisions, counted one by one.
    #[test]
    fn ties_are_counted_as_they_are() {
        let test = compare(&[1.0, 2.0, 2.0, 5.0, 7.0], &[0.0, 2.0, 3.0, 3.0]);
        assert_eq!(test.u, 12.0);
        close(test.p_greater, 0.349_206_349_206_349_2);
        close(test.p_less, 0.722_222_222_222_222_2);
        let equal = compare(&[3.0; 4], &[3.0; 4]);
        assert_eq!((equal.p_greater, equal.p_less, equal.a), (1.0, 1.0, 0.5));
    }

    #[test]
    fn three_against_three_cannot_go_below_a_twentieth() {
        let test = compare(&[4.0, 5.0, 6.0], &[1.0, 2.0, 3.0]);
        close(test.p_greater, 0.05);
        assert_eq!((test.p_less, test.a), (1.0, 1.0));
    }

    /// p as scipy gives it: `mannwhitneyu(..., method="asymptotic")`.
    #[test]
    fn large_samples_take_the_normal_approximation() {
        let x: Vec<f64> = (0..60).map(|i| f64::from(i * 37 % 101)).collect();
        let y: Vec<f64> = (0..60).map(|i| f64::from((i * 53 + 7) % 89)).collect();
        let test = compare(&x, &y);
        assert_eq!(test.u, 2044.5);
        close(test.p_greater, 0.100_141_500_976_556_94);
        close(test.p_less, 0.900_777_536_906_330_4);
        let (exact_greater, _) = exact(&x, &y);
        assert!((exact_greater - test.p_greater).abs() < 1e-3);
        assert_eq!(compare(&[2.0; 60], &[2.0; 60]).p_greater, 1.0);
    }

    #[test]
    fn the_sign_test_is_a_binomial_tail() {
        close(sign_test(12, 15), 0.017_578_125);
        close(sign_test(15, 15), 1.0 / 32_768.0);
        assert_eq!(sign_test(0, 15), 1.0);
    }

    #[test]
    fn holm_steps_down_and_never_falls() {
        // Holm (1979): 4 x 0.005, 3 x 0.01, 2 x 0.03, and no less than the one before.
        let corrected = holm(&[0.01, 0.04, 0.03, 0.005]);
        for (one, other) in corrected.into_iter().zip([0.03, 0.06, 0.06, 0.02]) {
            close(one, other);
        }
        assert_eq!(holm(&[0.9, 0.6]), [1.0, 1.0]);
        assert!(holm(&[]).is_empty());
    }

    proptest::proptest! {
        #[test]
        fn corrected_ps_keep_their_order_and_are_no_smaller(
            p in proptest::collection::vec(0.0..1.0_f64, 0..12),
        ) {
            let corrected = holm(&p);
            for (one, &p_one) in p.iter().enumerate() {
                proptest::prop_assert!(p_one <= corrected[one] && corrected[one] <= 1.0);
                for (other, &p_other) in p.iter().enumerate() {
                    proptest::prop_assert!(p_one > p_other || corrected[one] <= corrected[other]);
                }
            }
        }
    }

    #[test]
    fn summaries() {
        let summary = summary(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!((summary.mean, summary.median), (5.0, 4.5));
        close(summary.sd, 2.138_089_935_299_395);
        assert_eq!(super::summary(&[3.0]).sd, 0.0);
    }
}
