//! Intervals that hold for few runs: of means, of interquartile means, of differences. Which method
//! is used where, and how often each holds: `docs/statistics.md`.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use statrs::statistics::Statistics;
use swarm::random::Stream;

use super::redraws::{MOST_VALUES, redraws};
use super::samples::mean;

/// How often an interval holds what it is of.
pub const LEVEL: f64 = 0.95;
/// Degrees of freedom beyond which Student's t is taken from the normal distribution.
const NEARLY_NORMAL: f64 = 1_000.0;
/// Share of the values below, and above, that an interquartile mean leaves out.
const TRIMMED: usize = 4;
/// Times that an interquartile mean is drawn anew for its standard error.
const IQM_REDRAWS: usize = 499;
/// Key of their stream of draws: the same runs give the same interval.
const IQM_KEY: u64 = 0x6971_6d5f_6472_6177;

const T: &str = "t";
const WELCH: &str = "Welch's t";
const BOOTSTRAP_T: &str = "smoothed bootstrap-t";
const BOOTSTRAP_SE: &str = "t with stratified bootstrap standard error";
const YUEN: &str = "t with winsorised variance";

/// An interval at [`LEVEL`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// What it was computed by.
    pub method: &'static str,
}

impl Interval {
    fn around(centre: f64, half: f64, method: &'static str) -> Self {
        Self {
            low: centre - half,
            high: centre + half,
            method,
        }
    }
}

/// The quantile of Student's t below which a share of it lies.
pub fn t_quantile(share: f64, freedom: f64) -> f64 {
    if freedom > NEARLY_NORMAL {
        // The first terms of the expansion about the normal quantile; the crate's search does not
        // end for very many degrees of freedom.
        let z = Normal::standard().inverse_cdf(share);
        return z + (z.powi(3) + z) / (4.0 * freedom);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(share))
}

/// The quantile that an interval reaches to on both sides.
fn t_two_sided(freedom: f64) -> f64 {
    t_quantile(0.5 + LEVEL / 2.0, freedom)
}

/// Of the mean of the distribution that the values come from, which may be skewed: the studentised
/// bootstrap (Hall 1992) with smoothed resamples (Polansky 2000). `None` of fewer than two values.
pub fn mean_interval(values: &[f64]) -> Option<Interval> {
    if !(3..=MOST_VALUES).contains(&values.len()) {
        return t_interval(values);
    }
    let centre = mean(values)?;
    let error = standard_error(values)?;
    // Values that do not differ beyond rounding say nothing of their spread.
    if error <= 1e-12 * centre.abs() {
        return Some(Interval::around(centre, 0.0, BOOTSTRAP_T));
    }
    let [low, high] = redraws(values.len()).studentised(values, centre, error);
    Some(Interval {
        low: centre - high * error,
        high: centre - low * error,
        method: BOOTSTRAP_T,
    })
}

/// Of the mean of values that lie evenly about it, as differences of paired runs do. `None` of fewer
/// than two values.
pub fn t_interval(values: &[f64]) -> Option<Interval> {
    let half = standard_error(values)? * t_two_sided(values.len() as f64 - 1.0);
    Some(Interval::around(mean(values)?, half, T))
}

/// Of the difference of the means of two samples that are not paired. `None` where one has fewer
/// than two values.
pub fn welch_interval(x: &[f64], y: &[f64]) -> Option<Interval> {
    let (error, freedom) = welch(standard_error(x)?, x.len(), standard_error(y)?, y.len());
    let half = if error > 0.0 {
        error * t_two_sided(freedom)
    } else {
        0.0
    };
    Some(Interval::around(mean(x)? - mean(y)?, half, WELCH))
}

/// Of the ratio of the means of two samples of positive values: Welch's interval for the logarithm,
/// by the delta method. `None` where one has fewer than two values or no positive mean.
pub fn ratio_interval(x: &[f64], y: &[f64]) -> Option<Interval> {
    let positive = |values: &[f64]| mean(values).filter(|&mean| mean > 0.0);
    let (above, below) = (positive(x)?, positive(y)?);
    let (error, freedom) = welch(
        standard_error(x)? / above,
        x.len(),
        standard_error(y)? / below,
        y.len(),
    );
    let factor = if error > 0.0 {
        (error * t_two_sided(freedom)).exp()
    } else {
        1.0
    };
    Some(Interval {
        low: above / below / factor,
        high: above / below * factor,
        method: WELCH,
    })
}

