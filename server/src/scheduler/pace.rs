//! When to do something on the side again: not too often, and never for more than a small share of
//! the time.

use std::time::{Duration, Instant};

/// The time of a side task that repeats.
#[derive(Debug)]
pub struct Pace {
    least: Duration,
    rest: u32,
    next: Instant,
}

impl Pace {
    /// At most once every `least`, and with `rest` times its own duration between two times. The
    /// first time is due after `first`.
    pub fn new(least: Duration, rest: u32, first: Duration) -> Self {
        Self {
            least,
            rest,
            next: Instant::now() + first,
        }
    }

    /// Does the task if it is due.
    pub fn when_due(&mut self, task: impl FnOnce()) {
        let start = Instant::now();
        if start < self.next {
            return;
        }
        task();
        let took = start.elapsed();
        self.next = start + took + self.least.max(took.saturating_mul(self.rest));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dear_task_waits_in_proportion() {
        let mut pace = Pace::new(Duration::ZERO, 1_000, Duration::ZERO);
        let mut times = 0;
        pace.when_due(|| {
            std::thread::sleep(Duration::from_millis(5));
            times += 1;
        });
        pace.when_due(|| times += 1);
        assert_eq!(times, 1);
    }

    #[test]
    fn the_first_time_can_wait() {
        let mut pace = Pace::new(Duration::ZERO, 0, Duration::from_secs(3_600));
        pace.when_due(|| panic!("not due"));
    }
}
