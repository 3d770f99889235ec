//! The repository (section 4.3.2): what followed the last lambda tries of each action in each state.
//!
//! Entropies, scores and best actions are kept up to date, a constant number of operations a record.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::prefetch::prefetch;
use crate::random::below;
use crate::spec::{ControllerParameters, Insufficiency};

/// Longest list that the table of logarithms serves; the largest allowed `lambda`.
const MAX_LAMBDA: usize = 1_000;

/// Fixed-point unit of entropy sums. Whole numbers neither drift nor depend on the order in which
/// transitions came and went: equal counts give equal scores, and ties stay ties.
const UNIT: f64 = 4_294_967_296.0;

/// `m log m` in units of 2^-32.
static M_LOG_M: LazyLock<[i64; MAX_LAMBDA + 1]> = LazyLock::new(|| {
    std::array::from_fn(|m| {
        let m = m.max(1) as f64;
        libm::round(m * libm::log(m) * UNIT) as i64
    })
});

/// The transition table S(i, j) with entropies Q(i, j) and scores (eq. 4.9).
///
/// `i` and `k` are states below `ns`, `j` actions below `na`; larger ones panic. The score of an
/// action never tried is minus infinity: without data it is never the best.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repository {
    ns: u32,
    na: u32,
    lambda: u16,
    alpha: f64,
    insufficiency: Insufficiency,
    lambda_total: u32,
    states: Vec<State>,
    /// Of each (i, j).
    pairs: Vec<Pair>,
    /// Of each (i, j): `lambda` next states, a ring, then n_ijk for every k. Side by side, as both
    /// are written together and a table of many robots is seldom in a cache.
    entries: Entries,
    /// Of each (i, j).
    scores: Vec<f32>,
    /// Of each i: the actions with a list that is not full, in order, in its first places.
    deficient: Vec<u16>,
}

/// Whole numbers below the larger of `ns` and `lambda + 1`, as narrow as they can be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Entries {
    /// Where both fit in a byte, as they nearly always do.
    Bytes(Vec<u8>),
    Words(Vec<u16>),
}

/// An entry of a list, or a count.
trait Entry: Copy {
    fn get(self) -> u16;
    /// `value` is known to fit.
    fn of(value: u16) -> Self;
}

impl Entry for u8 {
    #[inline(always)]
    fn get(self) -> u16 {
        u16::from(self)
    }
    #[inline(always)]
    fn of(value: u16) -> Self {
        value as u8
    }
}

impl Entry for u16 {
    #[inline(always)]
    fn get(self) -> u16 {
        self
    }
    #[inline(always)]
    fn of(value: u16) -> Self {
        value
    }
}

impl Entries {
    /// Bytes that an entry of a table of this size takes.
    fn width(ns: u32, lambda: u32) -> usize {
        if ns <= 256 && lambda <= 255 { 1 } else { 2 }
    }

    fn new(ns: u32, lambda: u32, len: usize) -> Self {
        match Self::width(ns, lambda) {
            1 => Self::Bytes(vec![0; len]),
            _ => Self::Words(vec![0; len]),
        }
    }

    #[inline(always)]
    fn get(&self, at: usize) -> u32 {
        match self {
            Self::Bytes(entries) => u32::from(entries[at]),
            Self::Words(entries) => u32::from(entries[at]),
        }
    }

