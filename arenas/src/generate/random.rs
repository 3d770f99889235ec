//! Random draws whose values are fixed by this file and the PCG64 algorithm alone; a library's
//! range sampling may change its values with its version.

use rand_core::Rng;
use rand_pcg::Pcg64;

/// Stream of PCG64 that belongs to the generators.
const STREAM: u128 = 0x6172_656e_6173;

pub(super) struct Random(Pcg64);

impl Random {
    pub fn new(seed: u64) -> Self {
        // The seed stands in both halves so that near seeds differ in the high bits, too.
        let state = u128::from(seed) << 64 | u128::from(!seed);
        Self(Pcg64::new(state, STREAM))
    }

    /// Uniform below `bound`, which is positive: multiply and shift, the few uneven draws rejected
    /// (Lemire 2019).
    pub fn below(&mut self, bound: usize) -> usize {
        let bound = bound as u64;
        let uneven = bound.wrapping_neg() % bound;
        loop {
            let product = u128::from(self.0.next_u64()) * u128::from(bound);
            if product as u64 >= uneven {
                return (product >> 64) as usize;
            }
        }
    }

    /// Uniform in [0, 1), a multiple of 2^-53.
    pub fn unit(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * SCALE
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Uniform direction: a point drawn in the unit disc, pushed to its rim. No sine or cosine,
    /// whose last bit differs between platforms.
    pub fn direction(&mut self) -> [f64; 2] {
        loop {
            let [x, y] = [2.0 * self.unit() - 1.0, 2.0 * self.unit() - 1.0];
            let squared = x * x + y * y;
            if (0.01..=1.0).contains(&squared) {
                let length = squared.sqrt();
                return [x / length, y / length];
            }
        }
    }
}
