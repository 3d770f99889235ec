//! Which run is next: jobs take turns, and within a job runs go in order.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound;

use crate::store::{JobSeq, RunSeq};

/// Waiting runs by job. A hint only: the store decides whether a run really still waits.
#[derive(Debug, Default)]
pub struct FairQueue {
    jobs: BTreeMap<JobSeq, VecDeque<RunSeq>>,
    served: JobSeq,
}

impl FairQueue {
    /// Adds a run behind the others of its job.
    pub fn push(&mut self, job: JobSeq, run: RunSeq) {
        self.jobs.entry(job).or_default().push_back(run);
    }

    /// Puts a run before the others of its job.
    pub fn push_front(&mut self, job: JobSeq, run: RunSeq) {
        self.jobs.entry(job).or_default().push_front(run);
    }

    /// Replaces what waits of a job.
    pub fn set(&mut self, job: JobSeq, runs: Vec<RunSeq>) {
        if runs.is_empty() {
            self.jobs.remove(&job);
        } else {
            self.jobs.insert(job, runs.into());
        }
    }

    /// Forgets a job.
    pub fn remove(&mut self, job: JobSeq) {
        self.jobs.remove(&job);
    }

    /// Takes the first free run of the job whose turn it is, if any job has one.
    pub fn pop(&mut self, is_free: impl Fn(RunSeq) -> bool) -> Option<(JobSeq, RunSeq)> {
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

    fn queue(jobs: &[(JobSeq, &[RunSeq])]) -> FairQueue {
        let mut queue = FairQueue::default();
        for (job, runs) in jobs {
            queue.set(*job, runs.to_vec());
        }
        queue
    }

    fn drain(mut queue: FairQueue) -> Vec<(JobSeq, RunSeq)> {
        std::iter::from_fn(|| queue.pop(|_| true)).collect()
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
        assert_eq!(queue.pop(|run| run != 10), Some((1, 11)));
        assert_eq!(queue.pop(|run| run != 10), Some((2, 20)));
        assert_eq!(queue.pop(|run| run != 10), None);
        assert_eq!(queue.pop(|_| true), Some((1, 10)));
    }

    #[test]
    fn a_forgotten_job_is_never_served() {
        let mut queue = queue(&[(1, &[10]), (2, &[20])]);
        queue.remove(1);
        queue.push(2, 21);
        queue.push_front(2, 19);
        assert_eq!(drain(queue), [(2, 19), (2, 20), (2, 21)]);
    }
}
