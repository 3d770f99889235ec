//! Runs that go on from a state: of a shorter run at its end, of another run with other parameters,
//! or one that was uploaded.

use std::sync::Arc;
use std::time::{Duration, Instant};

use api::{CheckpointInfo, FieldError, Fork, RunOrigin, State as Life, WaitsFor};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use swarm::run::{CHANGEABLE, RestoreError, Run};

use super::Scheduler;
use super::arenas::StoredArenas;
use super::attempt::{checkpoint_of, stored_spec};
use super::control::gone;
use super::control_error::ControlError;
use super::live::findings_of;
use crate::documents::{Design, ExpandedJob, ResolvedRun, parse, resolve};
use crate::store::{Checkpoint, Checkpoints, Created, JobKey, JobRequest, RunView, StoreError};

/// Longest wait for a checkpoint of a run that is being stepped.
const TAKING: Duration = Duration::from_secs(30);
/// Time between two looks whether it is there.
const LOOK: Duration = Duration::from_millis(10);
/// Fields that may be changed although no run's state knows them.
const SHOWN_ALONE: &[&str] = &["channels"];

impl Scheduler {
    /// Takes a checkpoint of a run that is being stepped, now; of others tells what is kept.
    ///
    /// # Errors
    /// `NoCheckpoint` when nothing is kept, `Store`, `Checkpoint`.
    pub fn take_checkpoint(&self, run: &RunView) -> Result<CheckpointInfo, ControlError> {
        let checkpoint = self.newest_checkpoint(run)?;
        Ok(CheckpointInfo {
            run: run.id.clone(),
            checkpoint_sha256: sha256(&checkpoint.snapshot),
            bytes: checkpoint.snapshot.len() as u64,
            epochs_done: checkpoint.findings.curve.len() as u32,
        })
    }

    /// Makes a job of one run that goes on from another's newest state, with what is changed.
    ///
    /// # Errors
    /// `NoCheckpoint`, `Invalid` with a pointer into what was posted, `NoRoom`, `Store`,
    /// `Checkpoint`.
    pub fn fork_run(&self, run: &RunView, fork: &Fork) -> Result<JobKey, ControlError> {
        let (document, resolved) = self.changed(run, fork)?;
        let checkpoint = self.newest_checkpoint(run)?;
        let stands = checkpoint.findings.curve.len() as u32;
        if let Some(epoch) = fork.epoch.filter(|epoch| *epoch != stands) {
            return Err(ControlError::Invalid(vec![FieldError::new(
                "/epoch",
                format!("the newest state has {stands} counted epochs, not {epoch}"),
                "that number, or none: a run is brought to another epoch by pause and step",
            )]));
        }
        let origin_spec = self.resolved(run)?;
        let begun = restored(|| {
            Run::forked(
                &origin_spec.run_spec(),
                resolved.run_spec(),
                &checkpoint.snapshot,
            )
        })
        .map_err(|error| match error {
            RestoreError::Spec(errors) => ControlError::Invalid(
                errors
                    .into_iter()
                    .map(|error| {
                        let pointer = format!("/changes{}", error.pointer);
                        FieldError::new(pointer, error.message, error.allowed)
                    })
                    .collect(),
            ),
            error => unusable(&error),
        })?;
        self.begin_elsewhere(run, &begun, &checkpoint, &resolved, &document, false)
    }

    /// Makes a job of one run that goes on from a state of this run that was made elsewhere.
    ///
    /// # Errors
    /// `Invalid` when it is no state of this run, `NoRoom`, `Store`.
    pub fn upload_checkpoint(&self, run: &RunView, bytes: &[u8]) -> Result<JobKey, ControlError> {
        let checkpoint = Checkpoints::parse(&run.id, bytes).map_err(|error| unusable(&error))?;
        let resolved = self.resolved(run)?;
        let begun = restored(|| Run::restore(resolved.run_spec(), &checkpoint.snapshot));
        let begun = begun.map_err(|error| unusable(&error))?;
        let findings = findings_of(&begun);
        if findings != checkpoint.findings {
            let why = "what it says of its findings is not what its state has";
            return Err(unusable(&why));
        }
        let document = serde_json::to_value(resolved.canonical()).unwrap_or_default();
        self.begin_elsewhere(run, &begun, &checkpoint, &resolved, &document, true)
    }

