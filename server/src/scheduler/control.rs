//! Control from outside, of jobs and of single runs: what is possible in which state is decided
//! here, between two changes of the store. A run that a worker holds is let go of at a step
//! boundary, with a checkpoint, and taken up again as what it is then.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use api::{FieldError, Fork, State as Life};
use serde_json::Value;

use super::arenas::StoredArenas;
use super::control_error::ControlError;
use super::submission::new_job;
use super::{Scheduler, attempt};
use crate::documents::{ExpandedJob, ResolvedRun, expand, with_more_seeds};
use crate::store::{Created, Intent, JobKey, JobRequest, JobView, NewJob, RunKey, RunView};

/// Longest wait for a worker to let go of a run.
const LET_GO: Duration = Duration::from_secs(20);

impl Scheduler {
    /// Changes what is wanted of a job; wanting the same again is no error, unless the job is done.
    ///
    /// # Errors
    /// `Ended`, `Store`.
    pub fn want(&self, job: &JobView, intent: Intent) -> Result<(), ControlError> {
        let state = job.intent.job_state(&job.counts);
        let again = job.intent == intent && state == Life::Cancelled;
        if state.is_final() && !again {
            return Err(ControlError::Ended("job", state));
        }
        Ok(self.set_intent(job.seq, intent)?)
    }

    /// Makes the failed and cancelled runs of a job wait again.
    ///
    /// # Errors
    /// `Ended` when it is done, `NotEnded` while it is not over, `Store`.
    pub fn try_again(&self, job: &JobView) -> Result<(), ControlError> {
        match job.intent.job_state(&job.counts) {
            state @ Life::Done => Err(ControlError::Ended("job", state)),
            state if !state.is_final() => Err(ControlError::NotEnded("job", state)),
            _ => Ok(self.retry(job.seq)?),
        }
    }

    /// Adds runs with so many more seeds to a job, and not again those of its seeds that were deleted.
    /// Returns how many there are.
    ///
    /// # Errors
    /// `JobGone`, `NoDocument`, `Ended` when it is cancelled, `Invalid`, `NoRoom`, `Store`.
    pub fn extend_job(&self, job: &JobView, more: u64) -> Result<u64, ControlError> {
        if job.intent == Intent::Cancelled {
            return Err(ControlError::Ended("job", Life::Cancelled));
        }
        let _changing = self.changing.begin(job.seq);
        let store = &self.shared.store;
        if store.job(job.seq)?.is_none() {
            return Err(ControlError::JobGone(job.seq));
        }
        let text = store.document(job.seq)?.ok_or(ControlError::NoDocument)?;
        let document = crate::documents::parse(&text).map_err(ControlError::Invalid)?;
        if document.get("fork").is_some() {
            return Err(ControlError::Invalid(vec![FieldError::new(
                "/seeds",
                "the job's run goes on from a state, which has one seed",
                "a job whose runs start at their beginning",
            )]));
        }
        let longer = with_more_seeds(&document, more);
        let arenas = StoredArenas::to_keep(store);
        let all = |document| expand(document, &arenas).map_err(ControlError::Invalid);
        let had: BTreeSet<String> = all(&document)?.runs.iter().map(ResolvedRun::key).collect();
        let request = JobRequest::of_document(longer.to_string().as_bytes(), None);
        let mut longer = self.new_job(all(&longer)?, request)?;
        longer.runs.retain(|run| !had.contains(&run.id));
        let added = store.extend_job(job.seq, &longer, self.shared.config.unfinished_limit)?;
        self.requeue(job.seq)?;
        Ok(added)
    }

