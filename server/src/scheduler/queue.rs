//! Which run is next: jobs of the highest priority take turns, and within a job runs go in order.

use std::cmp::Reverse;
use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound;

use crate::store::{JobKey, RunKey};

/// Waiting runs by priority and job. A hint only: the store decides whether a run really still
/// waits.
#[derive(Debug, Default)]
pub struct FairQueue {
    /// Those that are not 0.
    priorities: BTreeMap<JobKey, i32>,
    levels: BTreeMap<Reverse<i32>, Level>,
}

/// Jobs of one priority.
#[derive(Debug, Default)]
struct Level {
    jobs: BTreeMap<JobKey, VecDeque<RunKey>>,
    served: JobKey,
}

impl FairQueue {
    /// Adds a run behind the others of its job.
    pub fn push(&mut self, job: JobKey, run: RunKey) {
        self.level(job).jobs.entry(job).or_default().push_back(run);
    }

    /// Puts a run before the others of its job.
    pub fn push_front(&mut self, job: JobKey, run: RunKey) {
        self.level(job).jobs.entry(job).or_default().push_front(run);
    }

    /// Replaces what waits of a job.
    pub fn set(&mut self, job: JobKey, runs: Vec<RunKey>) {
        let level = self.level(job);
        if runs.is_empty() {
            level.jobs.remove(&job);
        } else {
            level.jobs.insert(job, runs.into());
        }
    }

    /// Forgets what waits of a job.
    pub fn remove(&mut self, job: JobKey) {
        self.level(job).jobs.remove(&job);
    }

    /// Changes when a job's runs come: before all of lower priority. What runs, runs on.
    pub fn set_priority(&mut self, job: JobKey, priority: i32) {
        let waiting = self.level(job).jobs.remove(&job);
        if priority == 0 {
            self.priorities.remove(&job);
        } else {
            self.priorities.insert(job, priority);
        }
        if let Some(waiting) = waiting {
            self.level(job).jobs.insert(job, waiting);
        }
    }

    /// Takes the first free run of the job whose turn it is, if any job has one.
    pub fn pop(&mut self, is_free: impl Fn(RunKey) -> bool) -> Option<(JobKey, RunKey)> {
        let found = (self.levels.values_mut()).find_map(|level| level.pop(&is_free));
        self.levels.retain(|_, level| !level.jobs.is_empty());
        found
    }

    /// Runs that wait.
    pub fn len(&self) -> usize {
        let jobs = self.levels.values().flat_map(|level| level.jobs.values());
        jobs.map(VecDeque::len).sum()
    }

    fn level(&mut self, job: JobKey) -> &mut Level {
        let priority = self.priorities.get(&job).copied().unwrap_or(0);
        self.levels.entry(Reverse(priority)).or_default()
    }
}

impl Level {
    fn pop(&mut self, is_free: impl Fn(RunKey) -> bool) -> Option<(JobKey, RunKey)> {
        let after = self
            .jobs
            .range((Bound::Excluded(self.served), Bound::Unbounded));
        let before = self.jobs.range(..=self.served);
        let (job, place) = after.chain(before).find_map(|(job, runs)| {
            let place = runs.iter().position(|run| is_free(*run))?;
            Some((*job, place))
        })?;
        self.served = job;
        let runs = self.jobs.get_mut(&job)?;
        let run = runs.remove(place)?;
        if runs.is_empty() {
            self.jobs.remove(&job);
        }
        Some((job, run))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn queue(jobs: &[(i64, &[i64])]) -> FairQueue {
        let mut queue = FairQueue::default();
        for (job, runs) in jobs {
            let runs = runs.iter().map(|run| RunKey(*run)).collect();
            queue.set(JobKey(*job), runs);
        }
        queue
    }

    fn pop(queue: &mut FairQueue, busy: &[i64]) -> Option<(i64, i64)> {
        let popped = queue.pop(|run| !busy.contains(&run.0));
        popped.map(|(job, run)| (job.0, run.0))
    }

    fn drain(mut queue: FairQueue) -> Vec<(i64, i64)> {
        std::iter::from_fn(|| pop(&mut queue, &[])).collect()
    }

    #[test]
    fn jobs_take_turns_and_runs_go_in_order() {
        let queue = queue(&[(1, &[10, 11, 12]), (2, &[20]), (5, &[50, 51])]);
        let order = drain(queue);
        assert_eq!(
            order,
            [(1, 10), (2, 20), (5, 50), (1, 11), (5, 51), (1, 12)]
        );
    }

    #[test]
    fn jobs_of_higher_priority_come_first_and_take_turns() {
        let mut queue = queue(&[(1, &[10, 11]), (2, &[20, 21]), (3, &[30]), (4, &[40])]);
        queue.set_priority(JobKey(3), 5);
        queue.set_priority(JobKey(2), 5);
        queue.set_priority(JobKey(1), -1);
        let order = [(2, 20), (3, 30), (2, 21), (4, 40), (1, 10), (1, 11)];
        assert_eq!(pop(&mut queue, &[]), Some(order[0]));
        assert_eq!(drain(queue), order[1..]);
    }

    #[test]
    fn what_is_added_later_has_the_priority_of_its_job() {
        let mut queue = queue(&[(1, &[10])]);
        queue.set_priority(JobKey(2), 1);
        queue.push(JobKey(2), RunKey(20));
        queue.set_priority(JobKey(1), 2);
        queue.set_priority(JobKey(1), 0);
        assert_eq!(drain(queue), [(2, 20), (1, 10)]);
    }

    #[test]
    fn a_busy_run_is_passed_over_and_stays() {
        let mut queue = queue(&[(1, &[10, 11]), (2, &[20])]);
        assert_eq!(pop(&mut queue, &[10]), Some((1, 11)));
        assert_eq!(pop(&mut queue, &[10]), Some((2, 20)));
        assert_eq!(pop(&mut queue, &[10]), None);
        assert_eq!(pop(&mut queue, &[]), Some((1, 10)));
    }

    #[test]
    fn a_forgotten_job_is_never_served() {
        let mut queue = queue(&[(1, &[10]), (2, &[20])]);
        queue.remove(JobKey(1));
        queue.push(JobKey(2), RunKey(21));
        queue.push_front(JobKey(2), RunKey(19));
        assert_eq!(drain(queue), [(2, 19), (2, 20), (2, 21)]);
    }
}
