//! A run's files at this moment, and what they are made of.

use std::sync::Arc;

use arenas::Arena;
use bytes::Bytes;
use sha2::{Digest, Sha256};
use swarm::kept::reachable_from;

use super::{Assembler, FindingsError};
use crate::artifacts::{Maker, Material, RunFile};
use crate::documents::{ResolvedRun, complete, resolve_stored};
use crate::scheduler::{StoredArenas, View};
use crate::store::{Findings, RunState, RunView};
use crate::turns::{LARGE_TEXT_BYTES, Turn};

/// What was found in an arena of more squares than this is much to read: 16 bytes a square.
const MANY_SQUARES: u32 = 100_000;

/// A file at one moment.
#[derive(Debug)]
pub struct FileAnswer {
    /// Names the bytes: equal tags, equal bytes.
    pub tag: String,
    /// The bytes; `None` when whoever asked has them.
    pub body: Option<Bytes>,
}

impl Assembler {
    /// A file of a run that is made of its findings. `is_known` tells whether the bytes of a tag
    /// need not be sent; `curve_points` is the most rows that a curve may have.
    ///
    /// # Errors
    /// When the findings went with the run, or cannot be read.
    pub fn file(
        &self,
        run: &RunView,
        file: &RunFile,
        curve_points: Option<usize>,
        is_known: impl Fn(&str) -> bool,
    ) -> Result<FileAnswer, FindingsError> {
        let live = self
            .scheduler
            .view(run.seq)
            .filter(|_| run.state == RunState::Running);
        let make = || {
            let spec = self.resolved(run)?;
            let _turn = self.turn_for_squares(&spec)?;
            match &live {
                Some(live) => self.make(run, &spec, file, curve_points, &live.findings),
                None => self.make(run, &spec, file, curve_points, &self.stored(run)?),
            }
        };
        let Some(moment) = moment(run, live.as_deref()) else {
            let body = make()?;
            let digest = Sha256::digest(&body);
            let tag = hex::encode(&digest[..16]);
            let body = Some(body).filter(|_| !is_known(&tag));
            return Ok(FileAnswer { tag, body });
        };
        let route = file.route.unwrap_or_default();
        let points = curve_points.map(|points| format!("-{points}"));
        let points = points.unwrap_or_default();
        let tag = format!(
            "{}-{}-{moment}-{route}{points}",
            env!("CARGO_PKG_VERSION"),
            run.id
        );
        if is_known(&tag) {
            return Ok(FileAnswer { tag, body: None });
        }
        let body = match file.is_dear {
            true => self.once(&tag, make)?,
            false => make()?,
        };
        Ok(FileAnswer {
            tag,
            body: Some(body),
        })
    }

    fn make(
        &self,
        run: &RunView,
        spec: &ResolvedRun,
        file: &RunFile,
        curve_points: Option<usize>,
        findings: &Findings,
    ) -> Result<Bytes, FindingsError> {
        let material = Material {
            spec,
            findings,
            reachable: &|| self.mask(spec.arena(), spec.body_radius_m()),
            curve_points,
        };
        match file.maker {
            Maker::Findings(make) => Ok(make(&material).into()),
            Maker::Spec | Maker::Result | Maker::Timing | Maker::Recording => {
                Err(FindingsError::broken(&run.id, "no findings make this file"))
            }
        }
    }

    /// What a run that no worker holds has covered; nothing when it has not started.
    pub(super) fn stored(&self, run: &RunView) -> Result<Findings, FindingsError> {
        if matches!(run.state, RunState::Failed { .. } | RunState::Cancelled) {
            return Err(FindingsError::NotKept(run.state.state()));
        }
        if let RunState::Damaged { reason } = &run.state {
            return Err(FindingsError::broken(&run.id, reason));
        }
        // A run that has ended since it was looked up is found here too.
        if let Some(findings) = self.store.findings(run.seq)? {
            return Ok(findings);
        }
        Ok(self
            .store
            .checkpoints()
            .findings(&run.id)?
            .unwrap_or_default())
    }

    /// The run's spec with every default filled in, as it is stored or, where that is older than a
    /// parameter, with what it meant.
    ///
    /// # Errors
    /// When the run is gone or the store fails.
    pub fn spec_text(&self, run: &RunView) -> Result<String, FindingsError> {
        let text = self.store.spec(run.seq)?;
        let text = text.ok_or_else(|| FindingsError::RunGone(run.id.clone()))?;
        Ok(complete(text, &StoredArenas::new(&self.store)))
    }

    /// Whether the run's spec is so large that what is made of it takes turns.
    ///
    /// # Errors
    /// When the store fails.
    pub fn has_large_spec(&self, run: &RunView) -> Result<bool, FindingsError> {
        Ok(self.store.spec_bytes(run.seq)? > LARGE_TEXT_BYTES as u64)
    }

    /// The run's spec, resolved again.
    ///
    /// # Errors
    /// When the run is gone, or its spec is not valid any more; `Busy` when many large ones are
    /// wanted.
    pub fn resolved(&self, run: &RunView) -> Result<ResolvedRun, FindingsError> {
        let _turn = self.large_specs.take_if(self.has_large_spec(run)?)?;
        self.resolved_at_once(run)
    }

    /// As [`Self::resolved`], without a turn for a large one.
    ///
    /// # Errors
    /// As there.
    pub fn resolved_at_once(&self, run: &RunView) -> Result<ResolvedRun, FindingsError> {
        resolve_stored(&self.spec_text(run)?, &StoredArenas::new(&self.store))
            .map_err(|errors| FindingsError::broken(format!("run {}", run.id), told(&errors)))
    }

    /// A turn to read what a run has found, if its arena has many squares.
    pub(super) fn turn_for_squares(
        &self,
        spec: &ResolvedRun,
    ) -> Result<Option<Turn>, FindingsError> {
        let squares: u32 = spec.arena().squares().iter().product();
        Ok(self.large_findings.take_if(squares > MANY_SQUARES)?)
    }

    /// The same to read what one of these runs after the other has found.
    pub(super) fn turn_for_runs(&self, runs: &[RunView]) -> Result<Option<Turn>, FindingsError> {
        match runs.iter().find(|run| run.result().is_some()) {
            Some(run) => self.turn_for_squares(&self.resolved(run)?),
            None => Ok(None),
        }
    }

    /// The squares that a robot of this radius can reach from the arena's first start.
    pub fn mask(&self, arena: &Arena, body_radius_m: f64) -> Option<Arc<[bool]>> {
        let start = arena.starts().first()?.position();
        let reachable = reachable_from(arena, &[start], body_radius_m);
        Some(reachable.mask.clone().into())
    }
}

fn told(errors: &[api::FieldError]) -> String {
    let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
    errors.join("; ")
}

/// A name for how far the run is, where that decides what it has found: not for one that is let go
/// of, whose checkpoint may be younger or older than its state.
fn moment(run: &RunView, live: Option<&View>) -> Option<String> {
    match (&run.state, live) {
        (RunState::Running, Some(live)) => Some(live.progress.robot_steps_done.to_string()),
        (RunState::Done(_), _) => Some("done".to_owned()),
        _ => None,
    }
}