    /// Makes a job of one run: a run as another one was, with so many more epochs. Its first epochs
    /// are the other's to the last bit, as a run of fewer epochs is the beginning of one of more.
    /// It goes on from the other's end where that is kept, and is simulated anew where it is not.
    ///
    /// # Errors
    /// `RunGone`, `Invalid`, `NoRoom`, `Store`; `NoCheckpoint` where the other one began with a state of a
    /// third and its end is not kept.
    pub fn extend_run(&self, run: &RunView, more: u32) -> Result<JobKey, ControlError> {
        let store = &self.shared.store;
        let spec = self.spec_text(run)?;
        let mut spec = crate::documents::parse(&spec).map_err(ControlError::Invalid)?;
        let epochs = spec.get("epochs").and_then(Value::as_u64).unwrap_or(0);
        let epochs = epochs.saturating_add(u64::from(more));
        if run.origin.is_some() {
            let changes = [("epochs".to_owned(), Value::from(epochs))].into();
            return self.fork_run(
                run,
                &Fork {
                    epoch: None,
                    changes,
                },
            );
        }
        spec["epochs"] = Value::from(epochs);
        let short: String = run.id.chars().take(12).collect();
        let document = serde_json::json!({
            "name": format!("{short} with {more} more epochs"),
            "base": spec,
        });
        let arenas = StoredArenas::to_keep(store);
        let expanded = expand(&document, &arenas).map_err(ControlError::Invalid)?;
        let request = JobRequest::of_document(document.to_string().as_bytes(), None);
        let runs = expanded.runs.clone();
        let longer = self.new_job(expanded, request)?;
        let goes_on = (runs.iter()).any(|longer| self.go_on_from_the_end(run, longer));
        let (Created::New(job, _) | Created::Replayed(job)) = self.submit(&longer)?;
        if goes_on && let Some(made) = longer.runs.first().map(|run| store.run(&run.id)) {
            let what = format!("goes on from the end of run {}", run.id);
            if let Some(made) = made? {
                store.note(made.seq, &what)?;
            }
        }
        Ok(job)
    }

    /// A job to be stored, unless what its runs are to record of themselves does not fit.
    ///
    /// # Errors
    /// `Invalid`.
    pub fn new_job(&self, job: ExpandedJob, request: JobRequest) -> Result<NewJob, ControlError> {
        let limits = &self.shared.config.recordings;
        new_job(job, request, limits).map_err(ControlError::Invalid)
    }

    /// Changes the priority of a job: its waiting runs come before those of lower priority.
    ///
    /// # Errors
    /// `JobGone`, `Store`.
    pub fn set_priority(&self, job: JobKey, priority: i32) -> Result<(), ControlError> {
        let _changing = self.changing.begin(job);
        if !self.shared.store.set_priority(job, priority)? {
            return Err(ControlError::JobGone(job));
        }
        self.shared.state().queue.set_priority(job, priority);
        Ok(())
    }

    /// Holds one run, in whatever jobs it is; holding it again is no error.
    ///
    /// # Errors
    /// `RunGone`, `Ended`, `Store`.
    pub fn pause_run(&self, run: &RunView) -> Result<(), ControlError> {
        let held = self.shared.store.hold(run.seq, "paused")?;
        match held {
            Some(held) => self.shared.let_go(&[held], false),
            None => self.expect(run, &[Life::Paused])?,
        }
        Ok(())
    }

    /// Lets one run go on that was held; letting it again is no error.
    ///
    /// # Errors
    /// `RunGone`, `Ended`, `NotWanted`, `Store`.
    pub fn resume_run(&self, run: &RunView) -> Result<(), ControlError> {
        self.expect(run, &[Life::Paused, Life::Queued, Life::Running])?;
        self.release(run, None, "resumed")
    }

    /// Lets a run do so many epochs of its arena, then holds it. Epochs of every phase count, and
    /// one that has begun is the first.
    ///
    /// # Errors
    /// `RunGone`, `Running` when it was not held before, `Ended`, `NotWanted`, `Invalid`, `Store`.
    pub fn step_run(&self, run: &RunView, epochs: u32) -> Result<(), ControlError> {
        if run.state.state() == Life::Running {
            return Err(ControlError::Running);
        }
        self.expect(run, &[Life::Paused, Life::Queued])?;
        // Where it stands is known once its worker has let go.
        if !self.shared.wait_for_release(run.seq, LET_GO) {
            return Err(ControlError::Running);
        }
        let store = &self.shared.store;
        let text = self.spec_text(run)?;
        let spec = attempt::stored_spec(store, &text).map_err(ControlError::Invalid)?;
        let spec = spec.run_spec();
        let robot_steps = store.robot_steps_done(run.seq)?.ok_or_else(|| gone(run))?;
        let (robots, steps) = (u64::from(spec.robots), u64::from(spec.steps_per_epoch));
        let begun = robot_steps / robots.max(1) / steps.max(1);
        let until = (begun + u64::from(epochs)).saturating_mul(steps);
        self.release(run, Some(until), &format!("steps {epochs} epochs"))
    }

