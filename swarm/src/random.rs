//! Counter-based random numbers: a stream is a key, a draw is a function of key and counter.
//!
//! One stream for each (run seed, arena, robot, purpose), so that no result depends on the order in
//! which robots, threads or arenas happen to be worked on, and a snapshot needs only the counter.

use serde::{Deserialize, Serialize};

/// What a stream is for. The numbers are part of every result: never reuse or change one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// Sensor noise.
    SensorNoise = 1,
    /// Wheel slip.
    WheelSlip = 2,
    /// Choice of actions and commands.
    Action = 3,
    /// Initial weights and mutation.
    Evolution = 4,
    /// Reservoir sampling.
    Sampling = 5,
    /// Initial centres of k-means.
    Clustering = 6,
    /// Random start poses.
    Placement = 7,
    /// Whom a robot hears first, and what it tells.
    Radio = 8,
    /// Random actions of the reference that model accuracy is measured against.
    Reference = 9,
}

/// Which arena of a run a stream belongs to. The numbers are part of every result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u64)]
pub enum Site {
    /// The arena in which visits count.
    Target = 1,
    /// The arena of phase 1.
    Training = 2,
}

/// A 64-bit mixer in which every input bit reaches every output bit (Moremur, P. Evensen).
#[inline(always)]
pub fn mix64(mut x: u64) -> u64 {
    x = (x ^ (x >> 27)).wrapping_mul(0x3C79_AC49_2BA7_B653);
    x = (x ^ (x >> 33)).wrapping_mul(0x1C69_B3F7_4AC4_AE35);
    x ^ (x >> 27)
}

/// The key of a stream.
pub fn stream_key(seed: u64, site: Site, robot: u64, purpose: Purpose) -> u64 {
    let mut key = mix64(seed.wrapping_add(0x9E37_79B9_7F4A_7C15));
    for part in [site as u64, robot, purpose as u64] {
        key = mix64(
            key ^ part
                .wrapping_mul(0xD6E8_FEB8_6659_FD93)
                .wrapping_add(0xA5A5_A5A5),
        );
    }
    key
}

/// The draw of a stream at a counter: 64 uniform bits.
#[inline(always)]
pub fn draw(key: u64, counter: u64) -> u64 {
    mix64(mix64(counter.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ key).wrapping_add(key))
}

/// A whole number below `bound` from 32 uniform bits (bias below bound / 2^32).
#[inline(always)]
pub fn below(bits: u32, bound: u32) -> u32 {
    ((u64::from(bits) * u64::from(bound)) >> 32) as u32
}

/// Uniform in [0, 1) from 32 uniform bits, on a grid of 2^-24.
#[inline(always)]
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A sequential reader of a stream, for work outside the step loop.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stream {
    key: u64,
    counter: u64,
}

impl Stream {
    /// The stream of a key, from its beginning.
    pub fn new(key: u64) -> Self {
        Self { key, counter: 0 }
    }

    /// The next 64 uniform bits.
    pub fn bits(&mut self) -> u64 {
        self.counter += 1;
        draw(self.key, self.counter)
    }

    /// Uniform in [0, 1), on a grid of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// A whole number below `bound`.
    pub fn below(&mut self, bound: u64) -> u64 {
        ((u128::from(self.bits()) * u128::from(bound)) >> 64) as u64
    }

    /// Standard normal (Box-Muller, through the portable `libm`).
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform()));
        radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_uniform_and_unrelated() {
        let a = stream_key(1, Site::Target, 0, Purpose::Action);
        let b = stream_key(1, Site::Target, 1, Purpose::Action);
        let n = 200_000;
        let (mut sum, mut product) = (0.0, 0.0);
        for i in 0..n {
            let x = (draw(a, i) >> 11) as f64 / 9_007_199_254_740_992.0 - 0.5;
            let y = (draw(b, i) >> 11) as f64 / 9_007_199_254_740_992.0 - 0.5;
            sum += x;
            product += x * y;
        }
        assert!((sum / n as f64).abs() < 0.003);
        assert!((product / n as f64).abs() < 0.001);
    }

    #[test]
    fn normal_has_the_moments_of_a_normal() {
        let mut s = Stream::new(9);
        let n = 200_000;
        let values: Vec<f64> = (0..n).map(|_| s.normal()).collect();
        let mean = values.iter().sum::<f64>() / n as f64;
        let var = values.iter().map(|v| v * v).sum::<f64>() / n as f64;
        let fourth = values.iter().map(|v| v.powi(4)).sum::<f64>() / n as f64;
        assert!(mean.abs() < 0.01 && (var - 1.0).abs() < 0.02 && (fourth - 3.0).abs() < 0.12);
    }

    #[test]
    fn below_stays_below() {
        for bound in [1, 2, 3, 60, 250, u32::MAX] {
            assert!(below(u32::MAX, bound) < bound);
            assert_eq!(below(0, bound), 0);
        }
    }
}