/// The error of a sum of two independent estimates, and its degrees of freedom (Welch-Satterthwaite).
fn welch(x: f64, nx: usize, y: f64, ny: usize) -> (f64, f64) {
    let (x, y) = (x * x, y * y);
    let freedom = (x + y).powi(2) / (x * x / (nx as f64 - 1.0) + y * y / (ny as f64 - 1.0));
    ((x + y).sqrt(), freedom)
}

/// Of the slope of a least-squares line with this residual sum of squares through `n` points whose
/// abscissae have this sum of squares about their mean. `None` of fewer than three points.
pub fn slope_interval(slope: f64, residual: f64, spread: f64, n: usize) -> Option<Interval> {
    let freedom = n.checked_sub(2).filter(|&freedom| freedom > 0)? as f64;
    let half = (residual / freedom / spread).sqrt() * t_two_sided(freedom);
    Some(Interval::around(slope, half, T))
}

/// The mean of what is left without the lowest and the highest quarter; `None` of no values.
pub fn iqm(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let out = sorted.len() / TRIMMED;
    mean(&sorted[out..sorted.len() - out])
}

/// Of the interquartile mean of strata pooled, each drawn anew by itself (Agarwal et al. 2021), but
/// by Student's t with the bootstrap's standard error instead of its percentiles, which are too
/// narrow for few runs. `None` where no stratum has two values.
pub fn iqm_interval(strata: &[Vec<f64>]) -> Option<Interval> {
    let pooled: Vec<f64> = strata.iter().flatten().copied().collect();
    let centre = iqm(&pooled)?;
    let freedom = pooled.len() - strata.iter().filter(|stratum| !stratum.is_empty()).count();
    if freedom == 0 {
        return None;
    }
    if pooled.len() > MOST_VALUES {
        return Some(winsorised(&pooled, centre));
    }
    let mut stream = Stream::new(IQM_KEY);
    let mut drawn = vec![0.0; pooled.len()];
    let redrawn: Vec<f64> = (0..IQM_REDRAWS)
        .filter_map(|_| {
            let mut place = 0;
            for stratum in strata {
                // A resample of n has (n - 1) / n of the variance of a sample of n.
                let n = stratum.len() as f64;
                let widen = if stratum.len() > 1 {
                    (n / (n - 1.0)).sqrt()
                } else {
                    1.0
                };
                let own = mean(stratum).unwrap_or(0.0);
                for _ in stratum {
                    let value = stratum[stream.below(stratum.len() as u64) as usize];
                    drawn[place] = own + (value - own) * widen;
                    place += 1;
                }
            }
            iqm(&drawn)
        })
        .collect();
    let half = redrawn.std_dev() * t_two_sided(freedom as f64);
    Some(Interval::around(centre, half, BOOTSTRAP_SE))
}

/// Tukey and McLaughlin (1963), for samples large enough.
fn winsorised(values: &[f64], centre: f64) -> Interval {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (n, out) = (sorted.len(), sorted.len() / TRIMMED);
    let (low, high) = (sorted[out], sorted[n - 1 - out]);
    let winsorised: Vec<f64> = sorted.iter().map(|value| value.clamp(low, high)).collect();
    let kept = (n - 2 * out) as f64;
    let variance = winsorised.variance() * (n as f64 - 1.0) / (kept * (kept - 1.0));
    Interval::around(centre, variance.sqrt() * t_two_sided(kept - 1.0), YUEN)
}

