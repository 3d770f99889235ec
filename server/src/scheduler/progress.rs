//! How far a job is: what is stored of it, and what workers know of its running runs.

use super::Scheduler;
use crate::store::JobView;

/// A job's progress at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JobProgress {
    /// Share of the work done, 0 to 1.
    pub fraction: f64,
    /// Robot-steps a second of all its running runs; `None` while none is known to move.
    pub robot_steps_per_s: Option<f64>,
    /// Seconds left at this speed.
    pub eta_s: Option<f64>,
}

impl Scheduler {
    /// How far a stored job is right now.
    pub fn progress(&self, job: &JobView) -> JobProgress {
        let (mut done, mut total, mut left) = (job.work_done, job.work_total, job.work_left);
        let (mut speed, mut work_per_s) = (0.0, 0.0);
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
            let cost = u64::from(run.step_cost);
            done += run_done * cost;
            total += run_total * cost;
            left += run_total.saturating_sub(run_done) * cost;
            if let Some(live) = live {
                let run_speed = live.robot_steps_per_s.unwrap_or(0.0);
                speed += run_speed;
                work_per_s += run_speed * f64::from(run.step_cost);
                slowest_s = slowest_s.max(live.eta_s().unwrap_or(0.0));
            }
        }
        let moves = speed > 0.0;
        JobProgress {
            fraction: share(done, total),
            robot_steps_per_s: moves.then_some(speed),
            // The last runs leave threads idle: the job takes at least as long as its slowest run.
            eta_s: moves.then(|| (left as f64 / work_per_s).max(slowest_s)),
        }
    }
}

/// A part of a whole, 0 to 1; none of nothing.
pub fn share(done: u64, total: u64) -> f64 {
    if total == 0 {
        0.0
    } else {
        (done as f64 / total as f64).min(1.0)
    }
}
