//! Incremental epsilon-clustering (Alg. 4) and the visit counts that the objectives are made from.

use serde::{Deserialize, Serialize};

use super::centres::Centres;

/// Clusters of radius epsilon, with the visits of this trajectory and of all earlier ones.
///
/// A centre never moves, so an index means the same for the whole of phase 1. At the cap a vector
/// that would found a cluster joins the nearest one and is counted in [`Self::saturated`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpsilonClustering<const D: usize> {
    centres: Centres<D>,
    epsilon_squared: f32,
    trajectory: Vec<u32>,
    archive: Vec<u64>,
    saturated: u64,
}

impl<const D: usize> EpsilonClustering<D> {
    /// No clusters yet; at most `cap`, at least one.
    pub fn new(epsilon: f64, cap: u32) -> Self {
        let cap = cap.max(1);
        Self {
            centres: Centres::new(cap),
            epsilon_squared: (epsilon * epsilon) as f32,
            trajectory: vec![0; cap as usize],
            archive: vec![0; cap as usize],
            saturated: 0,
        }
    }

    /// Counts a vector of the current trajectory and returns the index of its cluster.
    ///
    /// It joins the nearest centre when within epsilon (Euclidean, epsilon included).
    #[inline(always)]
    pub fn observe(&mut self, x: &[f32; D]) -> u32 {
        let (mut cluster, squared) = self.centres.nearest(x);
        if squared > self.epsilon_squared {
            if self.centres.is_full() {
                self.saturated += 1;
            } else {
                cluster = self.centres.len();
                self.centres.push(x);
            }
        }
        self.trajectory[cluster as usize] += 1;
        cluster
    }

    /// Adds the trajectory to the archive; the next vector begins a new trajectory.
    pub fn end_trajectory(&mut self) {
        for (archived, visits) in self.archive.iter_mut().zip(&mut self.trajectory) {
            *archived += u64::from(std::mem::take(visits));
        }
    }

    /// Whether saved parts fit together, and have room for so many clusters.
    pub fn is_sound(&self, cap: u32) -> bool {
        let room = self.centres.cap() as usize;
        room == cap as usize
            && [self.trajectory.len(), self.archive.len()] == [room; 2]
            && self.epsilon_squared.is_finite()
    }

    /// The clusters' centres.
    pub fn centres(&self) -> &Centres<D> {
        &self.centres
    }

    /// Number of clusters.
    pub fn len(&self) -> u32 {
        self.centres.len()
    }

    /// Whether no vector was seen.
    pub fn is_empty(&self) -> bool {
        self.centres.is_empty()
    }

    /// Visits of each cluster in this trajectory: `p_i T`.
    pub fn trajectory_counts(&self) -> &[u32] {
        &self.trajectory[..self.len() as usize]
    }

    /// Visits of each cluster in all earlier trajectories: `m_i`.
    pub fn archive_counts(&self) -> &[u64] {
        &self.archive[..self.len() as usize]
    }

    /// Vectors beyond epsilon that found no room for a cluster of their own.
    pub fn saturated(&self) -> u64 {
        self.saturated
    }

    /// Bytes held besides the value itself by at most `cap` clusters.
    pub fn heap_bytes_for(cap: u32) -> u64 {
        let counts = size_of::<u32>() + size_of::<u64>();
        Centres::<D>::heap_bytes_for(cap.max(1)) + u64::from(cap.max(1)) * counts as u64
    }

    /// Bytes held besides the value itself, exactly counted.
    pub fn heap_bytes(&self) -> u64 {
        Self::heap_bytes_for(self.trajectory.len() as u32)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::random::Stream;

    #[test]
    fn equals_the_plain_algorithm() {
        let (epsilon, cap) = (0.7_f32, 20);
        let mut clustering = EpsilonClustering::<3>::new(f64::from(epsilon), cap);
        let mut stream = Stream::new(4);
        let mut centres: Vec<[f32; 3]> = Vec::new();
        let (mut archive, mut saturated) = (vec![0; cap as usize], 0);
        for _ in 0..5 {
            let mut visits = vec![0; cap as usize];
            for _ in 0..400 {
                let x = std::array::from_fn(|_| 2.0 * stream.uniform() as f32 - 1.0);
                let squared = |c: &[f32; 3]| (0..3).map(|d| (x[d] - c[d]) * (x[d] - c[d])).sum();
                let mut nearest = (usize::MAX, f32::INFINITY);
                for (i, centre) in centres.iter().enumerate() {
                    let d2: f32 = squared(centre);
                    if d2 < nearest.1 {
                        nearest = (i, d2);
                    }
                }
                if nearest.1 > epsilon * epsilon {
                    if centres.len() < cap as usize {
                        centres.push(x);
                        nearest.0 = centres.len() - 1;
                    } else {
                        saturated += 1;
                    }
                }
                visits[nearest.0] += 1;
                assert_eq!(clustering.observe(&x) as usize, nearest.0);
            }
            assert_eq!(clustering.trajectory_counts(), &visits[..centres.len()]);
            assert_eq!(clustering.archive_counts(), &archive[..centres.len()]);
            clustering.end_trajectory();
            archive
                .iter_mut()
                .zip(&visits)
                .for_each(|(a, v)| *a += u64::from(*v));
            assert!(clustering.trajectory_counts().iter().all(|v| *v == 0));
        }
        assert!(saturated > 0, "the cap was never reached");
        assert_eq!(clustering.saturated(), saturated);
        let bytes = postcard::to_stdvec(&clustering).unwrap();
        assert_eq!(
            postcard::from_bytes::<EpsilonClustering<3>>(&bytes).unwrap(),
            clustering
        );
    }

    #[test]
    fn a_vector_at_exactly_epsilon_joins() {
        let mut clustering = EpsilonClustering::<2>::new(0.5, 8);
        assert_eq!(clustering.observe(&[0.0, 0.0]), 0);
        assert_eq!(clustering.observe(&[0.5, 0.0]), 0);
        assert_eq!(clustering.observe(&[0.5001, 0.0]), 1);
    }
}
