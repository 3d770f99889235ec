//! The (1+1)-ES of phase 1 with the one-fifth rule and restarts (chapter 2, section 5.2.5).

use serde::{Deserialize, Serialize};

use super::perceptron::WEIGHTS;
use super::{FARTHEST, are_sound};
use crate::random::Stream;
use crate::spec::ControllerParameters;

/// Largest mutation step, so that weights stay numbers whatever the factor of the one-fifth rule.
const MOST_SIGMA: f64 = 1e6;

/// A parent and its mutated child: ask for the [`Self::candidate`], evaluate it, [`Self::tell`].
///
/// Decided where the thesis is silent:
/// - a fresh parent is evaluated itself before it is mutated, and never again;
/// - a success is a child strictly better than its parent, and only then replaces it: with equal
///   fitness, as among robots that stand still, there is no sign of progress to keep;
/// - the one-fifth rule is applied once every `success_window` children, then the count begins
///   anew; exactly a fifth leaves sigma as it is;
/// - after `restart_after` children in a row without success the next candidate is a fresh parent,
///   with the initial sigma and an empty window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evolution {
    stream: Stream,
    initial_deviation: f64,
    initial_sigma: f64,
    sigma_factor: f64,
    success_window: u32,
    restart_after: u32,
    /// Fitness of the parent; `None` while the candidate is a fresh parent.
    parent_fitness: Option<f64>,
    /// Its genome, where there is one.
    parent: Vec<f32>,
    candidate: Vec<f32>,
    sigma: f64,
    window_children: u32,
    window_successes: u32,
    without_success: u32,
}

impl Evolution {
    /// A fresh parent, to be evaluated first.
    pub fn new(parameters: &ControllerParameters, stream: Stream) -> Self {
        let mut evolution = Self {
            stream,
            initial_deviation: libm::sqrt(parameters.initial_weight_variance),
            initial_sigma: parameters.sigma,
            sigma_factor: parameters.sigma_factor,
            success_window: parameters.success_window,
            restart_after: parameters.restart_after,
            parent_fitness: None,
            parent: vec![0.0; WEIGHTS],
            candidate: vec![0.0; WEIGHTS],
            sigma: parameters.sigma,
            window_children: 0,
            window_successes: 0,
            without_success: 0,
        };
        evolution.begin();
        evolution
    }

    /// Whether saved parts fit together.
    pub fn is_sound(&self) -> bool {
        let spreads = [self.initial_deviation, self.initial_sigma, self.sigma];
        let genomes = [&self.parent, &self.candidate];
        genomes
            .iter()
            .all(|genome| genome.len() == WEIGHTS && are_sound(*genome))
            && spreads
                .iter()
                .all(|spread| (0.0..=MOST_SIGMA).contains(spread))
            && (1.0..=MOST_SIGMA).contains(&self.sigma_factor)
            && self.parent_fitness.is_none_or(f64::is_finite)
    }

    /// The genome to evaluate next: [`WEIGHTS`] weights.
    pub fn candidate(&self) -> &[f32] {
        &self.candidate
    }

    /// The parent's genome and fitness, once it was evaluated.
    pub fn parent(&self) -> Option<(&[f32], f64)> {
        self.parent_fitness
            .map(|fitness| (&self.parent[..], fitness))
    }

    /// Takes another robot's genome as parent where it is fitter than this one's own, and makes the
    /// next candidate from it: between two evaluations, after [`Self::tell`]. A restart is let be.
    pub fn adopt(&mut self, genome: &[f32], fitness: f64) {
        if self.parent_fitness.is_some_and(|own| fitness > own) {
            self.parent_fitness = Some(fitness);
            self.parent.copy_from_slice(genome);
            self.without_success = 0;
            self.mutate();
        }
    }

    /// The current mutation step.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// Takes the fitness (finite, larger is better) of the candidate and makes the next one.
    pub fn tell(&mut self, fitness: f64) {
        debug_assert!(fitness.is_finite(), "fitness {fitness}");
        let success = self.parent_fitness.is_none_or(|parent| fitness > parent);
        if self.parent_fitness.is_some() {
            self.adapt(success);
        }
        if success {
            self.parent_fitness = Some(fitness);
            self.parent.copy_from_slice(&self.candidate);
        }
        if self.without_success >= self.restart_after {
            self.begin();
        } else {
            self.mutate();
        }
    }

    fn adapt(&mut self, success: bool) {
        self.without_success = if success { 0 } else { self.without_success + 1 };
        self.window_children += 1;
        self.window_successes += u32::from(success);
        if self.window_children < self.success_window {
            return;
        }
        match (5 * u64::from(self.window_successes)).cmp(&u64::from(self.window_children)) {
            std::cmp::Ordering::Greater => {
                self.sigma = (self.sigma * self.sigma_factor).min(MOST_SIGMA);
            }
            std::cmp::Ordering::Less => self.sigma /= self.sigma_factor,
            std::cmp::Ordering::Equal => {}
        }
        self.window_children = 0;
        self.window_successes = 0;
    }

