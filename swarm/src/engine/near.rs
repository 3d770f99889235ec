//! Each robot's contact candidates, in chunks of robots, so that chunks can be noted side by side.

use std::f64::consts::PI;

use crate::spec::MAX_ROBOTS;

/// Robots of a chunk: the unit in which phases take robots, on one thread or on several.
pub const CHUNK: usize = 128;

/// A robot and a candidate of its, in one word: the robot's place in its chunk above, the other's
/// slot below.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pair(u32);

/// Bits of a slot.
const SLOT_BITS: u32 = 25;
const _: () = assert!(CHUNK << SLOT_BITS == 1 << 32 && MAX_ROBOTS < 1 << SLOT_BITS);

impl Pair {
    /// A robot of a slot and another.
    #[inline(always)]
    pub fn new(slot: usize, other: u32) -> Self {
        Self(((slot % CHUNK) as u32) << SLOT_BITS | other)
    }

    /// The robot's place in its chunk.
    #[inline(always)]
    pub fn place(self) -> usize {
        (self.0 >> SLOT_BITS) as usize
    }

    /// The other's slot.
    #[inline(always)]
    pub fn other(self) -> u32 {
        self.0 & ((1 << SLOT_BITS) - 1)
    }
}

/// Most neighbours kept for contact: 18 discs of radius R fit with their centres within 4 R.
const MOST_NEIGHBOURS: usize = 20;

/// Contact candidates by slot, as scratch.
#[derive(Clone, Debug)]
pub struct Near {
    /// Robots and their candidates, by slot within a chunk, then by cell and number of the candidate.
    /// Every chunk has room for all that its robots may have, and one more.
    pairs: Vec<Pair>,
    /// End of each robot's pairs within its chunk, after a 0 for each chunk.
    ends: Vec<u32>,
    /// Most candidates of a robot.
    most: usize,
}

/// The candidates of one chunk.
pub struct NearChunk<'a> {
    pub(super) pairs: &'a mut [Pair],
    pub(super) ends: &'a mut [u32],
    pub(super) most: usize,
}

impl Near {
    /// Room for robots whose candidates lie within `candidate_m`, at least `apart_m` from each other.
    pub fn new(robots: usize, candidate_m: f64, apart_m: f64) -> Self {
        let most = most_neighbours(candidate_m, apart_m);
        let chunks = robots.div_ceil(CHUNK);
        Self {
            pairs: vec![Pair::default(); robots * most + chunks],
            ends: vec![0; robots + chunks],
            most,
        }
    }

    /// Places of a whole chunk in `pairs`.
    pub fn stride(&self) -> usize {
        CHUNK * self.most + 1
    }

    /// All chunks, to be noted anew.
    #[inline(always)]
    pub fn chunks_mut(&mut self) -> impl Iterator<Item = NearChunk<'_>> {
        let (most, stride) = (self.most, self.stride());
        let ends = self.ends.chunks_mut(CHUNK + 1);
        let chunks = self.pairs.chunks_mut(stride).zip(ends);
        chunks.map(move |(pairs, ends)| NearChunk { pairs, ends, most })
    }

    /// The same for several threads.
    pub fn par_chunks_mut(
        &mut self,
    ) -> impl rayon::iter::IndexedParallelIterator<Item = NearChunk<'_>> {
        use rayon::prelude::*;
        let (most, stride) = (self.most, self.stride());
        let ends = self.ends.par_chunks_mut(CHUNK + 1);
        let chunks = self.pairs.par_chunks_mut(stride).zip(ends);
        chunks.map(move |(pairs, ends)| NearChunk { pairs, ends, most })
    }

    /// A robot and its candidates, pair by pair.
    #[inline(always)]
    pub fn of(&self, slot: usize) -> &[Pair] {
        let chunk = slot / CHUNK;
        let ends = &self.ends[slot + chunk..][..2];
        &self.pairs[chunk * self.stride()..][ends[0] as usize..ends[1] as usize]
    }

    /// All robots of a chunk and their candidates, pair by pair.
    #[inline(always)]
    pub fn of_chunk(&self, chunk: usize) -> &[Pair] {
        let last = ((chunk + 1) * (CHUNK + 1)).min(self.ends.len()) - 1;
        &self.pairs[chunk * self.stride()..][..self.ends[last] as usize]
    }

    /// Bytes set aside, as if all robots were in one chunk.
    pub fn bytes_of_robots(&self) -> usize {
        let more_chunks = self.ends.len().div_ceil(CHUNK + 1).saturating_sub(1);
        let of_chunk = size_of::<Pair>() + size_of::<u32>();
        size_of_val(&self.pairs[..]) + size_of_val(&self.ends[..]) - more_chunks * of_chunk
    }
}

/// Most points, each at least `apart_m` from the others, that lie within `radius_m` of one of them
/// (Oler's inequality for a disc).
fn most_neighbours(radius_m: f64, apart_m: f64) -> usize {
    let ratio = radius_m / apart_m;
    let others = 2.0 / 3.0_f64.sqrt() * PI * ratio * ratio + PI * ratio;
    (others as usize).min(MOST_NEIGHBOURS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_for_every_neighbour() {
        // Six touch one; 18 fit within two diameters, as in a hexagonal grid.
        assert!((6..=10).contains(&most_neighbours(1.0, 1.0)));
        assert!((18..=MOST_NEIGHBOURS).contains(&most_neighbours(2.0, 1.0)));
        assert_eq!(most_neighbours(10.0, 1.0), MOST_NEIGHBOURS);
    }

    #[test]
    fn a_pair_holds_both() {
        for (slot, other) in [(0, 0), (127, MAX_ROBOTS - 1), (128, 1), (99_999, 77)] {
            let pair = Pair::new(slot, other);
            assert_eq!((pair.place(), pair.other()), (slot % CHUNK, other));
        }
    }

    #[test]
    fn chunks_hold_what_was_noted_of_their_robots() {
        for robots in [1, CHUNK - 1, CHUNK, CHUNK + 1, 3 * CHUNK + 5] {
            let mut near = Near::new(robots, 2.0, 1.0);
            let noted = |slot: usize| (0..slot % 4).map(move |other| Pair::new(slot, other as u32));
            for (number, chunk) in near.chunks_mut().enumerate() {
                let mut end = 0;
                for place in 0..chunk.ends.len() - 1 {
                    for pair in noted(number * CHUNK + place) {
                        chunk.pairs[end] = pair;
                        end += 1;
                    }
                    chunk.ends[place + 1] = end as u32;
                }
            }
            let all: Vec<Pair> = (0..robots).flat_map(noted).collect();
            for slot in 0..robots {
                assert!(near.of(slot).iter().copied().eq(noted(slot)));
            }
            let chunks = (0..robots.div_ceil(CHUNK)).flat_map(|chunk| near.of_chunk(chunk));
            assert!(chunks.eq(&all), "{robots}");
        }
    }
}