    /// Makes a failed or cancelled run wait again, from its beginning.
    ///
    /// # Errors
    /// `RunGone`, `Ended` when it is done, `NotEnded`, `NotWanted`, `Store`.
    pub fn retry_run(&self, run: &RunView) -> Result<(), ControlError> {
        match run.state.state() {
            state @ Life::Done => return Err(ControlError::Ended("run", state)),
            state if !state.is_final() => return Err(ControlError::NotEnded("run", state)),
            _ => {}
        }
        if !self.shared.store.retry_run(run.seq)? {
            self.state_of(run)?;
            return Err(ControlError::NotWanted(Life::Cancelled));
        }
        self.requeue_jobs_of(run.seq)
    }

    /// Deletes a run with its result, in every job that has it.
    ///
    /// # Errors
    /// `Store`.
    pub fn delete_run(&self, run: RunKey) -> Result<(), ControlError> {
        let gone = self.shared.store.delete_run(run)?;
        self.shared.let_go(gone.as_slice(), true);
        Ok(())
    }

    pub(super) fn release(
        &self,
        run: &RunView,
        pause_at_step: Option<u64>,
        why: &str,
    ) -> Result<(), ControlError> {
        let waits = self.shared.store.release(run.seq, pause_at_step, why)?;
        if !waits.ok_or_else(|| gone(run))? {
            // It runs already, unless its jobs hold it.
            return match self.state_of(run)? {
                Life::Running => Ok(()),
                Life::Paused => Err(ControlError::NotWanted(Life::Paused)),
                state => Err(ControlError::Ended("run", state)),
            };
        }
        self.requeue_jobs_of(run.seq)
    }

    fn requeue_jobs_of(&self, run: RunKey) -> Result<(), ControlError> {
        for job in self.shared.store.jobs_of(run)? {
            let _changing = self.changing.begin(job);
            self.requeue(job)?;
        }
        Ok(())
    }

    /// Queues what waits of a job that nobody else changes, if it is active.
    fn requeue(&self, job: JobKey) -> Result<(), ControlError> {
        let store = &self.shared.store;
        let active = (store.job(job)?).is_some_and(|job| job.intent == Intent::Active);
        if active {
            let waiting = store.waiting(job)?;
            self.shared.state().queue.set(job, waiting);
            self.shared.changed.notify_all();
        }
        Ok(())
    }

    fn expect(&self, run: &RunView, states: &[Life]) -> Result<(), ControlError> {
        let state = self.state_of(run)?;
        if states.contains(&state) {
            Ok(())
        } else {
            Err(ControlError::Ended("run", state))
        }
    }

    fn state_of(&self, run: &RunView) -> Result<Life, ControlError> {
        let now = self.shared.store.run(&run.id)?;
        Ok(now.ok_or_else(|| gone(run))?.state.state())
    }

    /// The resolved spec of a run, as JSON.
    pub(super) fn spec_text(&self, run: &RunView) -> Result<String, ControlError> {
        let text = self.shared.store.spec(run.seq)?;
        text.ok_or_else(|| gone(run))
    }
}

/// It was there when it was asked for.
pub(super) fn gone(run: &RunView) -> ControlError {
    ControlError::RunGone(run.id.clone())
}

impl super::Shared {
    /// Waits until no worker holds a run. Returns whether none does.
    fn wait_for_release(&self, run: RunKey, longest: Duration) -> bool {
        let until = Instant::now() + longest;
        let mut state = self.state();
        while state.live.contains_key(&run) {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            state = self
                .changed
                .wait_timeout(state, left)
                .unwrap_or_else(std::sync::PoisonError::into_inner)
                .0;
        }
        true
    }
}
