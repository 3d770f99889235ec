//! Whether a table that was saved is one that recording transitions leads to.

use super::{Entries, Entry, M_LOG_M, MAX_LAMBDA, Pair, Repository, State, first_maximum, score};

impl Repository {
    /// Whether saved parts fit together: everything but the lists follows from the lists, and is
    /// computed from them again.
    pub fn is_sound(&self) -> bool {
        let (ns, na, lambda) = (self.ns as usize, self.na as usize, usize::from(self.lambda));
        if !(1..=0xFFFF).contains(&ns)
            || !(1..=0xFFFF).contains(&na)
            || !(1..=MAX_LAMBDA).contains(&lambda)
            || !self.alpha.is_finite()
        {
            return false;
        }
        // Below 2^32 times 2^17.
        let pairs = ns * na;
        let is_narrow = Entries::width(self.ns, u32::from(self.lambda)) == 1;
        let entries = pairs * (lambda + ns);
        let fits = match &self.entries {
            Entries::Bytes(bytes) => is_narrow && bytes.len() == entries,
            Entries::Words(words) => !is_narrow && words.len() == entries,
        };
        let lengths = [self.pairs.len(), self.scores.len(), self.deficient.len()];
        if !fits || self.states.len() != ns || lengths != [pairs; 3] {
            return false;
        }
        let mut counts = vec![0_u16; ns];
        (0..ns).all(|i| {
            let pairs = i * na..(i + 1) * na;
            let lists = pairs.clone().all(|at| {
                let (from, len) = (at * (lambda + ns), lambda + ns);
                match &self.entries {
                    Entries::Bytes(all) => self.follows(at, i, &all[from..][..len], &mut counts),
                    Entries::Words(all) => self.follows(at, i, &all[from..][..len], &mut counts),
                }
            });
            lists && self.state_follows(&self.states[i], &self.pairs[pairs.clone()], pairs.start)
        })
    }

    /// Whether counts, sum and score of a pair follow from its list; `counts` is scratch.
    fn follows<E: Entry>(&self, at: usize, i: usize, saved: &[E], counts: &mut [u16]) -> bool {
        let (list, saved_counts) = saved.split_at(usize::from(self.lambda));
        let pair = self.pairs[at];
        let recorded = usize::from(pair.recorded);
        if recorded > list.len()
            || usize::from(pair.next) >= list.len()
            || (recorded < list.len() && pair.next != pair.recorded)
        {
            return false;
        }
        counts.fill(0);
        for entry in &list[..recorded] {
            let Some(count) = counts.get_mut(usize::from(entry.get())) else {
                return false;
            };
            *count += 1;
        }
        let m_log_m: i64 = counts.iter().map(|m| M_LOG_M[usize::from(*m)]).sum();
        let expected = match recorded {
            0 => f32::NEG_INFINITY,
            _ => score(self.alpha, pair, counts[i]),
        };
        pair.m_log_m == m_log_m
            && saved_counts
                .iter()
                .zip(&*counts)
                .all(|(s, c)| s.get() == *c)
            && self.scores[at].to_bits() == expected.to_bits()
    }

    /// Whether what is kept of a state follows from its pairs, the first of which is `first`.
    fn state_follows(&self, state: &State, pairs: &[Pair], first: usize) -> bool {
        let recorded: u32 = pairs.iter().map(|pair| u32::from(pair.recorded)).sum();
        let deficient = (0..)
            .zip(pairs)
            .filter(|(_, pair)| pair.recorded < self.lambda)
            .map(|(j, _): (u16, _)| j);
        let saved = &self.deficient[first..][..pairs.len()];
        let Some(saved) = saved.get(..usize::from(state.deficient)) else {
            return false;
        };
        let scores = &self.scores[first..][..pairs.len()];
        state.recorded == recorded
            && saved.iter().copied().eq(deficient)
            && usize::from(state.best_action) == first_maximum(scores)
    }
}
