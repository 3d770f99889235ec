//! All jobs as listeners to all of them hear of them: the latest of each with the number of the look
//! that found it changed, so that a slow listener is told each changed job once, as it is then.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::{Duration, Instant};

use api::events::Event;
use api::{Job, State};

use crate::store::{JobKey, JobMark, StoreError};

/// How long a look serves all listeners.
const KEPT: Duration = Duration::from_millis(400);
/// Most jobs that are there and have left the board of which listeners hear; one that missed more is let go.
const MOST_LEFT: usize = 500;

/// A job and what tells whether it has changed.
struct Shown {
    mark: String,
    job: Job,
    /// The look that found it so.
    changed_at: u64,
}

/// Where jobs are looked up.
pub(super) trait Jobs {
    /// Number of the newest change; that a job was deleted is one.
    fn newest_change(&self) -> Result<u64, StoreError>;
    /// What may be on the board.
    fn marks(&self) -> Result<Vec<JobMark>, StoreError>;
    /// A job as it is; `None` when it is gone.
    fn job(&self, key: JobKey) -> Result<Option<Job>, StoreError>;
}

/// Jobs by key, as the last look found them.
#[derive(Default)]
pub(super) struct Board {
    looks: u64,
    looked: Option<Instant>,
    /// Number of the newest change before the last look.
    newest: u64,
    shown: BTreeMap<JobKey, Shown>,
    /// What became of jobs that left the board, and at which look.
    left: VecDeque<(u64, Event)>,
    /// The look that found the newest of those that are not told any more.
    forgotten_at: u64,
}

impl Board {
    /// Number of the newest change that all of the board has taken in: whoever begins with the board
    /// goes on from there.
    ///
    /// # Errors
    /// When jobs cannot be read.
    pub fn newest(&mut self, jobs: &impl Jobs) -> Result<u64, StoreError> {
        self.renew(jobs, 0)?;
        Ok(self.newest)
    }

    /// What has changed since the look of this number; and the number of the last look. For none
    /// all jobs, as they were after a change of which the listener has heard. `None` for whoever has
    /// missed that jobs left.
    ///
    /// # Errors
    /// When jobs cannot be read.
    pub fn since(
        &mut self,
        jobs: &impl Jobs,
        heard: Option<u64>,
        change: u64,
    ) -> Result<Option<(Vec<Event>, u64)>, StoreError> {
        self.renew(jobs, if heard.is_none() { change } else { 0 })?;
        if heard.is_some_and(|heard| heard < self.forgotten_at) {
            return Ok(None);
        }
        let after = heard.unwrap_or(0);
        let changed = self.shown.values().filter(|one| one.changed_at > after);
        let mut told: Vec<Event> = changed
            .map(|one| Event::Job(Box::new(one.job.clone())))
            .collect();
        if heard.is_some() {
            let left = self.left.iter().filter(|(at, _)| *at > after);
            told.extend(left.map(|(_, event)| event.clone()));
        }
        Ok(Some((told, self.looks)))
    }

    /// Looks again if the last look is old, or older than a change.
    fn renew(&mut self, jobs: &impl Jobs, change: u64) -> Result<(), StoreError> {
        let is_old = self.looked.is_none_or(|looked| looked.elapsed() >= KEPT);
        if is_old || self.newest < change {
            self.look(jobs)?;
            self.looked = Some(Instant::now());
        }
        Ok(())
    }

