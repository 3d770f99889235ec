//! What is counted of visits besides entries and steps spent: when each square was first entered,
//! and for a bounded sample of robots which squares each has been in.

use serde::{Deserialize, Serialize};

use crate::bodies::{Bodies, Body};

/// Most robots whose squares are remembered one by one: every n-th, evenly spread over the numbers.
pub const SAMPLED_ROBOTS: usize = 256;

/// Most bits that remember them, 8 MiB: where an arena has many squares, fewer robots are sampled.
const MAX_BITS: usize = 1 << 26;

/// Counts of the steps in which visits counted; empty until the first of them.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Tally {
    /// Counted steps so far.
    steps: u64,
    /// For each square 1 + the counted steps after which it was first entered; 0 for never.
    first_entry: Vec<u64>,
    /// A bit a square for each sampled robot.
    seen: Vec<u64>,
    /// Sampled robots that have been in each square; empty where fewer than two are sampled.
    seen_by: Vec<u32>,
}

/// Robots from one in the sample to the next, and robots in the sample.
fn sample(robots: usize, squares: usize) -> (usize, usize) {
    let most = (MAX_BITS / words(squares).saturating_mul(64).max(1)).clamp(1, SAMPLED_ROBOTS);
    let stride = robots.div_ceil(most).max(1);
    (stride, robots.div_ceil(stride))
}

fn words(squares: usize) -> usize {
    squares.div_ceil(64)
}

impl Tally {
    /// Makes room: called where visits begin to count, and harmless after that.
    pub(super) fn begin(&mut self, robots: usize, squares: usize) {
        if self.first_entry.is_empty() {
            self.first_entry = vec![0; squares];
            let (_, sampled) = sample(robots, squares);
            if sampled > 1 {
                self.seen = vec![0; sampled * words(squares)];
                self.seen_by = vec![0; squares];
            }
        }
    }

    /// Whether saved counts belong to so many robots and squares.
    pub(super) fn fits(&self, robots: usize, squares: usize) -> bool {
        let mut fresh = Self::default();
        fresh.begin(robots, squares);
        let lengths = |t: &Self| [t.first_entry.len(), t.seen.len(), t.seen_by.len()];
        lengths(self) == [0; 3] || lengths(self) == lengths(&fresh)
    }

    /// A step has been made.
    #[inline(always)]
    pub(super) fn step(&mut self) {
        self.steps += 1;
    }

    /// A square is entered, perhaps for the first time.
    pub(super) fn enter(&mut self, square: u32, body: &mut Body) {
        let first = &mut self.first_entry[square as usize];
        if *first == 0 {
            *first = self.steps + 1;
            body.first_entries += 1;
        }
    }

    /// Takes in where the sampled robots are.
    #[inline(always)]
    pub(super) fn see(&mut self, bodies: &Bodies) {
        if self.seen_by.is_empty() {
            return;
        }
        let squares = self.seen_by.len();
        let (stride, _) = sample(bodies.len(), squares);
        let sampled = (0..bodies.len()).step_by(stride);
        for (number, seen) in sampled.zip(self.seen.chunks_exact_mut(words(squares))) {
            let square = bodies[number].square as usize;
            let (word, bit) = (&mut seen[square / 64], 1 << (square % 64));
            if *word & bit == 0 {
                *word |= bit;
                self.seen_by[square] += 1;
            }
        }
    }

    /// Counted steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// For each square 1 + the counted steps after which it was first entered, 0 for never; empty
    /// before visits count.
    pub fn first_entry(&self) -> &[u64] {
        &self.first_entry
    }

    /// Sampled robots that have been in each square; empty where fewer than two are sampled.
    pub fn seen_by(&self) -> &[u32] {
        &self.seen_by
    }

    /// Robots in the sample.
    pub fn sampled(&self) -> usize {
        match self.seen_by.len() {
            0 => 0,
            squares => self.seen.len() / words(squares),
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.first_entry[..])
            + size_of_val(&self.seen[..])
            + size_of_val(&self.seen_by[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::StartPose;

    #[test]
    fn samples_are_bounded_and_spread() {
        assert_eq!(sample(1, 10_000), (1, 1));
        assert_eq!(sample(256, 10_000), (1, 256));
        assert_eq!(sample(257, 10_000), (2, 129));
        assert_eq!(sample(100_000, 10_000), (391, 256));
        let (stride, sampled) = sample(1_000, 1_000_000);
        assert!(sampled * 1_000_000 <= MAX_BITS && sampled > 60, "{sampled}");
        assert!((sampled - 1) * stride < 1_000);
    }

    #[test]
    fn a_robot_counts_once_a_square() {
        let start = StartPose {
            x_m: 0.0,
            y_m: 0.0,
            cos: 1.0,
            sin: 0.0,
        };
        let mut bodies = Bodies::from(vec![Body::at_rest(&start); 3]);
        let mut tally = Tally::default();
        tally.begin(3, 70);
        for squares in [[0, 0, 65], [65, 0, 65], [0, 69, 1]] {
            for (number, square) in squares.into_iter().enumerate() {
                bodies.get_mut(number).square = square;
            }
            tally.see(&bodies);
        }
        let seen: Vec<(usize, u32)> = tally
            .seen_by()
            .iter()
            .copied()
            .enumerate()
            .filter(|&(_, robots)| robots > 0)
            .collect();
        assert_eq!(seen, [(0, 2), (1, 1), (65, 2), (69, 1)]);
        assert_eq!(tally.sampled(), 3);
        assert!(tally.fits(3, 70) && !tally.fits(4, 70) && !tally.fits(3, 71));
    }
}