    #[inline(always)]
    fn expect(&self, from: usize, len: usize) {
        match self {
            Self::Bytes(entries) => prefetch(&entries[from..][..len]),
            Self::Words(entries) => prefetch(&entries[from..][..len]),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    /// Sum over j of n_ij.
    recorded: u32,
    /// Actions with a list that is not full.
    deficient: u16,
    best_action: u16,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Pair {
    /// Sum over k of n_ijk log n_ijk, fixed point.
    m_log_m: i64,
    /// n_ij.
    recorded: u16,
    /// Place of the list that is written next: the oldest entry's once the list is full.
    next: u16,
}

impl Repository {
    /// An empty table of `ns` states and `na` actions.
    ///
    /// # Panics
    /// When `ns` or `na` is 0 or above 65,535, or `lambda` is not 1 to 1,000.
    pub fn new(ns: u32, na: u32, parameters: &ControllerParameters) -> Self {
        let lambda = parameters.lambda as usize;
        assert!(
            (1..=0xFFFF).contains(&ns) && (1..=0xFFFF).contains(&na),
            "{ns} by {na} table"
        );
        assert!(
            (1..=MAX_LAMBDA).contains(&lambda),
            "lists of length {lambda}"
        );
        let pairs = ns as usize * na as usize;
        let mut every_action = Vec::with_capacity(pairs);
        (0..ns).for_each(|_| every_action.extend(0..na as u16));
        Self {
            ns,
            na,
            lambda: lambda as u16,
            alpha: parameters.alpha,
            insufficiency: parameters.insufficiency,
            lambda_total: parameters.lambda_total,
            states: vec![
                State {
                    recorded: 0,
                    deficient: na as u16,
                    best_action: 0
                };
                ns as usize
            ],
            pairs: vec![Pair::default(); pairs],
            entries: Entries::new(ns, parameters.lambda, pairs * (lambda + ns as usize)),
            scores: vec![f32::NEG_INFINITY; pairs],
            deficient: every_action,
        }
    }

    /// Takes the parameters of decisions from another set; what was recorded stays.
    pub fn retune(&mut self, parameters: &ControllerParameters) {
        self.alpha = parameters.alpha;
        self.insufficiency = parameters.insufficiency;
        self.lambda_total = parameters.lambda_total;
        let (lambda, ns, na) = (usize::from(self.lambda), self.ns as usize, self.na as usize);
        for (at, pair) in self.pairs.iter().enumerate() {
            if pair.recorded > 0 {
                let stayed = self.entries.get(at * (lambda + ns) + lambda + at / na);
                // A count of at most `lambda` entries.
                self.scores[at] = score(self.alpha, *pair, stayed as u16);
            }
        }
        for (state, row) in self.states.iter_mut().zip(self.scores.chunks_exact(na)) {
            state.best_action = first_maximum(row) as u16;
        }
    }

    /// Bytes that a table of this size takes besides the value itself.
    pub fn heap_bytes_for(ns: u32, na: u32, lambda: u32) -> u64 {
        let (ns, na) = (u64::from(ns), u64::from(na));
        let pair = size_of::<Pair>() + size_of::<f32>() + size_of::<u16>();
        let lists = (u64::from(lambda) + ns) * Entries::width(ns as u32, lambda) as u64;
        ns * size_of::<State>() as u64 + ns * na * (pair as u64 + lists)
    }

    /// Bytes held besides the value itself, exactly counted.
    pub fn heap_bytes(&self) -> u64 {
        Self::heap_bytes_for(self.ns, self.na, u32::from(self.lambda))
    }

    /// Number of states.
    #[inline(always)]
    pub fn states(&self) -> u32 {
        self.ns
    }

    /// Number of actions.
    #[inline(always)]
    pub fn actions(&self) -> u32 {
        self.na
    }

    /// Asks for the memory that choosing an action in a state needs.
    #[inline(always)]
    pub fn expect_choice(&self, i: u32) {
        let na = self.na as usize;
        prefetch(&self.states[i as usize]);
        prefetch(&self.deficient[i as usize * na..][..na]);
    }

    /// Asks for the memory that recording a transition needs.
    #[inline(always)]
    pub fn expect_record(&self, i: u32, j: u32) {
        let at = self.at(i, j);
        let (lambda, ns, na) = (usize::from(self.lambda), self.ns as usize, self.na as usize);
        prefetch(&self.pairs[at]);
        self.entries.expect(at * (lambda + ns), lambda + ns);
        prefetch(&self.scores[i as usize * na..][..na]);
    }

    /// Takes in that action `j` in state `i` led to state `k`; the oldest entry of a full list goes.
    #[inline(always)]
    pub fn record(&mut self, i: u32, j: u32, k: u32) {
        let at = self.at(i, j);
        let (lambda, ns) = (usize::from(self.lambda), self.ns as usize);
        let pair = &mut self.pairs[at];
        let (from, len) = (at * (lambda + ns), lambda + ns);
        let (i_, k_) = (i as u16, k as u16);
        let pushed = match &mut self.entries {
            Entries::Bytes(entries) => push(pair, &mut entries[from..][..len], lambda, i_, k_),
            Entries::Words(entries) => push(pair, &mut entries[from..][..len], lambda, i_, k_),
        };
        let Some(Pushed { grown, stayed }) = pushed else {
            return;
        };
        let score = score(self.alpha, *pair, stayed);
        let full = pair.recorded == self.lambda;
        if grown {
            self.states[i as usize].recorded += 1;
            if full {
                self.no_longer_deficient(i, j);
            }
        }
        self.set_score(i, j, score);
    }

    /// The action with the highest score (eq. 4.9), the lowest index on ties.
    #[inline(always)]
    pub fn best_action(&self, i: u32) -> u32 {
        u32::from(self.states[i as usize].best_action)
    }

    /// Whether too little is known of a state to exploit it, by the rule of the parameters.
    #[inline(always)]
    pub fn is_insufficient(&self, i: u32) -> bool {
        let state = &self.states[i as usize];
        match self.insufficiency {
            Insufficiency::EveryAction => state.deficient > 0,
            Insufficiency::StateTotal => state.recorded < self.lambda_total,
        }
    }

    /// A random action for a state that is insufficient, from 32 uniform bits.
    ///
    /// `every-action`: uniform over the actions tried fewer than lambda times (over all actions
    /// when there are none). `state-total`: uniform over all actions.
    #[inline(always)]
    pub fn deficient_action(&self, i: u32, bits: u32) -> u32 {
        let deficient = u32::from(self.states[i as usize].deficient);
        match self.insufficiency {
            Insufficiency::EveryAction if deficient > 0 => {
                u32::from(self.deficient[self.at(i, below(bits, deficient))])
            }
            _ => below(bits, self.na),
        }
    }

    /// n_ij: entries of the list S(i, j).
    #[inline(always)]
    pub fn count(&self, i: u32, j: u32) -> u32 {
        u32::from(self.pairs[self.at(i, j)].recorded)
    }

    /// Sum over j of n_ij.
    #[inline(always)]
    pub fn state_count(&self, i: u32) -> u32 {
        self.states[i as usize].recorded
    }

    /// n_ijk for every k.
    pub fn transition_counts(&self, i: u32, j: u32) -> impl Iterator<Item = u32> {
        let (lambda, ns) = (usize::from(self.lambda), self.ns as usize);
        let first = self.at(i, j) * (lambda + ns) + lambda;
        (first..first + ns).map(|at| self.entries.get(at))
    }

    /// The list S(i, j), oldest entry first.
    pub fn list(&self, i: u32, j: u32) -> impl Iterator<Item = u32> {
        let at = self.at(i, j);
        let (pair, lambda) = (self.pairs[at], usize::from(self.lambda));
        let ring = at * (lambda + self.ns as usize);
        let recorded = usize::from(pair.recorded);
        // A list that is not full begins at its place 0, where `next` has not yet come by again.
        let first = if recorded == lambda {
            usize::from(pair.next)
        } else {
            0
        };
        (0..recorded).map(move |n| self.entries.get(ring + (first + n) % lambda))
    }

    /// The entry of S(i, j) at a place below [`Self::count`], in no order that means anything.
    #[inline(always)]
    pub fn entry(&self, i: u32, j: u32, place: u32) -> u32 {
        let (lambda, ns) = (usize::from(self.lambda), self.ns as usize);
        assert!((place as usize) < lambda, "no place {place}");
        self.entries
            .get(self.at(i, j) * (lambda + ns) + place as usize)
    }

    /// Score of action `j` in state `i` (eq. 4.9); minus infinity when it was never tried.
    #[inline(always)]
    pub fn score(&self, i: u32, j: u32) -> f32 {
        self.scores[self.at(i, j)]
    }

    /// Q(i, j): entropy of the list S(i, j) in nats; 0 when it is empty.
    pub fn entropy(&self, i: u32, j: u32) -> f64 {
        let pair = &self.pairs[self.at(i, j)];
        entropy_sum(pair) / f64::from(pair.recorded.max(1))
    }

    #[inline(always)]
    fn at(&self, i: u32, j: u32) -> usize {
        assert!(j < self.na, "no action {j}");
        i as usize * self.na as usize + j as usize
    }

    /// Puts a score in its place and keeps the state's best action.
    #[inline(always)]
    fn set_score(&mut self, i: u32, j: u32, score: f32) {
        let na = self.na as usize;
        let row = &mut self.scores[i as usize * na..][..na];
        let best = &mut self.states[i as usize].best_action;
        let (j, old_best) = (j as usize, usize::from(*best));
        let before = std::mem::replace(&mut row[j], score);
        if j != old_best {
            let highest = row[old_best];
            if score > highest || (score == highest && j < old_best) {
                *best = j as u16;
            }
        } else if score < before {
            *best = first_maximum(row) as u16;
        }
    }

    /// Takes an action out of its state's deficient ones; happens once for each action.
    #[cold]
    fn no_longer_deficient(&mut self, i: u32, j: u32) {
        let na = self.na as usize;
        let deficient = &mut self.states[i as usize].deficient;
        let actions = &mut self.deficient[i as usize * na..][..usize::from(*deficient)];
        if let Ok(place) = actions.binary_search(&(j as u16)) {
            actions.copy_within(place + 1.., place);
            *deficient -= 1;
        }
    }
}

/// What writing to a list did.
struct Pushed {
    /// The list got longer.
    grown: bool,
    /// n_iji afterwards.
    stayed: u16,
}

/// Writes `k` into the list of a pair in state `i`, in place of the oldest entry when it is full,
/// and keeps counts and sum. `None` when that changed nothing but the order of the list.
#[inline(always)]
fn push<E: Entry>(
    pair: &mut Pair,
    entries: &mut [E],
    lambda: usize,
    i: u16,
    k: u16,
) -> Option<Pushed> {
    let (list, counts) = entries.split_at_mut(lambda);
    let place = &mut list[usize::from(pair.next)];
    let oldest = place.get();
    *place = E::of(k);
    pair.next = if usize::from(pair.next) + 1 == lambda {
        0
    } else {
        pair.next + 1
    };
    let grown = usize::from(pair.recorded) < lambda;
    if grown {
        pair.recorded += 1;
    } else {
        if oldest == k {
            return None;
        }
        let count = &mut counts[usize::from(oldest)];
        let left = count.get() - 1;
        *count = E::of(left);
        pair.m_log_m -= log_step(left);
    }
    let count = &mut counts[usize::from(k)];
    let before = count.get();
    *count = E::of(before + 1);
    pair.m_log_m += log_step(before);
    Some(Pushed {
        grown,
        stayed: counts[usize::from(i)].get(),
    })
}

/// What one more entry adds to the sum of m log m where there were `count`.
#[inline(always)]
fn log_step(count: u16) -> i64 {
    M_LOG_M[usize::from(count) + 1] - M_LOG_M[usize::from(count)]
}

/// n_ij Q(i, j) in nats: n log n less the sum of m log m.
#[inline(always)]
fn entropy_sum(pair: &Pair) -> f64 {
    (M_LOG_M[usize::from(pair.recorded)] - pair.m_log_m) as f64 * (1.0 / UNIT)
}

/// Eq. 4.9 with both terms over n_ij; `stayed` is n_iji.
#[inline(always)]
fn score(alpha: f64, pair: Pair, stayed: u16) -> f32 {
    let left = f64::from(pair.recorded - stayed);
    let sum = (1.0 - alpha) * entropy_sum(&pair) + alpha * left;
    (sum / f64::from(pair.recorded)) as f32
}

/// Index of the highest score, the lowest on ties.
#[inline(always)]
fn first_maximum(scores: &[f32]) -> usize {
    let mut best = 0;
    for (j, score) in scores.iter().enumerate() {
        if *score > scores[best] {
            best = j;
        }
    }
    best
}

mod sound;

#[cfg(test)]
#[path = "repository_tests.rs"]
mod tests;