    fn look(&mut self, jobs: &impl Jobs) -> Result<(), StoreError> {
        let newest = jobs.newest_change()?;
        let marks = jobs.marks()?;
        let now = self.looks + 1;
        let there: BTreeSet<JobKey> = marks.iter().map(|mark| mark.seq).collect();
        for JobMark { seq, text } in marks {
            // What runs goes on without a change in the store.
            let is_as_it_was = self
                .shown
                .get(&seq)
                .is_some_and(|one| one.mark == text && one.job.state != State::Running);
            if is_as_it_was {
                continue;
            }
            let Some(job) = jobs.job(seq)? else { continue };
            let changed_at = match self.shown.get(&seq) {
                Some(one) if one.job == job => one.changed_at,
                _ => now,
            };
            let one = Shown {
                mark: text,
                job,
                changed_at,
            };
            self.shown.insert(seq, one);
        }
        let absent = self.shown.keys().filter(|key| !there.contains(key));
        for key in absent.copied().collect::<Vec<_>>() {
            let job = jobs.job(key)?;
            self.shown.remove(&key);
            // That one was deleted is a change with a number.
            if let Some(job) = job {
                self.left.push_back((now, Event::Job(Box::new(job))));
            }
        }
        while self.left.len() > MOST_LEFT {
            if let Some((at, _)) = self.left.pop_front() {
                self.forgotten_at = at;
            }
        }
        (self.looks, self.newest) = (now, newest);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::cell::{Cell, RefCell};

    use api::RunCounts;

    use super::*;

    /// Jobs that a test changes, the first that may be on the board, number of the newest change.
    #[derive(Default)]
    struct Fake(RefCell<BTreeMap<i64, Job>>, Cell<i64>, Cell<u64>);

    impl Fake {
        fn set(&self, key: i64, state: State, progress: f64) {
            let job = Job {
                id: key.to_string(),
                name: String::new(),
                state,
                priority: 0,
                created_at: String::new(),
                runs: RunCounts::default(),
                progress,
                eta_s: None,
                robot_steps_per_s: None,
            };
            self.0.borrow_mut().insert(key, job);
        }
    }

    impl Jobs for Fake {
        fn newest_change(&self) -> Result<u64, StoreError> {
            Ok(self.2.get())
        }

        fn marks(&self) -> Result<Vec<JobMark>, StoreError> {
            let jobs = self.0.borrow();
            let mark = |(key, job): (&i64, &Job)| JobMark {
                seq: JobKey(*key),
                text: job.state.to_string(),
            };
            Ok(jobs.range(self.1.get()..).map(mark).collect())
        }

        fn job(&self, key: JobKey) -> Result<Option<Job>, StoreError> {
            Ok(self.0.borrow().get(&key.0).cloned())
        }
    }

    fn said(events: &[Event]) -> Vec<String> {
        let said = |event: &Event| match event {
            Event::Job(job) => format!("{} {} {}", job.id, job.state, job.progress),
            other => panic!("{other:?}"),
        };
        events.iter().map(said).collect()
    }

    #[test]
    fn a_listener_is_told_what_has_changed_since_it_heard_last_and_once() {
        let (mut board, jobs) = (Board::default(), Fake::default());
        jobs.set(1, State::Done, 1.0);
        jobs.set(2, State::Running, 0.1);
        let (told, first) = board.since(&jobs, None, 0).unwrap().unwrap();
        assert_eq!(said(&told), ["1 done 1", "2 running 0.1"]);
        let look = |board: &mut Board| board.look(&jobs).unwrap();
        look(&mut board);
        assert_eq!(board.since(&jobs, Some(first), 0).unwrap().unwrap().0, []);
        // A slow listener misses progress, and hears what is so at last.
        jobs.set(2, State::Running, 0.2);
        look(&mut board);
        jobs.set(2, State::Done, 1.0);
        look(&mut board);
        jobs.set(3, State::Queued, 0.0);
        jobs.0.borrow_mut().remove(&1);
        look(&mut board);
        let (told, last) = board.since(&jobs, Some(first), 0).unwrap().unwrap();
        assert_eq!(said(&told), ["2 done 1", "3 queued 0"]);
        assert_eq!(board.since(&jobs, Some(last), 0).unwrap().unwrap().0, []);
        // Whoever comes now hears of what is there alone.
        let (told, _) = board.since(&jobs, None, 0).unwrap().unwrap();
        assert_eq!(said(&told), ["2 done 1", "3 queued 0"]);
    }

    /// The board is of a moment ago.
    #[test]
    fn a_job_of_which_was_heard_that_it_is_gone_is_shown_to_nobody_again() {
        let (mut board, jobs) = (Board::default(), Fake::default());
        jobs.set(1, State::Done, 1.0);
        jobs.2.set(7);
        assert_eq!(board.newest(&jobs).unwrap(), 7);
        jobs.0.borrow_mut().clear();
        jobs.2.set(8);
        // Whoever goes on from 7 will hear of it, whoever comes back with 8 has.
        let (told, _) = board.since(&jobs, None, 7).unwrap().unwrap();
        assert_eq!(said(&told), ["1 done 1"]);
        let (told, _) = board.since(&jobs, None, 8).unwrap().unwrap();
        assert_eq!(told, []);
        assert_eq!(board.newest(&jobs).unwrap(), 8);
    }

    #[test]
    fn whoever_has_missed_that_jobs_left_is_let_go() {
        let (mut board, jobs) = (Board::default(), Fake::default());
        let most = MOST_LEFT as i64;
        for key in 0..=most {
            jobs.set(key, State::Done, 1.0);
        }
        let (_, first) = board.since(&jobs, None, 0).unwrap().unwrap();
        jobs.1.set(most + 1);
        board.look(&jobs).unwrap();
        assert_eq!(board.left.len(), MOST_LEFT);
        assert_eq!(board.since(&jobs, Some(first), 0).unwrap(), None);
        let now = board.since(&jobs, None, 0).unwrap().unwrap();
        assert_eq!(now.0, []);
        assert!(board.since(&jobs, Some(now.1), 0).unwrap().is_some());
    }
}
