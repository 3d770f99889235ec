//! Which run is next: jobs take turns, and within a job runs go in order.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound;

use crate::store::{JobKey, RunKey};

/// Waiting runs by job. A hint only: the store decides whether a run really still waits.
#[derive(Debug, Default)]
pub struct FairQueue {
    jobs: BTreeMap<JobKey, VecDeque<RunKey>>,
    served: JobKey,
}

impl FairQueue {
    /// Adds a run behind the others of its job.
    pub fn push(&mut self, job: JobKey, run: RunKey) {
        self.jobs.entry(job).or_default().push_back(run);
    }

    /// Puts a run before the others of its job.
    pub fn push_front(&mut self, job: JobKey, run: RunKey) {
        self.jobs.entry(job).or_default().push_front(run);
    }

    /// Replaces what waits of a job.
    pub fn set(&mut self, job: JobKey, runs: Vec<RunKey>) {
        if runs.is_empty() {
            self.jobs.remove(&job);
        } else {
            self.jobs.insert(job, runs.into());
        }
    }

    /// Forgets a job.
    pub fn remove(&mut self, job: JobKey) {
        self.jobs.remove(&job);
    }

    /// Takes the first free run of the job whose turn it is, if any job has one.
    pub fn pop(&mut self, is_free: impl Fn(RunKey) -> bool) -> Option<(JobKey, RunKey)> {
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
