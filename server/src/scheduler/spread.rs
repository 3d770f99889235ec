//! Threads that no run needs go to the runs with large worlds, until a run needs them again.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Who uses how many of the workers' threads.
#[derive(Debug)]
pub struct Spread {
    workers: usize,
    /// Workers that have a run.
    busy: AtomicUsize,
    /// Runs with large worlds.
    large: AtomicUsize,
}

/// While it lives, a run with a large world gets its share.
pub struct LargeRun<'a>(&'a Spread);

impl Spread {
    /// So many workers, none of which has a run.
    pub fn new(workers: usize) -> Self {
        Self {
            workers,
            busy: AtomicUsize::new(0),
            large: AtomicUsize::new(0),
        }
    }

    /// So many workers have a run now.
    pub fn set_busy(&self, busy: usize) {
        self.busy.store(busy, Ordering::Relaxed);
    }

    /// A run with a large world begins.
    pub fn large_run(&self) -> LargeRun<'_> {
        self.large.fetch_add(1, Ordering::Relaxed);
        LargeRun(self)
    }
}

impl LargeRun<'_> {
    /// Threads that the run may use right now, its worker's included: an equal share of those that
    /// are free.
    pub fn threads(&self) -> usize {
        let Spread {
            workers,
            busy,
            large,
        } = self.0;
        let free = workers.saturating_sub(busy.load(Ordering::Relaxed));
        1 + free / large.load(Ordering::Relaxed).max(1)
    }
}

impl Drop for LargeRun<'_> {
    fn drop(&mut self) {
        self.0.large.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_threads_are_shared_by_large_runs_and_runs_come_first() {
        let spread = Spread::new(8);
        spread.set_busy(1);
        let one = spread.large_run();
        assert_eq!(one.threads(), 8);
        spread.set_busy(2);
        let other = spread.large_run();
        assert_eq!((one.threads(), other.threads()), (4, 4));
        spread.set_busy(7);
        assert_eq!(one.threads(), 1);
        spread.set_busy(8);
        assert_eq!(one.threads(), 1);
        drop(other);
        spread.set_busy(5);
        assert_eq!(one.threads(), 4);
    }
}
