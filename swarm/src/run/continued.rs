//! Runs that go on from the state of another: one with more epochs of the same, and one with other
//! parameters.

use super::machine::Run;
use super::metrics::has_row;
use super::outcome::RestoreError;
use super::snapshot::{digest, restore_of, too_few_epochs};
use crate::spec::{ControllerParameters, RunSpec};
use crate::validate::ValidSpec;

/// Fields of a run spec that may be others when a run goes on from a state: those that no part of
/// the state was made with, or whose part is made anew from what was learnt.
pub const CHANGEABLE: &[&str] = &[
    "epochs",
    "controller.alpha",
    "controller.eta",
    "controller.lambda_total",
    "controller.insufficiency",
    "controller.ties",
    "controller.action_hold_steps",
];

impl Run {
    /// A run of more epochs that goes on from the end of one of fewer, to the same bits as one that
    /// was simulated from its beginning. `shorter` is what `bytes` are the snapshot of; the longer
    /// one differs from it in its epochs alone.
    ///
    /// # Errors
    /// When the bytes are damaged, of another spec, not of the end, or do not tell what the longer
    /// run would have kept.
    pub fn extended(
        shorter: &RunSpec,
        spec: ValidSpec,
        bytes: &[u8],
    ) -> Result<Self, RestoreError> {
        let cannot = |why: &str| RestoreError::CannotGoOn(why.to_owned());
        let same = RunSpec {
            epochs: spec.epochs,
            ..shorter.clone()
        };
        if digest(&same) != digest(&spec) || spec.epochs <= shorter.epochs {
            return Err(cannot("the longer run differs in more than its epochs"));
        }
        let mut run = restore_of(spec, digest(shorter), bytes)?;
        if run.stage().is_some() {
            return Err(cannot("the shorter run has not ended"));
        }
        run.go_on(shorter.epochs)?;
        Ok(run)
    }

    /// A run that goes on from the state of another with what [`CHANGEABLE`] lists changed. What the
    /// other had found till then is part of what it finds.
    ///
    /// # Errors
    /// When the bytes are damaged, of another spec, or the new spec differs in other fields or has
    /// too few epochs.
    pub fn forked(origin: &RunSpec, spec: ValidSpec, bytes: &[u8]) -> Result<Self, RestoreError> {
        let cannot = |why: &str| RestoreError::CannotGoOn(why.to_owned());
        if digest(&with_changes(origin, &spec)) != digest(&spec) {
            return Err(cannot("the specs differ in what a fork cannot change"));
        }
        let mut run = restore_of(spec, digest(origin), bytes)?;
        let done = run.curve().len() as u32;
        if run.stage().is_none() && run.spec.epochs <= done {
            return Err(too_few_epochs(done));
        }
        if run.stage().is_none() {
            run.go_on(origin.epochs)?;
        }
        let parameters = run.memory.applied_to(&run.spec.controller.parameters);
        run.learners.retune(&parameters);
        Ok(run)
    }

    /// Takes up a run that has ended, as if its last epoch had not been the last.
    fn go_on(&mut self, ended_after: u32) -> Result<(), RestoreError> {
        let last = self.stages.len() - 1;
        let stage = self.stages[last];
        if !stage.counts() || self.curve.len() as u32 != ended_after || ended_after >= stage.epochs
        {
            let why = "its state is not that of the end of its last stage".to_owned();
            return Err(RestoreError::CannotGoOn(why));
        }
        if !has_row(ended_after, stage.epochs) {
            // The last epoch has a row in any case, others only now and then.
            if !self.spec.arena.objects().is_empty() {
                let why = "what was kept of its objects cannot be taken back".to_owned();
                return Err(RestoreError::CannotGoOn(why));
            }
            self.metrics.pop();
        }
        self.position.stage = last as u32;
        self.position.epoch = ended_after;
        self.resume_counting();
        self.begin_epoch();
        Ok(())
    }
}

/// A spec with the changeable fields of another.
fn with_changes(origin: &RunSpec, from: &RunSpec) -> RunSpec {
    let ControllerParameters {
        alpha,
        eta,
        lambda_total,
        insufficiency,
        ties,
        action_hold_steps,
        ..
    } = from.controller.parameters;
    let mut spec = origin.clone();
    spec.epochs = from.epochs;
    spec.controller.parameters = ControllerParameters {
        alpha,
        eta,
        lambda_total,
        insufficiency,
        ties,
        action_hold_steps,
        ..spec.controller.parameters
    };
    spec
}
