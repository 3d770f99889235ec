//! A run as bytes, at any step: everything that is not derived from the spec.
//!
//! Layout: the state, which is magic and version, SHA-256 of the rest, then `postcard`; behind it
//! metrics that came later (`saved_rows.rs`), which are no part of the state's digest.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::coverage::CurveRow;
use super::learners::Learners;
use super::machine::Run;
use super::metrics::MetricsRow;
use super::outcome::RestoreError;
use super::position::RunPosition;
use super::saved_rows::{Later, later};
use super::tracks::Tracks;
use crate::engine::EngineState;
use crate::robot::RobotModel;
use crate::saved_bytes;
use crate::spec::{ControllerSpec, FieldError, RadioLink, RunSpec, Sharing, Training};
use crate::validate::ValidSpec;
use crate::world::{World, WorldState};

/// Changes whenever the layout of saved state does.
const MAGIC: &[u8; 8] = b"evswarm4";
/// Of SHA-256.
const HASH_BYTES: usize = 32;

#[derive(Serialize)]
struct SavedRef<'a> {
    spec: [u8; 32],
    position: RunPosition,
    sensori_motor_clusters: u32,
    curve: &'a [CurveRow],
    metrics: &'a [MetricsRow],
    tracks: &'a Tracks,
    learners: &'a Learners,
    worlds: Vec<(&'a WorldState, &'a EngineState)>,
}

#[derive(Deserialize)]
struct Saved {
    spec: [u8; 32],
    position: RunPosition,
    sensori_motor_clusters: u32,
    curve: Vec<CurveRow>,
    metrics: Vec<MetricsRow>,
    tracks: Tracks,
    learners: Learners,
    worlds: Vec<(WorldState, EngineState)>,
}

