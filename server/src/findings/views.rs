//! Stored jobs and runs, with what workers know of them right now, as the service shows them.

use api::{Job, Progress, RunSummary, State};

use crate::scheduler::{Scheduler, View, share};
use crate::store::{JobView, Position, RunState, RunView};

/// A job, with the progress of its running runs.
pub fn job(view: &JobView, scheduler: &Scheduler) -> Job {
    let progress = scheduler.progress(view);
    let state = view.intent.job_state(&view.counts);
    let running = state == State::Running;
    Job {
        id: view.seq.to_string(),
        name: view.name.clone(),
        state,
        priority: view.priority,
        created_at: view.created_at.clone(),
        runs: view.counts,
        progress: progress.fraction,
        eta_s: progress.eta_s.filter(|_| running),
        robot_steps_per_s: progress.robot_steps_per_s.filter(|_| running),
    }
}

/// A run, with its live progress when a worker holds it.
pub fn run(view: &RunView, scheduler: &Scheduler) -> RunSummary {
    let progress = match &view.state {
        RunState::Running => scheduler.view(view.seq).map(|live| live_progress(&live)),
        RunState::Queued(position) | RunState::Paused(position) => position
            .as_ref()
            .map(|position| stored_progress(position, view)),
        RunState::Done(_) => Some(Progress {
            phase: "done".to_owned(),
            epochs_done: view.epochs_total,
            epochs_total: view.epochs_total,
            robot_steps_done: view.robot_steps_total,
            robot_steps_total: view.robot_steps_total,
            fraction: 1.0,
            eta_s: None,
            robot_steps_per_s: None,
        }),
        RunState::Failed { .. } | RunState::Damaged { .. } | RunState::Cancelled => None,
    };
    let is_running = view.state.state() == State::Running;
    let waits = is_running.then(|| scheduler.waiting(view.seq)).flatten();
    RunSummary {
        id: view.id.clone(),
        job_id: view.job.to_string(),
        index: view.ordinal,
        seed: view.seed,
        arena: view.arena.clone(),
        method: view.method.clone(),
        label: view.label.clone(),
        results_version: view.results_version,
        state: view.state.state(),
        waits_for: waits.map(|(waits_for, _)| waits_for),
        waited_s: waits.map(|(_, since)| since.elapsed().as_secs_f64()),
        progress,
        result: view.result().cloned(),
        cpu_ns_per_robot_step: view.cpu_ns_per_robot_step,
        error: match &view.state {
            RunState::Failed { reason } | RunState::Damaged { reason } => Some(reason.clone()),
            _ => view.waits.clone(),
        },
        origin: view.origin.clone(),
    }
}

/// How far a run is that a worker holds.
pub fn live_progress(live: &View) -> Progress {
    let progress = &live.progress;
    Progress {
        phase: progress.phase.name().to_owned(),
        epochs_done: progress.epochs_done,
        epochs_total: progress.epochs_total,
        robot_steps_done: progress.robot_steps_done,
        robot_steps_total: progress.robot_steps_total,
        fraction: share(progress.robot_steps_done, progress.robot_steps_total),
        eta_s: live.eta_s(),
        robot_steps_per_s: live.robot_steps_per_s,
    }
}

fn stored_progress(position: &Position, view: &RunView) -> Progress {
    Progress {
        phase: position.phase.clone(),
        epochs_done: position.epochs_done,
        epochs_total: view.epochs_total,
        robot_steps_done: position.robot_steps_done,
        robot_steps_total: view.robot_steps_total,
        fraction: share(position.robot_steps_done, view.robot_steps_total),
        eta_s: None,
        robot_steps_per_s: None,
    }
}
