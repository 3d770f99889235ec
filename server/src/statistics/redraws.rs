//! Resamples for the bootstrap: which values are drawn and by how much each is moved, the same for
//! all samples of one size, drawn once.

use std::sync::OnceLock;

use swarm::random::Stream;

/// Largest sample that is drawn anew; beyond it Student's t holds as well.
pub const MOST_VALUES: usize = 50;
/// Resamples: with 1,999 the 50th from either end is the 2.5th percentile.
const RESAMPLES: usize = 1_999;
const TAIL: usize = 50;
/// Standard deviation of the moves, in standard deviations of the sample over its size. Without moves
/// one resample in nine of three values has no spread at all.
const SMOOTHING: f64 = 1.5;
/// Key of the stream of draws: the same runs give the same interval.
const KEY: u64 = 0x626f_6f74_7374_7261;

/// The resamples of samples of one size.
pub struct Redraws {
    n: usize,
    drawn: Vec<u8>,
    /// Even from -1 to 1, times the root of 3: of variance 1.
    moved: Vec<f32>,
}

/// The resamples of samples of 3 to [`MOST_VALUES`] values.
pub fn redraws(n: usize) -> &'static Redraws {
    static BY_SIZE: [OnceLock<Redraws>; MOST_VALUES + 1] =
        [const { OnceLock::new() }; MOST_VALUES + 1];
    BY_SIZE[n].get_or_init(|| Redraws::new(n))
}

impl Redraws {
    fn new(n: usize) -> Self {
        let mut stream = Stream::new(KEY ^ n as u64);
        let all = RESAMPLES * n;
        Self {
            n,
            drawn: (0..all).map(|_| stream.below(n as u64) as u8).collect(),
            moved: (0..all)
                .map(|_| (12.0_f64.sqrt() * (stream.uniform() - 0.5)) as f32)
                .collect(),
        }
    }

    /// The 2.5th and the 97.5th percentile of (mean of a resample - mean) over the resample's
    /// standard error. The sample's own standard error is `error`, above 0.
    pub fn studentised(&self, values: &[f64], mean: f64, error: f64) -> [f64; 2] {
        let n = self.n as f64;
        // About 0 and in units of the standard deviation, so that no size matters.
        let deviation = error * n.sqrt();
        let scaled: Vec<f64> = values
            .iter()
            .map(|value| (value - mean) / deviation)
            .collect();
        let bandwidth = SMOOTHING / n;
        let resamples = self
            .drawn
            .chunks_exact(self.n)
            .zip(self.moved.chunks_exact(self.n));
        let mut ratios: Vec<f64> = resamples
            .map(|(drawn, moved)| {
                let (mut sum, mut squares) = (0.0, 0.0);
                for (&drawn, &moved) in drawn.iter().zip(moved) {
                    let value = scaled[usize::from(drawn)] + bandwidth * f64::from(moved);
                    sum += value;
                    squares += value * value;
                }
                // Values are about 0 and of size 1: the difference of squares loses nothing.
                let variance = (squares - sum * sum / n) / (n - 1.0);
                sum / (variance * n).max(f64::MIN_POSITIVE).sqrt()
            })
            .collect();
        let (_, &mut low, above) = ratios.select_nth_unstable_by(TAIL - 1, f64::total_cmp);
        let place = RESAMPLES - TAIL - TAIL;
        let (_, &mut high, _) = above.select_nth_unstable_by(place, f64::total_cmp);
        [low, high]
    }
}

#[cfg(test)]
mod tests {
    use statrs::statistics::Statistics;

    use super::*;

    #[test]
    fn percentiles_are_the_fiftieth_from_either_end() {
        let values = [1.0, 4.0, 2.0, 8.0];
        let of = redraws(4);
        let error = values.std_dev() / 2.0;
        let [low, high] = of.studentised(&values, 3.75, error);
        assert!(low < -2.0 && high > 1.0, "{low} {high}");
        assert_eq!(of.drawn.len(), 4 * RESAMPLES);
        assert!(of.drawn.iter().all(|&drawn| drawn < 4));
        let variance = of.moved.iter().map(|&moved| f64::from(moved)).variance();
        assert!((variance - 1.0).abs() < 0.05, "{variance}");
    }
}
