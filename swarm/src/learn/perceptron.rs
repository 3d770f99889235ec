//! The crawlers' controller: a perceptron 8-10-2 with biases (eq. 4.7, 4.8).

use serde::{Deserialize, Serialize};

use super::are_sound;
use super::sigmoid::{logistic_of_double, tanh};
use crate::dimensions::{PROXIMITY_SENSORS, WHEELS};
use crate::lanes::{F8, LANES};

const INPUTS: usize = PROXIMITY_SENSORS;
/// Hidden units.
pub const HIDDEN: usize = 10;
const OUTPUTS: usize = WHEELS;
/// Hidden units padded to whole lanes.
const PADDED: usize = 2 * LANES;

/// Steepest sigmoid.
pub const MOST_SLOPE: f64 = 100.0;

/// Weights of the perceptron, biases included.
pub const WEIGHTS: usize = HIDDEN * (INPUTS + 1) + OUTPUTS * (HIDDEN + 1);

/// A perceptron with its weights laid out for lanes.
///
/// Half the sigmoid's slope is multiplied into the weights when they are loaded, as
/// 1/(1 + exp(-2x)) = (1 + tanh x)/2, and a wheel command 2o - 1 is then tanh itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C, align(32))]
pub struct Perceptron {
    /// Row d: weights from input d to every hidden unit; the last row holds the biases.
    hidden: [[f32; PADDED]; INPUTS + 1],
    /// Row h: weights from hidden unit h to both outputs; the last row holds the biases.
    output: [[f32; OUTPUTS]; HIDDEN + 1],
}

impl Perceptron {
    /// All weights 0: its commands are 0.
    pub fn new() -> Self {
        Self {
            hidden: [[0.0; PADDED]; INPUTS + 1],
            output: [[0.0; OUTPUTS]; HIDDEN + 1],
        }
    }

    /// Whether saved weights can be reckoned with.
    pub fn is_sound(&self) -> bool {
        are_sound(self.hidden.as_flattened()) && are_sound(self.output.as_flattened())
    }

    /// Takes the weights of a genome.
    ///
    /// Order: for each hidden unit its 8 input weights and its bias, then for each output (left,
    /// right wheel) its 10 hidden weights and its bias. `slope` is that of g(z) = 1/(1 + exp(-slope z)).
    ///
    /// # Panics
    /// When the genome is not of [`WEIGHTS`] weights.
    pub fn load(&mut self, genome: &[f32], slope: f64) {
        assert_eq!(genome.len(), WEIGHTS, "weights of a perceptron");
        let scaled = |weight: f32| (0.5 * slope * f64::from(weight)) as f32;
        let (hidden, output) = genome.split_at(HIDDEN * (INPUTS + 1));
        for (unit, weights) in hidden.chunks_exact(INPUTS + 1).enumerate() {
            for (row, weight) in self.hidden.iter_mut().zip(weights) {
                row[unit] = scaled(*weight);
            }
        }
        for (o, weights) in output.chunks_exact(HIDDEN + 1).enumerate() {
            for (row, weight) in self.output.iter_mut().zip(weights) {
                row[o] = scaled(*weight);
            }
        }
    }

    /// Wheel commands (left, right) in [-1, 1] for a sensor vector.
    ///
    /// The outputs add up the even hidden units, the odd ones, then both.
    #[inline(always)]
    pub fn act(&self, s: &[f32; INPUTS]) -> [f32; OUTPUTS] {
        let (low, high) = self.hidden_lanes(s);
        let mut even = pair(self.output[HIDDEN]);
        let mut odd = F8::splat(0.0);
        for (first, units) in [(0, low.0), (LANES, high.0)] {
            for k in (0..LANES.min(HIDDEN - first)).step_by(2) {
                even = even + F8::splat(units[k]) * pair(self.output[first + k]);
                odd = odd + F8::splat(units[k + 1]) * pair(self.output[first + k + 1]);
            }
        }
        let commands = tanh(even + odd);
        [commands.0[0], commands.0[1]]
    }

    /// Values of the hidden units (0 to 1, give or take 3e-7) for a sensor vector.
    #[inline(always)]
    pub fn hidden(&self, s: &[f32; INPUTS]) -> [f32; HIDDEN] {
        let (low, high) = self.hidden_lanes(s);
        std::array::from_fn(|k| {
            if k < LANES {
                low.0[k]
            } else {
                high.0[k - LANES]
            }
        })
    }

