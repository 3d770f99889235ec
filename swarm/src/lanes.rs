//! Eight lanes of `f32` or `u32` as plain arrays.
//!
//! The compiler turns them into vector registers; functions built for AVX2 and for the portable
//! target run the same source with only `+ - * / sqrt`, so both give the same bits.

#![allow(
    clippy::needless_range_loop,
    reason = "plain counted loops over all lanes are what the compiler turns into vectors"
)]

use std::ops::{Add, Div, Mul, Sub};

/// Number of lanes.
pub const LANES: usize = 8;

/// Eight `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct F8(pub [f32; LANES]);

/// Eight `u32`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C, align(32))]
pub struct U8(pub [u32; LANES]);

/// Eight truth values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct M8(pub [bool; LANES]);

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for F8 {
            type Output = F8;
            #[inline(always)]
            fn $method(self, other: F8) -> F8 {
                let mut out = [0.0; LANES];
                for k in 0..LANES { out[k] = self.0[k] $op other.0[k]; }
                F8(out)
            }
        }
    };
}
lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl F8 {
    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        F8([x; LANES])
    }

    /// The first eight values of a slice.
    #[inline(always)]
    pub fn load(values: &[f32]) -> Self {
        let mut out = [0.0; LANES];
        out.copy_from_slice(&values[..LANES]);
        F8(out)
    }

    /// Lane by lane, the smaller (the second where they compare unordered).
    #[inline(always)]
    pub fn min(self, other: F8) -> F8 {
        let mut out = [0.0; LANES];
        for k in 0..LANES {
            out[k] = if self.0[k] < other.0[k] {
                self.0[k]
            } else {
                other.0[k]
            };
        }
        F8(out)
    }

    /// Lane by lane, the larger (the second where they compare unordered).
    #[inline(always)]
    pub fn max(self, other: F8) -> F8 {
        let mut out = [0.0; LANES];
        for k in 0..LANES {
            out[k] = if self.0[k] > other.0[k] {
                self.0[k]
            } else {
                other.0[k]
            };
        }
        F8(out)
    }

    /// Lane by lane, `self < other`.
    #[inline(always)]
    pub fn lt(self, other: F8) -> M8 {
        let mut out = [false; LANES];
        for k in 0..LANES {
            out[k] = self.0[k] < other.0[k];
        }
        M8(out)
    }

    /// Lane by lane, `self <= other`.
    #[inline(always)]
    pub fn le(self, other: F8) -> M8 {
        let mut out = [false; LANES];
        for k in 0..LANES {
            out[k] = self.0[k] <= other.0[k];
        }
        M8(out)
    }

    /// Lane by lane, the square root.
    #[inline(always)]
    pub fn sqrt(self) -> F8 {
        let mut out = [0.0; LANES];
        for k in 0..LANES {
            out[k] = self.0[k].sqrt();
        }
        F8(out)
    }

    /// The sum of all lanes, in a fixed tree order.
    #[inline(always)]
    pub fn sum(self) -> f32 {
        let v = self.0;
        let (a, b, c, d) = (v[0] + v[4], v[1] + v[5], v[2] + v[6], v[3] + v[7]);
        (a + c) + (b + d)
    }
}

impl M8 {
    /// Lane by lane, both.
    #[inline(always)]
    pub fn and(self, other: M8) -> M8 {
        let mut out = [false; LANES];
        for k in 0..LANES {
            out[k] = self.0[k] & other.0[k];
        }
        M8(out)
    }

    /// Lane by lane, `yes` where true, else `no`.
    #[inline(always)]
    pub fn select(self, yes: F8, no: F8) -> F8 {
        let mut out = [0.0; LANES];
        for k in 0..LANES {
            out[k] = if self.0[k] { yes.0[k] } else { no.0[k] };
        }
        F8(out)
    }

    /// Lane by lane, `yes` where true, else `no`.
    #[inline(always)]
    pub fn select_u(self, yes: U8, no: U8) -> U8 {
        let mut out = [0; LANES];
        for k in 0..LANES {
            out[k] = if self.0[k] { yes.0[k] } else { no.0[k] };
        }
        U8(out)
    }
}

impl U8 {
    /// The same value in every lane.
    #[inline(always)]
    pub fn splat(x: u32) -> Self {
        U8([x; LANES])
    }

    /// Lane by lane, wrapping.
    #[inline(always)]
    pub fn wrapping_add(self, other: U8) -> U8 {
        let mut out = [0; LANES];
        for k in 0..LANES {
            out[k] = self.0[k].wrapping_add(other.0[k]);
        }
        U8(out)
    }

    /// Lane by lane, wrapping, by one factor.
    #[inline(always)]
    pub fn wrapping_mul(self, factor: u32) -> U8 {
        let mut out = [0; LANES];
        for k in 0..LANES {
            out[k] = self.0[k].wrapping_mul(factor);
        }
        U8(out)
    }

    /// Lane by lane.
    #[inline(always)]
    pub fn xor(self, other: U8) -> U8 {
        let mut out = [0; LANES];
        for k in 0..LANES {
            out[k] = self.0[k] ^ other.0[k];
        }
        U8(out)
    }

    /// Lane by lane, logical shift right.
    #[inline(always)]
    pub fn shifted_right(self, bits: u32) -> U8 {
        let mut out = [0; LANES];
        for k in 0..LANES {
            out[k] = self.0[k] >> bits;
        }
        U8(out)
    }

    /// Lane by lane.
    #[inline(always)]
    pub fn and(self, mask: u32) -> U8 {
        let mut out = [0; LANES];
        for k in 0..LANES {
            out[k] = self.0[k] & mask;
        }
        U8(out)
    }

    /// Lane by lane, as a signed number (values must be below 2^31).
    #[inline(always)]
    pub fn to_f32(self) -> F8 {
        let mut out = [0.0; LANES];
        for k in 0..LANES {
            out[k] = self.0[k] as i32 as f32;
        }
        F8(out)
    }
}