    fn begin(&mut self) {
        self.parent_fitness = None;
        self.sigma = self.initial_sigma;
        self.window_children = 0;
        self.window_successes = 0;
        self.without_success = 0;
        for weight in &mut self.candidate {
            *weight = (self.initial_deviation * self.stream.normal()) as f32;
        }
    }

    fn mutate(&mut self) {
        for (weight, of_parent) in self.candidate.iter_mut().zip(&self.parent) {
            let mutated = (f64::from(*of_parent) + self.sigma * self.stream.normal()) as f32;
            *weight = mutated.clamp(-FARTHEST, FARTHEST);
        }
    }

    /// Bytes held besides the value itself.
    pub const HEAP_BYTES: u64 = 2 * (WEIGHTS * size_of::<f32>()) as u64;
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn evolution(change: impl FnOnce(&mut ControllerParameters)) -> Evolution {
        let mut parameters = ControllerParameters::default();
        change(&mut parameters);
        Evolution::new(&parameters, Stream::new(11))
    }

    fn spread(values: impl Iterator<Item = f64>) -> f64 {
        let squares: Vec<f64> = values.map(|v| v * v).collect();
        libm::sqrt(squares.iter().sum::<f64>() / squares.len() as f64)
    }

    #[test]
    fn fresh_parents_and_children_have_their_spread() {
        let mut evolution = evolution(|_| {});
        let parent = evolution.candidate().to_vec();
        assert_eq!(parent.len(), WEIGHTS);
        assert!((spread(parent.iter().map(|w| f64::from(*w))) - libm::sqrt(0.1)).abs() < 0.08);
        evolution.tell(1.0);
        let child = evolution
            .candidate()
            .iter()
            .zip(&parent)
            .map(|(c, p)| f64::from(c - p));
        assert!((spread(child) - 0.2).abs() < 0.05);
    }

    #[test]
    fn the_one_fifth_rule() {
        for (successes, sigma) in [(0, 0.2 / 1.22), (1, 0.2 / 1.22), (2, 0.2), (3, 0.2 * 1.22)] {
            let mut evolution = evolution(|p| p.success_window = 10);
            let mut fitness = 0.0;
            evolution.tell(fitness);
            for child in 0..10 {
                assert_eq!(evolution.sigma(), 0.2);
                if child < successes {
                    fitness += 1.0;
                }
                evolution.tell(fitness);
            }
            assert_eq!(evolution.sigma(), sigma, "{successes} successes");
        }
    }

    #[test]
    fn equal_fitness_is_no_success_and_restarts_after_thirty() {
        let mut evolution = evolution(|_| {});
        let first = evolution.candidate().to_vec();
        evolution.tell(5.0);
        for _ in 0..29 {
            evolution.tell(5.0);
            assert_eq!(evolution.parent().unwrap(), (&first[..], 5.0));
        }
        evolution.tell(5.0);
        assert!(evolution.parent().is_none());
        assert_eq!((evolution.sigma(), evolution.window_children), (0.2, 0));
        let fresh = evolution.candidate().to_vec();
        evolution.tell(1.0);
        assert_eq!(evolution.parent().unwrap(), (&fresh[..], 1.0));
    }

    #[test]
    fn adopts_only_what_is_fitter_than_its_parent() {
        let mut evolution = evolution(|_| {});
        let stranger = [0.25; WEIGHTS];
        evolution.adopt(&stranger, 9.0);
        assert!(evolution.parent().is_none(), "a fresh parent comes first");
        evolution.tell(5.0);
        let own = evolution.parent().unwrap().0.to_vec();
        evolution.adopt(&stranger, 5.0);
        assert_eq!(evolution.parent().unwrap(), (&own[..], 5.0));
        evolution.adopt(&stranger, 5.5);
        assert_eq!(evolution.parent().unwrap(), (&stranger[..], 5.5));
        let child = evolution.candidate().iter().map(|w| f64::from(*w) - 0.25);
        assert!((spread(child) - 0.2).abs() < 0.05);
    }

    #[test]
    fn climbs_a_sphere() {
        let mut evolution = evolution(|p| p.restart_after = 1_000);
        let sphere = |genome: &[f32]| -genome.iter().map(|w| f64::from(w * w)).sum::<f64>();
        let start = sphere(evolution.candidate());
        for _ in 0..4_000 {
            let fitness = sphere(evolution.candidate());
            evolution.tell(fitness);
        }
        assert!(evolution.parent().unwrap().1 > start / 100.0);
    }

    #[test]
    fn goes_on_after_a_snapshot_as_if_never_stopped() {
        let mut straight = evolution(|_| {});
        for i in 0..25 {
            straight.tell(f64::from(i % 7));
        }
        let bytes = postcard::to_stdvec(&straight).unwrap();
        let mut restored: Evolution = postcard::from_bytes(&bytes).unwrap();
        for i in 0..50 {
            assert_eq!(restored, straight);
            straight.tell(f64::from(i % 5));
            restored.tell(f64::from(i % 5));
        }
    }
}
