//! How far a job is: what is stored of it, and what workers know of its running runs.

use super::Scheduler;
use crate::store::JobView;

/// A job's progress at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JobProgress {
    /// Robot-steps done.
    pub robot_steps_done: u64,
    /// Robot-steps in all.
    pub robot_steps_total: u64,
    /// Of all its running runs; `None` while none is known to move.
    pub robot_steps_per_s: Option<f64>,
    /// Seconds left at this speed.
    pub eta_s: Option<f64>,
}

impl Scheduler {
    /// How far a stored job is right now.
    pub fn progress(&self, job: &JobView) -> JobProgress {
        let (mut done, mut total) = (job.robot_steps_done, job.robot_steps_total);
        let mut left = job.robot_steps_left;
        let mut speed = 0.0;
        let mut slowest_s: f64 = 0.0;
        for run in &job.running {
            let live = self.view(run.seq);
            let (run_done, run_total) = match &live {
                Some(live) => (
                    live.progress.robot_steps_done,
                    live.progress.robot_steps_total,
                ),
                None => (run.robot_steps_done, run.robot_steps_total),
            };
            done += run_done;
            total += run_total;
            left += run_total.saturating_sub(run_done);
            if let Some(live) = live {
                speed += live.robot_steps_per_s.unwrap_or(0.0);
                slowest_s = slowest_s.max(live.eta_s().unwrap_or(0.0));
            }
        }
        let moves = speed > 0.0;
        JobProgress {
            robot_steps_done: done,
            robot_steps_total: total,
            robot_steps_per_s: moves.then_some(speed),
            // The last runs leave threads idle: the job takes at least as long as its slowest run.
            eta_s: moves.then(|| (left as f64 / speed).max(slowest_s)),
        }
    }
}
