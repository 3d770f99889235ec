//! A bounded uniform sample of a stream of vectors of unknown length.
//!
//! Algorithm L (K.-H. Li 1994): most vectors cost one decrement, none is drawn for twice.

use serde::{Deserialize, Serialize};

use super::{are_sound, flat};
use crate::random::Stream;

/// At most `cap` of the vectors offered, each with the same chance of being among them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reservoir<const D: usize> {
    #[serde(with = "flat")]
    sample: Vec<[f32; D]>,
    cap: u32,
    /// Vectors to pass over before the next one is taken; 0 while the sample fills.
    skip: u64,
    /// `W` of Algorithm L: the largest of `cap` uniform keys.
    largest_key: f64,
    stream: Stream,
}

impl<const D: usize> Reservoir<D> {
    /// An empty sample with all of its memory taken; `cap` at least one.
    pub fn new(cap: u32, stream: Stream) -> Self {
        let cap = cap.max(1);
        Self {
            sample: Vec::with_capacity(cap as usize),
            cap,
            skip: 0,
            largest_key: 1.0,
            stream,
        }
    }

    /// Offers the next vector of the stream.
    #[inline(always)]
    pub fn offer(&mut self, x: &[f32; D]) {
        if self.skip > 0 {
            self.skip -= 1;
        } else {
            self.take(x);
        }
    }

    #[cold]
    fn take(&mut self, x: &[f32; D]) {
        if self.sample.len() < self.cap as usize {
            // Takes memory only after a snapshot was restored.
            self.sample
                .reserve_exact(self.cap as usize - self.sample.len());
            self.sample.push(*x);
            if self.sample.len() < self.cap as usize {
                return;
            }
        } else {
            let place = self.stream.below(u64::from(self.cap));
            self.sample[place as usize] = *x;
        }
        let log_key = libm::log(1.0 - self.stream.uniform());
        self.largest_key *= libm::exp(log_key / f64::from(self.cap));
        let log_gap = libm::log(1.0 - self.stream.uniform());
        self.skip = libm::floor(log_gap / libm::log1p(-self.largest_key)) as u64;
    }

    /// Whether saved parts fit together, in a sample of at most `cap`.
    pub fn is_sound(&self, cap: u32) -> bool {
        self.cap == cap
            && self.sample.len() <= cap as usize
            && are_sound(self.sample.as_flattened())
    }

    /// The sample, in no order that means anything.
    pub fn sample(&self) -> &[[f32; D]] {
        &self.sample
    }

    /// Bytes held besides the value itself by a sample of `cap` vectors.
    pub fn heap_bytes_for(cap: u32) -> u64 {
        u64::from(cap.max(1)) * size_of::<[f32; D]>() as u64
    }

    /// Bytes held besides the value itself, exactly counted.
    pub fn heap_bytes(&self) -> u64 {
        Self::heap_bytes_for(self.cap)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn keeps_everything_up_to_its_cap() {
        let mut reservoir = Reservoir::<1>::new(50, Stream::new(1));
        for i in 0..50 {
            assert_eq!(reservoir.sample().len(), i);
            reservoir.offer(&[i as f32]);
        }
        assert_eq!(
            reservoir.sample(),
            (0..50).map(|i| [i as f32]).collect::<Vec<_>>()
        );
    }

    /// Each of 200 vectors is kept with probability 20/200, and pairs are as unrelated as in a draw
    /// without replacement: chi-square over the vectors, and the variance of how many of the first
    /// half are kept (hypergeometric).
    #[test]
    fn is_uniform() {
        let (cap, length, rounds) = (20, 200, 20_000);
        let mut kept = vec![0.0; length];
        let mut from_first_half = Vec::new();
        for round in 0..rounds {
            let mut reservoir = Reservoir::<1>::new(cap, Stream::new(round * 977 + 5));
            (0..length).for_each(|i| reservoir.offer(&[i as f32]));
            assert_eq!(reservoir.sample().len(), cap as usize);
            reservoir
                .sample()
                .iter()
                .for_each(|[i]| kept[*i as usize] += 1.0);
            let first = reservoir
                .sample()
                .iter()
                .filter(|[i]| (*i as usize) < length / 2);
            from_first_half.push(first.count() as f64);
        }
        let expected = f64::from(cap) * rounds as f64 / length as f64;
        let chi: f64 = kept
            .iter()
            .map(|k| (k - expected) * (k - expected) / expected)
            .sum();
        // 199 degrees of freedom, each cell's variance 0.9 of Poisson's: mean 180, deviation 18.
        assert!((110.0..250.0).contains(&chi), "chi-square {chi}");
        let mean = from_first_half.iter().sum::<f64>() / rounds as f64;
        let variance = from_first_half
            .iter()
            .map(|x| (x - mean) * (x - mean))
            .sum::<f64>()
            / rounds as f64;
        let hypergeometric = 20.0 * 0.25 * 180.0 / 199.0;
        assert!((mean - 10.0).abs() < 0.08, "mean {mean}");
        assert!(
            (variance - hypergeometric).abs() < 0.2,
            "variance {variance}"
        );
    }

    #[test]
    fn goes_on_after_a_snapshot_as_if_never_stopped() {
        for before in [3, 500] {
            let mut straight = Reservoir::<3>::new(16, Stream::new(7));
            (0..before).for_each(|i| straight.offer(&[i as f32; 3]));
            let bytes = postcard::to_stdvec(&straight).unwrap();
            let mut restored: Reservoir<3> = postcard::from_bytes(&bytes).unwrap();
            for i in 0..1_000 {
                straight.offer(&[i as f32, 0.0, 1.0]);
                restored.offer(&[i as f32, 0.0, 1.0]);
            }
            assert_eq!(restored, straight);
        }
    }
}