    /// Puts the state of the end of a run where a longer one goes on from, if that state is kept and
    /// the longer one is new.
    pub(super) fn go_on_from_the_end(&self, shorter: &RunView, longer: &ResolvedRun) -> bool {
        let store = &self.shared.store;
        let id = longer.key();
        if shorter.origin.is_some() || !matches!(store.run(&id), Ok(None)) {
            return false;
        }
        let gone_on = || -> Option<()> {
            let last = store.finals().read(&shorter.id).ok()??;
            let spec = self.resolved(shorter).ok()?;
            let run =
                restored(|| Run::extended(&spec.run_spec(), longer.run_spec(), &last.snapshot));
            let run = run
                .inspect_err(|error| tracing::debug!(run = shorter.id, %error, "simulating anew"))
                .ok()?;
            let written = store.checkpoints().write(&id, &checkpoint_of(&run));
            written
                .inspect_err(|error| tracing::warn!(run = id, %error, "simulating anew"))
                .ok()
        };
        gone_on().is_some()
    }

    /// Stores the state that a run begins with, then the job.
    fn begin_elsewhere(
        &self,
        from: &RunView,
        begun: &Run,
        checkpoint: &Checkpoint,
        resolved: &ResolvedRun,
        spec: &Value,
        uploaded: bool,
    ) -> Result<JobKey, ControlError> {
        let store = &self.shared.store;
        let origin = RunOrigin {
            run: from.id.clone(),
            checkpoint_sha256: sha256(&checkpoint.snapshot),
            epochs_done: begun.curve().len() as u32,
            robot_steps_done: begun.progress().robot_steps_done,
            uploaded,
        };
        let id = sha256(format!("{} from {}", resolved.key(), origin.checkpoint_sha256).as_bytes());
        let short: String = from.id.chars().take(12).collect();
        let after = origin.epochs_done;
        let document = json!({
            "name": format!("{short} forked after {after} epochs"),
            "fork": origin,
            "base": spec,
        });
        let request = JobRequest::of_document(document.to_string().as_bytes(), None);
        let expanded = ExpandedJob {
            name: document["name"].as_str().unwrap_or_default().to_owned(),
            runs: vec![resolved.clone()],
            labels: vec![String::new()],
            designs: vec![Design {
                seeds: 1,
                ..Design::default()
            }],
        };
        let mut job = self.new_job(expanded, request)?;
        for run in &mut job.runs {
            run.id.clone_from(&id);
            // Strings and numbers: JSON can hold all of them.
            run.origin = serde_json::to_string(&origin).ok();
        }
        store.origins().write(&id, &checkpoint_of(begun))?;
        let created = self.submit(&job)?;
        let (Created::New(key, _) | Created::Replayed(key)) = created;
        if let Some(run) = store.run(&id)? {
            let sha = &origin.checkpoint_sha256;
            let how = if uploaded { "an uploaded" } else { "the" };
            let what = format!(
                "goes on from {how} state {sha} of run {}, after {after} epochs",
                from.id
            );
            store.note(run.seq, &what)?;
        }
        Ok(key)
    }