    #[inline(always)]
    fn hidden_lanes(&self, s: &[f32; INPUTS]) -> (F8, F8) {
        let mut low = F8::load(&self.hidden[INPUTS]);
        let mut high = F8::load(&self.hidden[INPUTS][LANES..]);
        for (input, weights) in s.iter().zip(&self.hidden) {
            let input = F8::splat(*input);
            low = low + input * F8::load(weights);
            high = high + input * F8::load(&weights[LANES..]);
        }
        (logistic_of_double(low), logistic_of_double(high))
    }
}

/// Two values in the first lanes, zeros in the others.
#[inline(always)]
fn pair(values: [f32; OUTPUTS]) -> F8 {
    F8([values[0], values[1], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
}

impl Default for Perceptron {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::random::Stream;

    /// Eq. 4.7 and 4.8 as they stand, in `f64`.
    fn oracle(genome: &[f32], slope: f64, s: &[f32; 8]) -> ([f64; 10], [f64; 2]) {
        let g = |z: f64| 1.0 / (1.0 + libm::exp(-slope * z));
        let layer = |weights: &[f32], inputs: &[f64]| -> Vec<f64> {
            let units = weights.chunks(inputs.len() + 1);
            let z = |unit: &[f32]| -> f64 {
                let bias = f64::from(unit[inputs.len()]);
                bias + unit
                    .iter()
                    .zip(inputs)
                    .map(|(w, x)| f64::from(*w) * x)
                    .sum::<f64>()
            };
            units.map(|unit| g(z(unit))).collect()
        };
        let hidden = layer(&genome[..90], &s.map(f64::from));
        let output = layer(&genome[90..], &hidden);
        (
            hidden.try_into().unwrap(),
            [2.0 * output[0] - 1.0, 2.0 * output[1] - 1.0],
        )
    }

    #[test]
    fn equals_the_equations() {
        let mut stream = Stream::new(3);
        let mut perceptron = Perceptron::new();
        for round in 0..2_000 {
            let spread = [0.1, 0.5, 2.0][round % 3];
            let slope = [1.0, 2.0, 4.0][round / 3 % 3];
            let genome: Vec<f32> = (0..WEIGHTS)
                .map(|_| (spread * stream.normal()) as f32)
                .collect();
            let s = std::array::from_fn(|_| 2.0 * stream.uniform() as f32 - 1.0);
            perceptron.load(&genome, slope);
            let (hidden, command) = oracle(&genome, slope, &s);
            for (got, want) in perceptron.act(&s).iter().zip(command) {
                assert!((f64::from(*got) - want).abs() < 5e-6, "{got} {want}");
            }
            for (got, want) in perceptron.hidden(&s).iter().zip(hidden) {
                assert!((f64::from(*got) - want).abs() < 5e-6, "{got} {want}");
            }
        }
    }

    /// The same sums in the same order, one number at a time.
    #[test]
    fn equals_its_scalar_twin_to_the_bit() {
        let mut stream = Stream::new(8);
        let mut perceptron = Perceptron::new();
        let one = |f: fn(F8) -> F8, z: f32| f(F8::splat(z)).0[0];
        for _ in 0..500 {
            let genome: Vec<f32> = (0..WEIGHTS).map(|_| stream.normal() as f32).collect();
            let s: [f32; 8] = std::array::from_fn(|_| 2.0 * stream.uniform() as f32 - 1.0);
            perceptron.load(&genome, 2.0);
            let mut hidden = [0.0; PADDED];
            for (unit, value) in hidden.iter_mut().enumerate() {
                let mut z = perceptron.hidden[8][unit];
                for (d, input) in s.iter().enumerate() {
                    z += input * perceptron.hidden[d][unit];
                }
                *value = one(logistic_of_double, z);
            }
            let output = [0, 1].map(|o| {
                let (mut even, mut odd) = (perceptron.output[10][o], 0.0);
                for h in (0..10).step_by(2) {
                    even += hidden[h] * perceptron.output[h][o];
                    odd += hidden[h + 1] * perceptron.output[h + 1][o];
                }
                one(tanh, even + odd)
            });
            assert_eq!(
                perceptron.act(&s).map(f32::to_bits),
                output.map(f32::to_bits)
            );
        }
    }

    #[test]
    fn commands_are_finite_for_any_weights() {
        let mut perceptron = Perceptron::new();
        perceptron.load(&[f32::MAX; WEIGHTS], 100.0);
        let commands = perceptron.act(&[-1.0, 1.0, 0.0, 1.0, -1.0, 1.0, 1.0, -1.0]);
        assert!(commands.iter().all(|c| c.abs() <= 1.0));
    }
}
