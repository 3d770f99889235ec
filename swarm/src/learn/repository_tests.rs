//! The repository against lists and logarithms recomputed from scratch after every record.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

/// S(i, j) as it stands in the thesis.
struct Naive {
    lists: Vec<Vec<VecDeque<u32>>>,
    lambda: usize,
    alpha: f64,
}

impl Naive {
    fn new(ns: u32, na: u32, parameters: &ControllerParameters) -> Self {
        Self {
            lists: vec![vec![VecDeque::new(); na as usize]; ns as usize],
            lambda: parameters.lambda as usize,
            alpha: parameters.alpha,
        }
    }

    fn record(&mut self, i: u32, j: u32, k: u32) {
        let list = &mut self.lists[i as usize][j as usize];
        if list.len() == self.lambda {
            list.pop_front();
        }
        list.push_back(k);
    }

    fn entropy(list: &VecDeque<u32>) -> f64 {
        let fraction = |k: u32| list.iter().filter(|l| **l == k).count() as f64 / list.len() as f64;
        let highest = list.iter().max().map_or(0, |k| k + 1);
        (0..highest)
            .map(fraction)
            .filter(|p| *p > 0.0)
            .map(|p| -p * p.ln())
            .sum()
    }

    fn score(&self, i: usize, j: usize) -> f64 {
        let list = &self.lists[i][j];
        if list.is_empty() {
            return f64::NEG_INFINITY;
        }
        let stayed = list.iter().filter(|k| **k == i as u32).count() as f64 / list.len() as f64;
        (1.0 - self.alpha) * Self::entropy(list) + self.alpha * (1.0 - stayed)
    }

    fn check(&self, repository: &Repository, parameters: &ControllerParameters) {
        assert!(repository.is_sound());
        let na = repository.actions();
        for (i, row) in self.lists.iter().enumerate() {
            let state = i as u32;
            for (j, list) in row.iter().enumerate() {
                let action = j as u32;
                assert!(repository.list(state, action).eq(list.iter().copied()));
                assert_eq!(repository.count(state, action) as usize, list.len());
                for (k, n) in (0..).zip(repository.transition_counts(state, action)) {
                    let in_list = list.iter().filter(|l| **l == k);
                    assert_eq!(n as usize, in_list.count());
                }
                let mut entries: Vec<u32> = (0..list.len() as u32)
                    .map(|place| repository.entry(state, action, place))
                    .collect();
                entries.sort_unstable();
                let mut in_list: Vec<u32> = list.iter().copied().collect();
                in_list.sort_unstable();
                assert_eq!(entries, in_list);
                assert!((repository.entropy(state, action) - Self::entropy(list)).abs() < 1e-8);
                let (got, want) = (f64::from(repository.score(state, action)), self.score(i, j));
                assert!(
                    got == want || (got - want).abs() < 1e-6,
                    "score {got}, {want}"
                );
            }
            let scores: Vec<f32> = (0..na).map(|j| repository.score(state, j)).collect();
            let highest = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            let first = scores.iter().position(|s| *s == highest).unwrap();
            assert_eq!(repository.best_action(state) as usize, first);
            self.check_insufficiency(repository, parameters, i);
        }
    }

    fn check_insufficiency(&self, repository: &Repository, p: &ControllerParameters, i: usize) {
        let (state, na) = (i as u32, repository.actions());
        let total: usize = self.lists[i].iter().map(VecDeque::len).sum();
        let mut open: Vec<u32> = (0..na)
            .filter(|j| self.lists[i][*j as usize].len() < self.lambda)
            .collect();
        let insufficient = match p.insufficiency {
            Insufficiency::EveryAction => !open.is_empty(),
            Insufficiency::StateTotal => total < p.lambda_total as usize,
        };
        if open.is_empty() || p.insufficiency == Insufficiency::StateTotal {
            open = (0..na).collect();
        }
        assert_eq!(repository.is_insufficient(state), insufficient);
        assert_eq!(repository.state_count(state) as usize, total);
        // Bits in the middle of each of the equal shares of [0, 2^32).
        let share = (1_u64 << 32) / open.len() as u64;
        let drawn = (0..open.len() as u64)
            .map(|n| repository.deficient_action(state, (n * share + share / 2) as u32));
        assert_eq!(drawn.collect::<Vec<_>>(), open);
    }
}

fn parameters(lambda: u32, alpha: f64, insufficiency: Insufficiency) -> ControllerParameters {
    ControllerParameters {
        lambda,
        alpha,
        insufficiency,
        lambda_total: 2 * lambda,
        ..ControllerParameters::default()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]
    #[test]
    fn equals_the_lists(
        ns in 1_u32..5,
        na in 1_u32..5,
        lambda in 1_u32..9,
        alpha in prop_oneof![Just(0.0), Just(0.7), Just(1.0)],
        every_action in any::<bool>(),
        records in prop::collection::vec(any::<(u16, u16, u16)>(), 0..300),
    ) {
        let rule = if every_action { Insufficiency::EveryAction } else { Insufficiency::StateTotal };
        let parameters = parameters(lambda, alpha, rule);
        let mut repository = Repository::new(ns, na, &parameters);
        let mut naive = Naive::new(ns, na, &parameters);
        naive.check(&repository, &parameters);
        for (i, j, k) in records {
            let (i, j, k) = (u32::from(i) % ns, u32::from(j) % na, u32::from(k) % ns);
            repository.record(i, j, k);
            naive.record(i, j, k);
            naive.check(&repository, &parameters);
        }
        let bytes = postcard::to_stdvec(&repository).unwrap();
        prop_assert_eq!(postcard::from_bytes::<Repository>(&bytes).unwrap(), repository);
    }
}

#[test]
fn equal_counts_are_ties_whatever_came_before() {
    let parameters = parameters(60, 0.7, Insufficiency::EveryAction);
    let mut repository = Repository::new(28, 3, &parameters);
    for n in 0..10_000_u32 {
        repository.record(5, 2, n * n % 28);
    }
    for n in 0..60 {
        repository.record(5, 2, 6 + n % 7);
        repository.record(5, 1, 14 + (n * 3) % 7);
    }
    assert_eq!(
        repository.score(5, 1).to_bits(),
        repository.score(5, 2).to_bits()
    );
    assert_eq!(repository.best_action(5), 1);
}

#[test]
fn bytes_are_counted() {
    let repository = Repository::new(28, 15, &ControllerParameters::default());
    let Entries::Bytes(entries) = &repository.entries else {
        panic!("28 states fit in a byte");
    };
    let held = size_of_val(&repository.states[..])
        + size_of_val(&repository.pairs[..])
        + size_of_val(&entries[..])
        + size_of_val(&repository.scores[..])
        + size_of_val(&repository.deficient[..]);
    assert_eq!(repository.heap_bytes(), held as u64);
    assert!(held < 100_000, "{held} bytes");
}
