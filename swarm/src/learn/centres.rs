//! Cluster centres laid out for eight lanes, and the nearest of them to a vector.
//!
//! Brute force: at the sizes of the learner (tens of centres) no index structure is faster.

use serde::{Deserialize, Serialize};

use super::{are_sound, flat};
use crate::lanes::{F8, LANES, U8};
use crate::prefetch::prefetch;

/// Coordinate of the lanes that hold no centre: farther than anything, its square still finite.
const FAR: f32 = 1e18;

/// Most centres that saved state may have room for: points of the largest sample.
const MOST: u32 = 1_000_000;

/// At most `cap` centres of `D` coordinates.
///
/// Blocks of eight centres, dimension by dimension inside a block. All memory is taken when it is
/// made; a snapshot holds the centres alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "Stored<D>", try_from = "Stored<D>")]
pub struct Centres<const D: usize> {
    blocks: Vec<[F8; D]>,
    len: u32,
    cap: u32,
}

#[derive(Serialize, Deserialize)]
struct Stored<const D: usize> {
    cap: u32,
    #[serde(with = "flat")]
    centres: Vec<[f32; D]>,
}

impl<const D: usize> From<Centres<D>> for Stored<D> {
    fn from(centres: Centres<D>) -> Self {
        Stored {
            cap: centres.cap,
            centres: centres.iter().collect(),
        }
    }
}

impl<const D: usize> TryFrom<Stored<D>> for Centres<D> {
    type Error = &'static str;

    fn try_from(stored: Stored<D>) -> Result<Self, Self::Error> {
        if stored.centres.len() > stored.cap as usize || stored.cap > MOST {
            return Err("more centres than there can be");
        }
        if !are_sound(stored.centres.as_flattened()) {
            return Err("centres are out of range");
        }
        Ok(Self::with(stored.cap, &stored.centres))
    }
}

impl<const D: usize> Centres<D> {
    /// No centres, and room for `cap`.
    pub fn new(cap: u32) -> Self {
        let blocks = vec![[F8([FAR; LANES]); D]; (cap as usize).div_ceil(LANES)];
        Self {
            blocks,
            len: 0,
            cap,
        }
    }

    /// Exactly these centres, in this order.
    pub fn from_points(points: &[[f32; D]]) -> Self {
        Self::with(points.len() as u32, points)
    }

    fn with(cap: u32, points: &[[f32; D]]) -> Self {
        let mut centres = Centres::new(cap);
        points.iter().for_each(|point| centres.push(point));
        centres
    }

    /// Most centres that there is room for.
    pub fn cap(&self) -> u32 {
        self.cap
    }

    /// Number of centres.
    #[inline(always)]
    pub fn len(&self) -> u32 {
        self.len
    }

    /// Whether there are none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether there is no room for another.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.len == self.cap
    }

    /// Adds a centre; its index is the old length.
    ///
    /// # Panics
    /// When the centres are full.
    #[inline(always)]
    pub fn push(&mut self, x: &[f32; D]) {
        assert!(!self.is_full(), "no room for another centre");
        self.len += 1;
        self.set(self.len - 1, x);
    }

    /// Moves a centre.
    ///
    /// # Panics
    /// When there is none of this index.
    #[inline(always)]
    pub fn set(&mut self, i: u32, x: &[f32; D]) {
        assert!(i < self.len, "no such centre");
        let block = &mut self.blocks[i as usize / LANES];
        for (lanes, value) in block.iter_mut().zip(x) {
            lanes.0[i as usize % LANES] = *value;
        }
    }

    /// The coordinates of a centre.
    ///
    /// # Panics
    /// When there is none of this index.
    #[inline(always)]
    pub fn centre(&self, i: u32) -> [f32; D] {
        assert!(i < self.len, "no such centre");
        let block = &self.blocks[i as usize / LANES];
        std::array::from_fn(|d| block[d].0[i as usize % LANES])
    }

    /// All centres in order.
    pub fn iter(&self) -> impl Iterator<Item = [f32; D]> {
        (0..self.len).map(|i| self.centre(i))
    }

    /// Index of the nearest centre (the lowest on ties) and its squared Euclidean distance.
    ///
    /// `(0, infinity)` when there are no centres. The squares are added in order of dimension.
    #[inline(always)]
    pub fn nearest(&self, x: &[f32; D]) -> (u32, f32) {
        let mut best = F8::splat(f32::INFINITY);
        let mut best_block = U8::splat(0);
        for (b, block) in self.used().iter().enumerate() {
            let squared = squared_distances(x, block);
            let closer = squared.lt(best);
            best = closer.select(squared, best);
            best_block = closer.select_u(U8::splat(b as u32), best_block);
        }
        first_minimum(best, best_block)
    }

    /// As [`Self::nearest`], with the squared distance of the second nearest centre as well
    /// (infinity when there is none, the same when two are as near).
    #[inline(always)]
    pub fn nearest_two(&self, x: &[f32; D]) -> (u32, f32, f32) {
        let mut best = F8::splat(f32::INFINITY);
        let mut second = best;
        let mut best_block = U8::splat(0);
        for (b, block) in self.used().iter().enumerate() {
            let squared = squared_distances(x, block);
            second = second.min(best.max(squared));
            let closer = squared.lt(best);
            best = closer.select(squared, best);
            best_block = closer.select_u(U8::splat(b as u32), best_block);
        }
        let (index, squared) = first_minimum(best, best_block);
        let mut others = best;
        others.0[index as usize % LANES] = second.0[index as usize % LANES];
        let runner_up = first_minimum(others, best_block).1;
        let alone = runner_up >= FAR;
        (
            index,
            squared,
            if alone { f32::INFINITY } else { runner_up },
        )
    }

    /// Blocks with at least one centre.
    #[inline(always)]
    fn used(&self) -> &[[F8; D]] {
        &self.blocks[..(self.len as usize).div_ceil(LANES)]
    }

    /// Asks for the memory that a search needs.
    #[inline(always)]
    pub fn expect_search(&self) {
        prefetch(&self.blocks[..]);
    }

    /// Bytes held besides the value itself by centres with room for `cap`.
    pub fn heap_bytes_for(cap: u32) -> u64 {
        u64::from(cap).div_ceil(LANES as u64) * size_of::<[F8; D]>() as u64
    }

    /// Bytes held besides the value itself, exactly counted.
    pub fn heap_bytes(&self) -> u64 {
        Self::heap_bytes_for(self.cap)
    }
}

