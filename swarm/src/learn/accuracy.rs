//! Accuracy of a learnt transition model (section 4.3.4): divergence from a reference model.

use serde::{Deserialize, Serialize};

use super::repository::Repository;

/// How often action j in state i led to state k, without forgetting: the reference model, as
/// estimated by long uniform babbling in the target arena.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TransitionCounts {
    ns: u32,
    na: u32,
    counts: Vec<u32>,
}

impl TransitionCounts {
    /// No transitions between `ns` states by `na` actions.
    pub fn new(ns: u32, na: u32) -> Self {
        Self {
            ns,
            na,
            counts: vec![0; ns as usize * na as usize * ns as usize],
        }
    }

    /// Counts a transition.
    ///
    /// # Panics
    /// When an index is out of range.
    #[inline(always)]
    pub fn record(&mut self, i: u32, j: u32, k: u32) {
        let ns = self.ns as usize;
        let at = (i as usize * self.na as usize + j as usize) * ns;
        self.counts[at..][..ns][k as usize] += 1;
    }

    /// The counts of every k after action `j` in state `i`.
    ///
    /// # Panics
    /// When an index is out of range.
    pub fn of(&self, i: u32, j: u32) -> &[u32] {
        let at = (i as usize * self.na as usize + j as usize) * self.ns as usize;
        &self.counts[at..][..self.ns as usize]
    }
}

/// How far a model is from the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Divergence {
    /// Kullback-Leibler divergence in nats, summed over the pairs (i, j) that the model knows.
    pub sum_nats: f64,
    /// Number of those pairs: the sum grows with it, so models are compared by the mean.
    pub pairs: u32,
}

/// Sum over (i, j, k) of p log(p / p*), with p = n_ijk / n_ij over the pairs with n_ij > 0.
///
/// The reference is p* = (c_ijk + `smoothing`) / (c_ij + `smoothing` ns) with `smoothing` > 0
/// (additive; 1 is Laplace's, 0.5 Jeffreys's): a transition that the reference never saw must not
/// make the divergence infinite, and a pair that it never tried counts as uniform.
///
/// # Panics
/// When the two are of different size.
pub fn divergence(model: &Repository, reference: &TransitionCounts, smoothing: f64) -> Divergence {
    assert_eq!(
        (model.states(), model.actions()),
        (reference.ns, reference.na),
        "table sizes"
    );
    let mut result = Divergence {
        sum_nats: 0.0,
        pairs: 0,
    };
    for i in 0..model.states() {
        for j in 0..model.actions() {
            let n = f64::from(model.count(i, j));
            if n == 0.0 {
                continue;
            }
            result.pairs += 1;
            let counts = reference.of(i, j);
            let total: u64 = counts.iter().map(|c| u64::from(*c)).sum();
            let total = total as f64 + smoothing * f64::from(reference.ns);
            for (seen, expected) in model.transition_counts(i, j).zip(counts) {
                if seen > 0 {
                    let p = f64::from(seen) / n;
                    let p_reference = (f64::from(*expected) + smoothing) / total;
                    result.sum_nats += p * libm::log(p / p_reference);
                }
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::ControllerParameters;

    fn repository() -> Repository {
        Repository::new(3, 2, &ControllerParameters::default())
    }

    #[test]
    fn a_model_equal_to_the_reference_has_none() {
        let (mut model, mut reference) = (repository(), TransitionCounts::new(3, 2));
        for n in 0..60 {
            model.record(1, 0, n % 3);
            (0..100_000).for_each(|_| reference.record(1, 0, n % 3));
        }
        let found = divergence(&model, &reference, 1.0);
        assert!(found.pairs == 1 && found.sum_nats.abs() < 1e-9);
    }

    #[test]
    fn equals_the_sum_by_hand() {
        let (mut model, mut reference) = (repository(), TransitionCounts::new(3, 2));
        [0, 0, 0, 2].iter().for_each(|k| model.record(2, 1, *k));
        model.record(0, 0, 1);
        [0, 1, 1].iter().for_each(|k| reference.record(2, 1, *k));
        let found = divergence(&model, &reference, 1.0);
        let first = 0.75 * (0.75_f64 / (2.0 / 6.0)).ln() + 0.25 * (0.25_f64 / (1.0 / 6.0)).ln();
        // The reference never tried (0, 0): uniform over three states.
        assert_eq!(found.pairs, 2);
        assert!((found.sum_nats - first - 3_f64.ln()).abs() < 1e-14);
    }
}
