//! The percentile bootstrap: runs are drawn anew with replacement, whole curves at a time.

use swarm::random::Stream;

/// Times that the runs are drawn anew.
pub const RESAMPLES: usize = 1_000;
/// Key of the stream of draws: the same data gives the same band.
const KEY: u64 = 0x6368_6170_7465_7235;

/// The mean of some curves with a pointwise band.
pub struct Band {
    pub mean: Vec<f64>,
    /// The 2.5th percentile of the resampled means.
    pub low: Vec<f64>,
    /// The 97.5th.
    pub high: Vec<f64>,
}

/// The band of at least one curve; all have the same number of points.
pub fn band(curves: &[Vec<f64>]) -> Band {
    let points = curves.first().map_or(0, Vec::len);
    let runs = curves.len();
    let mut stream = Stream::new(KEY);
    let mut drawn: Vec<Vec<f64>> = vec![Vec::with_capacity(RESAMPLES); points];
    for _ in 0..RESAMPLES {
        let chosen: Vec<&Vec<f64>> = (0..runs)
            .map(|_| &curves[stream.below(runs as u64) as usize])
            .collect();
        for (point, means) in drawn.iter_mut().enumerate() {
            means.push(chosen.iter().map(|curve| curve[point]).sum::<f64>() / runs as f64);
        }
    }
    for means in &mut drawn {
        means.sort_by(f64::total_cmp);
    }
    let at = |share: f64| {
        let place = (share * (RESAMPLES - 1) as f64).round() as usize;
        drawn.iter().map(|means| means[place]).collect()
    };
    Band {
        mean: (0..points)
            .map(|point| curves.iter().map(|curve| curve[point]).sum::<f64>() / runs as f64)
            .collect(),
        low: at(0.025),
        high: at(0.975),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_holds_the_mean_and_narrows_with_more_runs() {
        let curves = |runs: u32| -> Vec<Vec<f64>> {
            (0..runs)
                .map(|run| vec![0.0, f64::from(run % 4), 7.0])
                .collect()
        };
        let few = band(&curves(4));
        assert_eq!(few.mean, [0.0, 1.5, 7.0]);
        assert!(few.low[1] < 1.5 && 1.5 < few.high[1]);
        assert_eq!((few.low[2], few.high[2]), (7.0, 7.0));
        let many = band(&curves(40));
        assert!(many.high[1] - many.low[1] < 0.5 * (few.high[1] - few.low[1]));
    }

    #[test]
    fn the_band_is_near_that_of_the_normal_distribution() {
        // Sixteen runs of mean 0 and standard error 0.25.
        let curves: Vec<Vec<f64>> = (0..16)
            .map(|run| vec![if run % 2 == 0 { 1.0 } else { -1.0 }])
            .collect();
        let band = band(&curves);
        assert!((band.high[0] - 0.49).abs() < 0.07, "{}", band.high[0]);
        assert!((band.low[0] + 0.49).abs() < 0.07, "{}", band.low[0]);
    }

    #[test]
    fn equal_data_gives_an_equal_band() {
        let curves = vec![vec![1.0, 2.0], vec![3.0, 5.0], vec![4.0, 4.0]];
        assert_eq!(band(&curves).low, band(&curves).low);
    }
}