/// Squared distances of a vector to the centres of a block.
#[inline(always)]
fn squared_distances<const D: usize>(x: &[f32; D], block: &[F8; D]) -> F8 {
    let difference = F8::splat(x[0]) - block[0];
    let mut squared = difference * difference;
    for d in 1..D {
        let difference = F8::splat(x[d]) - block[d];
        squared = squared + difference * difference;
    }
    squared
}

/// The smallest of eight non-negative values with the index `block * 8 + lane`, lowest on ties.
///
/// Non-negative floats are ordered as their bits are, so one whole number holds value and index.
#[inline(always)]
fn first_minimum(values: F8, block: U8) -> (u32, f32) {
    let keys: [i64; LANES] = std::array::from_fn(|k| {
        let index = block.0[k] * LANES as u32 + k as u32;
        (i64::from(values.0[k].to_bits()) << 32) | i64::from(index)
    });
    let pairs = [
        keys[0].min(keys[1]),
        keys[2].min(keys[3]),
        keys[4].min(keys[5]),
        keys[6].min(keys[7]),
    ];
    let key = pairs[0].min(pairs[1]).min(pairs[2].min(pairs[3]));
    (key as u32, f32::from_bits((key >> 32) as u32))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::random::Stream;

    fn oracle<const D: usize>(points: &[[f32; D]], x: &[f32; D]) -> (u32, f32) {
        let mut best = (0, f32::INFINITY);
        for (i, point) in points.iter().enumerate() {
            let mut squared = 0.0;
            for d in 0..D {
                squared += (x[d] - point[d]) * (x[d] - point[d]);
            }
            if squared < best.1 {
                best = (i as u32, squared);
            }
        }
        best
    }

    fn check<const D: usize>(grid: f64) {
        let mut stream = Stream::new(D as u64);
        let mut vector = |grid: f64| -> [f32; D] {
            std::array::from_fn(|_| (libm::round(stream.uniform() * grid) / grid) as f32)
        };
        for count in 0..70 {
            let points: Vec<[f32; D]> = (0..count).map(|_| vector(grid)).collect();
            let mut centres = Centres::new(70);
            points.iter().for_each(|p| centres.push(p));
            assert_eq!(centres.iter().collect::<Vec<_>>(), points);
            for _ in 0..50 {
                let x = vector(grid);
                let (index, squared) = centres.nearest(&x);
                let (want_index, want_squared) = oracle(&points, &x);
                assert_eq!(
                    (index, squared.to_bits()),
                    (want_index, want_squared.to_bits())
                );
                let others: Vec<[f32; D]> = (0..count as usize)
                    .filter(|i| *i != want_index as usize)
                    .map(|i| points[i])
                    .collect();
                let two = (want_index, want_squared, oracle(&others, &x).1);
                assert_eq!(centres.nearest_two(&x), two);
            }
            let bytes = postcard::to_stdvec(&centres).unwrap();
            assert_eq!(postcard::from_bytes::<Centres<D>>(&bytes).unwrap(), centres);
        }
    }

    #[test]
    fn equals_the_scalar_search_to_the_bit() {
        check::<2>(1e6);
        check::<8>(1e6);
        check::<10>(1e6);
    }

    #[test]
    fn takes_the_lowest_index_on_ties() {
        check::<2>(3.0);
        check::<8>(1.0);
    }

    #[test]
    fn far_but_finite_vectors_still_find_a_centre() {
        let centres = Centres::from_points(&[[0.0; 8]]);
        assert_eq!(centres.nearest(&[1e15; 8]).0, 0);
    }

    #[test]
    #[should_panic(expected = "no room")]
    fn refuses_more_than_its_cap() {
        let mut centres = Centres::<2>::new(1);
        centres.push(&[0.0; 2]);
        centres.push(&[1.0; 2]);
    }
}