/// Of the mean; `None` of fewer than two values.
pub fn standard_error(values: &[f64]) -> Option<f64> {
    (values.len() > 1).then(|| values.std_dev() / (values.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn close(one: f64, other: f64) {
        assert!((one - other).abs() < 1e-6, "{one} is not {other}");
    }

    /// Limits as R gives them: `t.test(...)$conf.int`.
    #[test]
    fn t_intervals_are_those_of_the_textbook() {
        // Three values of mean 2 and deviation 1: 2 -+ 4.302653 / sqrt(3).
        let three = t_interval(&[1.0, 2.0, 3.0]).unwrap();
        assert!((t_quantile(0.975, 999.9) - t_quantile(0.975, 1_000.1)).abs() < 1e-5);
        close(t_quantile(0.975, f64::INFINITY), 1.959_963_985);
        close(three.low, 2.0 - 4.302_652_729_7 / 3.0_f64.sqrt());
        close(three.high, 2.0 + 4.302_652_729_7 / 3.0_f64.sqrt());
        assert_eq!(t_interval(&[4.0]), None);
        // Equal sizes and variances: 4 degrees of freedom, error sqrt(2 / 3).
        let welch = welch_interval(&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0]).unwrap();
        close(welch.low, -3.0 - 2.776_445_105_2 * (2.0_f64 / 3.0).sqrt());
        let ratio = ratio_interval(&[8.0, 8.0], &[2.0, 2.0]).unwrap();
        assert_eq!((ratio.low, ratio.high), (4.0, 4.0));
        assert_eq!(ratio_interval(&[8.0, 8.0], &[0.0, 0.0]), None);
        let slope = slope_interval(1.0, 2.0, 4.0, 4).unwrap();
        close(slope.high, 1.0 + 0.5 * 4.302_652_729_7);
        assert_eq!(slope_interval(1.0, 0.0, 4.0, 2), None);
    }

    #[test]
    fn what_is_skewed_has_a_skewed_interval() {
        // Nine good runs and a bad one: the mean may well be lower, hardly higher.
        let mut values = vec![0.9, 0.91, 0.92, 0.93, 0.94, 0.95, 0.96, 0.97, 0.98];
        values.push(0.3);
        let interval = mean_interval(&values).unwrap();
        let centre = mean(&values).unwrap();
        assert_eq!(interval.method, BOOTSTRAP_T);
        assert!(
            centre - interval.low > 1.5 * (interval.high - centre),
            "{interval:?}"
        );
        // Turned about, all is turned about, but for the draws.
        let turned: Vec<f64> = values.iter().map(|value| -value).collect();
        let turned = mean_interval(&turned).unwrap();
        assert!(turned.high + centre > 1.5 * (-centre - turned.low));
    }

    #[test]
    fn intervals_move_and_scale_with_the_values() {
        let values = [3.0, 5.0, 8.0, 1.0, 9.0];
        let moved: Vec<f64> = values.iter().map(|value| 100.0 + 2.0 * value).collect();
        for of in [mean_interval, t_interval, |values: &[f64]| {
            iqm_interval(&[values.to_vec()])
        }] {
            let (one, other) = (of(&values).unwrap(), of(&moved).unwrap());
            close(100.0 + 2.0 * one.low, other.low);
            close(100.0 + 2.0 * one.high, other.high);
            assert_eq!(of(&values), of(&values));
        }
    }

    #[test]
    fn few_values_have_wide_intervals_or_none() {
        assert_eq!(mean_interval(&[]), None);
        assert_eq!(mean_interval(&[4.0]), None);
        let equal = mean_interval(&[0.1; 3]).unwrap();
        assert!((equal.low, equal.high) == (0.1, 0.1) || equal.high - equal.low < 1e-15);
        assert_eq!(mean_interval(&[1.0, 3.0]).unwrap().method, T);
        assert_eq!(
            mean_interval(&vec![1.0; MOST_VALUES + 1]).unwrap().method,
            T
        );
        let three = mean_interval(&[1.0, 2.0, 3.0]).unwrap();
        assert!(
            three.high - three.low > 2.0 * 4.3 / 3.0_f64.sqrt(),
            "{three:?}"
        );
    }

    #[test]
    fn interquartile_means_leave_out_a_quarter_on_each_side() {
        assert_eq!(iqm(&[1.0, 2.0, 30.0]), Some(11.0));
        assert_eq!(iqm(&[100.0, 2.0, 4.0, -50.0]), Some(3.0));
        assert_eq!(iqm(&[]), None);
        let values: Vec<f64> = (0..20).map(f64::from).collect();
        assert_eq!(iqm(&values), Some(9.5));
        let one = iqm_interval(std::slice::from_ref(&values)).unwrap();
        assert!(one.low < 9.5 && 9.5 < one.high);
        // Two strata far apart, each narrow: what lies between them is no error.
        let strata = [vec![0.0, 0.1, 0.2, 0.1], vec![10.0, 10.1, 10.2, 10.1]];
        let apart = iqm_interval(&strata).unwrap();
        let pooled = iqm_interval(&[strata.concat()]).unwrap();
        assert!(apart.high - apart.low < 0.1 * (pooled.high - pooled.low));
        let many: Vec<f64> = (0..60).map(f64::from).collect();
        assert_eq!(iqm_interval(&[many]).unwrap().method, YUEN);
        assert_eq!(iqm_interval(&[vec![1.0], vec![2.0]]), None);
    }
}