/// Tells specs apart: two that would run differently have different digests.
///
/// The spec is taken apart without `..`: a field that is added does not compile until it is thought
/// of here. What only some specs have (as a method's own parameters) is a further part for those,
/// so that the digests of all others, and with them their snapshots, stay what they are.
pub(super) fn digest(spec: &RunSpec) -> [u8; 32] {
    let RunSpec {
        seed,
        arena,
        controller,
        epochs,
        steps_per_epoch,
        robots,
        placement,
        episodes,
        robot,
        engine,
        memory_budget_bytes,
        sharing,
    } = spec;
    let ControllerSpec {
        method,
        parameters,
        own,
        training,
    } = controller;
    let (training_arena, training_epochs) = match training {
        Some(Training { arena, epochs }) => (arena.content_key(), Some(epochs)),
        None => (Vec::new(), None),
    };
    // These are told whole below.
    let RobotModel {
        preset: _,
        parameters: _,
        mounts: _,
        response: _,
    } = robot;
    match sharing {
        Sharing::None | Sharing::Arena => {}
        Sharing::Radio(RadioLink {
            range_m: _,
            bytes_per_step: _,
        }) => {}
    }
    // Debug of numbers is exact (shortest digits that read back equal).
    let figures = format!(
        "{:?}",
        (
            seed,
            method,
            parameters,
            training_epochs,
            (epochs, steps_per_epoch, robots),
            (placement, episodes, engine),
            (memory_budget_bytes, sharing),
            robot,
        )
    );
    // Only methods that have parameters of their own have a part for them.
    let own = Some(own.shown()).filter(|own| !own.is_empty());
    let own = own.map(|own| format!("{own:?}").into_bytes());
    let parts = [arena.content_key(), training_arena, figures.into_bytes()];
    let mut hash = Sha256::new();
    for part in parts.into_iter().chain(own) {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().into()
}

impl Run {
    /// A run that goes on from [`Run::snapshot`], to the same bits as one never interrupted.
    ///
    /// # Errors
    /// When the bytes are damaged, of another version or of another spec.
    pub fn restore(spec: ValidSpec, bytes: &[u8]) -> Result<Self, RestoreError> {
        let of = digest(&spec);
        restore_of(spec, of, bytes)
    }

    /// Everything needed to go on, at any step, in the middle of an epoch too. Same state, same
    /// bytes.
    pub fn snapshot(&self) -> Vec<u8> {
        self.snapshot_of(self.state())
    }

    /// The snapshot that has this state.
    pub(super) fn snapshot_of(&self, mut state: Vec<u8>) -> Vec<u8> {
        state.extend_from_slice(&later(&self.metrics));
        state
    }

    /// The saved state.
    pub(super) fn state(&self) -> Vec<u8> {
        let saved = SavedRef {
            spec: digest(&self.spec),
            position: self.position,
            sensori_motor_clusters: self.sensori_motor_clusters,
            curve: &self.curve,
            metrics: &self.metrics,
            tracks: &self.tracks,
            learners: &self.learners,
            worlds: self
                .venues
                .iter()
                .map(|v| (v.world.state(), v.world.engine()))
                .collect(),
        };
        let mut bytes = [&MAGIC[..], &[0; HASH_BYTES]].concat();
        bytes = saved_bytes::append(bytes, &saved);
        let (head, state) = bytes.split_at_mut(MAGIC.len() + HASH_BYTES);
        head[MAGIC.len()..].copy_from_slice(&Sha256::digest(state));
        bytes
    }
}

/// Of a spec that ends before a state with so many counted epochs.
pub(super) fn too_few_epochs(done: u32) -> RestoreError {
    RestoreError::Spec(vec![FieldError {
        pointer: "/epochs".to_owned(),
        message: format!("the state that it goes on from has {done} counted epochs"),
        allowed: "more epochs than that".to_owned(),
    }])
}

/// A run that goes on from saved state; `of` is the digest of the spec that it was saved with.
pub(super) fn restore_of(spec: ValidSpec, of: [u8; 32], bytes: &[u8]) -> Result<Run, RestoreError> {
    let unreadable = |why: &str| RestoreError::Unreadable(why.into());
    let damaged = || unreadable("its checksum does not match");
    let (state, later) = Later::split(bytes).ok_or_else(damaged)?;
    let rest = state
        .strip_prefix(MAGIC)
        .ok_or_else(|| unreadable("not of this version"))?;
    let (hash, state) = rest
        .split_at_checked(HASH_BYTES)
        .ok_or_else(|| unreadable("cut short"))?;
    if Sha256::digest(state)[..] != *hash {
        return Err(damaged());
    }
    let saved: Saved = postcard::from_bytes(state).map_err(|e| unreadable(&e.to_string()))?;
    if saved.spec != of {
        return Err(RestoreError::OtherSpec);
    }
    let mut run = Run::new(spec).map_err(RestoreError::Spec)?;
    let done = saved.curve.len() as u32;
    if run.spec.epochs < done {
        return Err(too_few_epochs(done));
    }
    let misfit = || unreadable("its parts do not fit the spec");
    // After the last stage its learners stay.
    let last = run.stages.len() - 1;
    let stage = &run.stages[(saved.position.stage as usize).min(last)];
    let fits = saved.worlds.len() == run.venues.len()
        && saved.position.stage as usize <= run.stages.len()
        && saved.position.epoch <= stage.epochs
        && saved.position.step <= run.spec.steps_per_epoch
        && (stage.shows || !saved.position.showing)
        && saved.learners.suit(stage, &run.spec, &run.memory);
    if !fits {
        return Err(misfit());
    }
    run.position = saved.position;
    run.sensori_motor_clusters = saved.sensori_motor_clusters;
    run.curve = saved.curve;
    run.metrics = saved.metrics;
    later.add_to(&mut run.metrics).ok_or_else(misfit)?;
    run.tracks = saved.tracks;
    run.learners = saved.learners;
    run.learners.set_up(&run.spec.controller.parameters);
    for (venue, (state, engine)) in run.venues.iter_mut().zip(saved.worlds) {
        venue.world = World::restore(
            &venue.ground,
            &run.spec.robot,
            state,
            engine,
            venue.starts.clone(),
            run.spec.seed,
            venue.site,
        )
        .ok_or_else(misfit)?;
    }
    run.resume_counting();
    Ok(run)
}
