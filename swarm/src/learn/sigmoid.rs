//! The logistic function and tanh on eight lanes with `+ - * /` only, the same bits everywhere.

use crate::lanes::F8;

/// Where tanh is 1 to the precision of `f32`; beyond it the argument is clamped.
const CLAMP: f32 = 7.905_311;

/// Coefficients of `x, x^3, .. x^13` above and `1, x^2, x^4, x^6` below the line: the rational
/// minimax approximation of Eigen's `ptanh`.
const ABOVE: [f32; 7] = [
    4.893_524_6e-3,
    6.372_619_3e-4,
    1.485_722_4e-5,
    5.122_297_1e-8,
    -8.604_672e-11,
    2.000_188e-13,
    -2.760_768_5e-16,
];
const BELOW: [f32; 4] = [4.893_525e-3, 2.268_434_6e-3, 1.185_347_1e-4, 1.198_258_4e-6];

/// tanh of every lane; rounding can take it past 1 or -1 by 5e-7.
#[inline(always)]
fn ratio(x: F8) -> F8 {
    let x = x.max(F8::splat(-CLAMP)).min(F8::splat(CLAMP));
    let square = x * x;
    let mut above = F8::splat(ABOVE[6]);
    for coefficient in ABOVE[..6].iter().rev() {
        above = above * square + F8::splat(*coefficient);
    }
    let mut below = F8::splat(BELOW[3]);
    for coefficient in BELOW[..3].iter().rev() {
        below = below * square + F8::splat(*coefficient);
    }
    x * above / below
}

/// tanh of every lane, with an absolute error of at most 5e-7; always within [-1, 1].
///
/// Not a number counts as minus infinity.
#[inline(always)]
pub fn tanh(x: F8) -> F8 {
    ratio(x).max(F8::splat(-1.0)).min(F8::splat(1.0))
}

/// The logistic function 1 / (1 + exp(-2 x)) of every lane, from half of the usual argument.
///
/// Absolute error at most 3e-7, also past 0 and 1. Not a number counts as minus infinity.
#[inline(always)]
pub fn logistic_of_double(x: F8) -> F8 {
    F8::splat(0.5) + F8::splat(0.5) * ratio(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::LANES;

    fn scalar_tanh(x: f32) -> f32 {
        let x = x.clamp(-CLAMP, CLAMP);
        let s = x * x;
        let [a1, a3, a5, a7, a9, a11, a13] = ABOVE;
        let [b0, b2, b4, b6] = BELOW;
        let above = x * ((((((a13 * s + a11) * s + a9) * s + a7) * s + a5) * s + a3) * s + a1);
        (above / (((b6 * s + b4) * s + b2) * s + b0)).clamp(-1.0, 1.0)
    }

    fn arguments() -> impl Iterator<Item = F8> {
        (-160_000..160_000).step_by(LANES).map(|i| {
            let mut x = [0.0; LANES];
            for (k, value) in x.iter_mut().enumerate() {
                *value = (i + k as i32) as f32 * 6.25e-5 + 1e-6;
            }
            F8(x)
        })
    }

    #[test]
    fn stays_within_its_error_bound() {
        for x in arguments() {
            let (t, g) = (tanh(x), logistic_of_double(x));
            for k in 0..LANES {
                let exact = f64::from(x.0[k]);
                assert!(
                    (f64::from(t.0[k]) - libm::tanh(exact)).abs() <= 5e-7,
                    "tanh {exact}"
                );
                assert!(t.0[k].abs() <= 1.0, "tanh {exact}");
                let logistic = 1.0 / (1.0 + libm::exp(-2.0 * exact));
                assert!(
                    (f64::from(g.0[k]) - logistic).abs() <= 3e-7,
                    "logistic {exact}"
                );
            }
        }
    }

    #[test]
    fn equals_the_scalar_twin_to_the_bit() {
        for x in arguments() {
            for (lane, argument) in tanh(x).0.iter().zip(x.0) {
                assert_eq!(
                    lane.to_bits(),
                    scalar_tanh(argument).to_bits(),
                    "{argument}"
                );
            }
        }
    }

    #[test]
    fn is_finite_for_whatever_comes() {
        let odd = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            0.0,
            -0.0,
            1e-40,
        ];
        assert!(tanh(F8(odd)).0.iter().all(|t| t.abs() <= 1.0));
        assert!(
            logistic_of_double(F8(odd))
                .0
                .iter()
                .all(|g| (g - 0.5).abs() < 0.500_001)
        );
    }
}