    /// The spec of a run with what is changed, as a document and checked.
    fn changed(&self, run: &RunView, fork: &Fork) -> Result<(Value, ResolvedRun), ControlError> {
        let store = &self.shared.store;
        let text = self.spec_text(run)?;
        let mut spec = parse(&text).map_err(ControlError::Invalid)?;
        let mut errors = Vec::new();
        for (path, value) in &fork.changes {
            let pointer = format!("/{}", path.replace('.', "/"));
            let may = CHANGEABLE.contains(&path.as_str()) || SHOWN_ALONE.contains(&path.as_str());
            match spec.pointer_mut(&pointer).filter(|_| may) {
                Some(place) => *place = value.clone(),
                None => errors.push(FieldError::new(
                    format!("/changes/{path}"),
                    "cannot be changed without a new world or new learners",
                    [CHANGEABLE, SHOWN_ALONE].concat().join(", "),
                )),
            }
        }
        if !errors.is_empty() {
            return Err(ControlError::Invalid(errors));
        }
        let resolved = resolve(&spec, &StoredArenas::new(store)).map_err(|errors| {
            let dotted = |pointer: &str| pointer.trim_start_matches('/').replace('/', ".");
            let moved = errors.into_iter().map(|error| {
                let pointer = format!("/changes/{}", dotted(&error.pointer));
                FieldError::new(pointer, error.message, error.allowed)
            });
            ControlError::Invalid(moved.collect())
        })?;
        Ok((spec, resolved))
    }

    fn resolved(&self, run: &RunView) -> Result<ResolvedRun, ControlError> {
        let store = &self.shared.store;
        let text = self.spec_text(run)?;
        stored_spec(store, &text).map_err(ControlError::Invalid)
    }

    /// The newest state of a run: taken now where a worker holds it.
    fn newest_checkpoint(&self, run: &RunView) -> Result<Checkpoint, ControlError> {
        let store = &self.shared.store;
        let live = self.shared.state().live.get(&run.seq).cloned();
        if let Some(live) = live {
            let before = live.saves().written();
            live.saves().ask();
            let until = Instant::now() + TAKING;
            // It may also be let go of meanwhile, which leaves a checkpoint too.
            let is_stuck = || matches!(live.waiting(), Some((WaitsFor::Store, _)));
            while live.saves().written() == before
                && self.is_held(run, &live)
                && !is_stuck()
                && Instant::now() < until
            {
                std::thread::sleep(LOOK);
            }
            if live.saves().written() != before
                && let Some(error) = live.saves().take_failure()
            {
                return Err(error.into());
            }
            if self.is_held(run, &live) && is_stuck() {
                let why = "the end of the run cannot be stored either".to_owned();
                return Err(StoreError::Full(why).into());
            }
        }
        if let Some(checkpoint) = store.checkpoints().read(&run.id)? {
            return Ok(checkpoint);
        }
        if let Some(checkpoint) = store.finals().read(&run.id)? {
            return Ok(checkpoint);
        }
        let now = store.run(&run.id)?;
        let state = now.ok_or_else(|| gone(run))?.state.state();
        // A fork that has not begun stands where it begins.
        match state {
            Life::Queued | Life::Paused | Life::Running => {
                let origin = store.origins().read(&run.id)?;
                origin.ok_or(ControlError::NoCheckpoint(state))
            }
            state => Err(ControlError::NoCheckpoint(state)),
        }
    }

    fn is_held(&self, run: &RunView, live: &Arc<super::live::LiveRun>) -> bool {
        let state = self.shared.state();
        let held = state.live.get(&run.seq);
        held.is_some_and(|held| Arc::ptr_eq(held, live))
    }
}

/// A state with a digest of its own may still be one that no program wrote.
fn restored(restore: impl FnOnce() -> Result<Run, RestoreError>) -> Result<Run, RestoreError> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(restore))
        .unwrap_or_else(|_| Err(RestoreError::Unreadable("its parts do not fit".to_owned())))
}

fn unusable(why: &dyn std::fmt::Display) -> ControlError {
    ControlError::Invalid(vec![FieldError::new(
        "",
        format!("the checkpoint cannot be used: {why}"),
        "a checkpoint of this run, as GET gives it, of this version of results",
    )])
}

fn sha256(bytes: &[u8]) -> String {
    hex::encode(Sha256::digest(bytes))
}
