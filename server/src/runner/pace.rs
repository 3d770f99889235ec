//! When to do something on the side again: rarely enough to take a small share of the time, but
//! never less often than is promised, however slow the last time was on a machine under load.

use std::time::{Duration, Instant};

/// The time of a side task that repeats.
#[derive(Debug)]
pub struct Pace {
    rest: Rest,
    next: Instant,
}

/// How long a side task rests after it was done.
#[derive(Clone, Copy, Debug)]
struct Rest {
    least: Duration,
    /// In multiples of what the task took, where that lies between `least` and `most`.
    times: u32,
    most: Duration,
}

impl Rest {
    /// A task that takes longer than `most` rests as long as it took, so that never more than half
    /// of the time goes into it.
    fn after(&self, took: Duration) -> Duration {
        took.saturating_mul(self.times)
            .clamp(self.least, self.most.max(self.least))
            .max(took)
    }
}

impl Pace {
    /// For what must be seen at least every second: at first at once, then five times a second, and
    /// less often where it takes more than a millisecond. A quarter of the second is left for the
    /// task itself and for the block of steps that is under way when it falls due.
    pub fn every_second() -> Self {
        let rest = Rest {
            least: Duration::from_millis(200),
            times: 200,
            most: Duration::from_millis(750),
        };
        Self::new(rest, Duration::ZERO, Instant::now())
    }

    /// For what must be safe at least every half minute: every two seconds, and less often where it
    /// takes more than 20 ms. Five seconds are left for the task itself.
    pub fn every_half_minute() -> Self {
        let rest = Rest {
            least: Duration::from_secs(2),
            times: 100,
            most: Duration::from_secs(25),
        };
        Self::new(rest, rest.least, Instant::now())
    }

    /// For what is looked at: at once, then after `least`, and less often where it takes more than a
    /// twentieth of the time.
    pub fn watched(least: Duration) -> Self {
        let rest = Rest {
            least,
            times: 19,
            most: Duration::from_secs(5),
        };
        Self::new(rest, Duration::ZERO, Instant::now())
    }

    /// The first time is due after `first`.
    fn new(rest: Rest, first: Duration, now: Instant) -> Self {
        Self {
            rest,
            next: now + first,
        }
    }

    /// Does the task if it is due.
    pub fn when_due(&mut self, task: impl FnOnce()) {
        self.when_due_by(&Instant::now, task);
    }

    fn when_due_by(&mut self, clock: &dyn Fn() -> Instant, task: impl FnOnce()) {
        let start = clock();
        if self.is_due(start) {
            task();
            self.rest_after(start, clock());
        }
    }

    /// Whether the task is due.
    pub fn is_due(&self, now: Instant) -> bool {
        now >= self.next
    }

    /// The task has just been done, from `start` to `end`.
    pub fn rest_after(&mut self, start: Instant, end: Instant) {
        self.next = end + self.rest.after(end.saturating_duration_since(start));
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    const BLOCK: Duration = Duration::from_millis(10);
    const MS: Duration = Duration::from_millis(1);

    /// Steps a run for ten minutes of a clock that only moves when something is done. Returns the
    /// longest time between two ends of the task, and the share of the time that went into it.
    fn ten_minutes(
        pace: impl Fn() -> Pace,
        block: Duration,
        task: impl Fn(u32) -> Duration,
    ) -> (Duration, f64) {
        let mut pace = pace();
        let start = Instant::now();
        let now = Cell::new(start);
        let clock = || now.get();
        let (mut done, mut last, mut longest) = (0, start, Duration::ZERO);
        let mut spent = Duration::ZERO;
        while now.get() - start < Duration::from_secs(600) {
            now.set(now.get() + block);
            let before = done;
            pace.when_due_by(&clock, || {
                let takes = task(done);
                now.set(now.get() + takes);
                spent += takes;
                done += 1;
            });
            if done > before {
                longest = longest.max(now.get() - last);
                last = now.get();
            }
        }
        longest = longest.max(now.get() - last);
        (
            longest,
            spent.as_secs_f64() / (now.get() - start).as_secs_f64(),
        )
    }

    #[test]
    fn a_view_comes_every_second_however_slow_the_one_before_was() {
        for took in [0, 1, 5, 50, 200] {
            let (longest, _) = ten_minutes(Pace::every_second, BLOCK, |_| MS * took);
            assert!(longest <= MS * 1_000, "{took} ms: {longest:?}");
        }
        // One slow view among quick ones.
        let odd = |number| if number % 7 == 3 { MS * 240 } else { MS };
        let (longest, _) = ten_minutes(Pace::every_second, BLOCK, odd);
        assert!(longest <= MS * 1_000, "{longest:?}");
    }

    #[test]
    fn a_checkpoint_comes_every_half_minute() {
        for took in [0, 20, 300, 4_900] {
            let (longest, _) = ten_minutes(Pace::every_half_minute, BLOCK, |_| MS * took);
            assert!(longest <= MS * 30_000, "{took} ms: {longest:?}");
        }
    }

    #[test]
    fn what_is_quick_takes_a_small_share_and_nothing_takes_more_than_half() {
        let share = |took| ten_minutes(Pace::every_second, BLOCK, |_| took).1;
        assert!(share(MS) < 0.01);
        assert!(share(MS * 3) < 0.01);
        // A world so large that a view takes two seconds, with blocks of one: no promise, but half
        // of the time is for stepping.
        let (longest, share) = ten_minutes(Pace::every_second, MS * 1_000, |_| MS * 2_000);
        assert!(share <= 0.5, "{share}");
        assert!(longest <= MS * 5_000, "{longest:?}");
    }

    #[test]
    fn the_first_view_is_at_once_and_the_first_checkpoint_is_not() {
        let mut seen = false;
        Pace::every_second().when_due(|| seen = true);
        assert!(seen);
        Pace::every_half_minute().when_due(|| panic!("not due"));
    }
}
