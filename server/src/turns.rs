//! Turns of work that takes much memory or time, so that many requests for it at once cost no more
//! than a few, and leave room for all others.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::asked::is_given_up;
use crate::memory;

/// Turns at a time ...
const MAX_AT_A_TIME: usize = 2;
/// ... and most that wait for one: a quarter of the requests that are answered at a time.
const MAX_WAITING: usize = 32;
/// Longest wait.
const PATIENCE: Duration = Duration::from_secs(30);
/// A text above this is much work: read, it may take a hundred times as many bytes.
pub const LARGE_TEXT_BYTES: usize = 64 << 10;

/// Why there is no turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Busy(&'static str);

/// Who may do much work of one kind.
#[derive(Clone)]
pub struct Turns(Arc<Queue>);

struct Queue {
    state: Mutex<State>,
    changed: Condvar,
    limits: Limits,
}

struct Limits {
    at_a_time: usize,
    waiting: usize,
    patience: Duration,
}

#[derive(Default)]
struct State {
    working: usize,
    /// Who waits, the first before the others.
    waiting: VecDeque<u64>,
    next: u64,
}

/// A turn, over when this is dropped. What it took is given back first, as the allocator would keep
/// it for each thread that ever had a turn.
pub struct Turn(Arc<Queue>);

impl Default for Turns {
    fn default() -> Self {
        Self::with(Limits {
            at_a_time: MAX_AT_A_TIME,
            waiting: MAX_WAITING,
            patience: PATIENCE,
        })
    }
}

impl Turns {
    fn with(limits: Limits) -> Self {
        Self(Arc::new(Queue {
            state: Mutex::default(),
            changed: Condvar::new(),
            limits,
        }))
    }

    /// A turn for what is much work; none is needed for anything else.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub fn take_if(&self, is_much: bool) -> Result<Option<Turn>, Busy> {
        is_much.then(|| self.take()).transpose()
    }

    /// Waits for a turn.
    ///
    /// # Errors
    /// When too many wait, or for too long, or nobody waits for what it is for any more.
    pub fn take(&self) -> Result<Turn, Busy> {
        let Queue {
            changed, limits, ..
        } = &*self.0;
        let mut state = self.0.state();
        if state.working == limits.at_a_time || !state.waiting.is_empty() {
            if state.waiting.len() >= limits.waiting {
                return Err(Busy("too many requests for much work at a time"));
            }
            let number = state.next;
            state.next += 1;
            state.waiting.push_back(number);
            let end = Instant::now() + limits.patience;
            while state.working == limits.at_a_time || state.waiting.front() != Some(&number) {
                let left = end.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    state.waiting.retain(|waiting| *waiting != number);
                    changed.notify_all();
                    return Err(Busy("other requests for much work took too long"));
                }
                let waited = changed.wait_timeout(state, left);
                (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
            }
            state.waiting.pop_front();
        }
        state.working += 1;
        drop(state);
        // The next one may have a turn too.
        changed.notify_all();
        let turn = Turn(Arc::clone(&self.0));
        if is_given_up() {
            return Err(Busy("the client is gone"));
        }
        Ok(turn)
    }
}

impl Queue {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        memory::trim();
        self.0.state().working -= 1;
        self.0.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn turns_are_taken_in_order_and_those_that_wait_are_bounded() {
        let turns = Turns::with(Limits {
            at_a_time: 1,
            waiting: 2,
            patience: Duration::from_secs(60),
        });
        let order = Mutex::new(Vec::new());
        let first = turns.take().unwrap();
        std::thread::scope(|scope| {
            for number in 0..2 {
                let (turns, order) = (&turns, &order);
                scope.spawn(move || {
                    let turn = turns.take().unwrap();
                    order.lock().unwrap().push(number);
                    drop(turn);
                });
                while turns.0.state().waiting.len() <= number {
                    std::thread::yield_now();
                }
            }
            assert!(turns.take().is_err());
            drop(first);
        });
        assert_eq!(order.into_inner().unwrap(), [0, 1]);
        assert!(turns.take().is_ok());
    }

    #[test]
    fn who_waits_too_long_leaves_its_place() {
        let turns = Turns::with(Limits {
            at_a_time: 1,
            waiting: 1,
            patience: Duration::from_millis(20),
        });
        let first = turns.take().unwrap();
        for _ in 0..3 {
            assert!(turns.take().is_err());
        }
        drop(first);
        assert!(turns.take().is_ok());
    }
}
