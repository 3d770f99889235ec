//! A run that can be started: the domain's spec, the document that shows it, and its key.

use std::sync::Arc;

use arenas::Arena;
use sha2::{Digest, Sha256};
use swarm::spec::{EngineKind, Method, RunSpec};
use swarm::{RESULTS_VERSION, ValidSpec};

use super::controller;
use super::method_parameters::has_parameter;
use super::record::RecordRequest;

/// A checked run spec with every default filled in. Cheap to clone: runs of a job that differ in
/// their seed alone share everything else.
#[derive(Clone, Debug)]
pub struct ResolvedRun {
    seed: u64,
    common: Arc<Common>,
}

/// What does not depend on the seed; the seeds in here are not used.
#[derive(Debug)]
struct Common {
    digest: [u8; 32],
    essence: [u8; 32],
    run: ValidSpec,
    shown: api::RunSpec,
    /// The canonical text, but for the line with the seed.
    text: String,
    beside: Beside,
}

/// What is looked at of a run, which changes nothing of what it comes to.
#[derive(Clone, Debug, Default)]
pub struct Beside {
    /// What is recorded.
    pub record: Option<RecordRequest>,
    /// Whether local programs can watch it through shared memory.
    pub channels: bool,
}

impl ResolvedRun {
    pub(super) fn new(run: ValidSpec, mut shown: api::RunSpec, beside: Beside) -> Self {
        let seed = run.seed;
        shown.seed = None;
        let text = text(&shown);
        let digest = digest(&run, &text);
        let essence = essence(&run, &shown).unwrap_or(digest);
        Self {
            seed,
            common: Arc::new(Common {
                digest,
                essence,
                run,
                shown,
                text,
                beside,
            }),
        }
    }

    /// SHA-256 over all but the seed and the parameters that the method does not have: runs that are
    /// alike in this come to the same with the same seed.
    pub(super) fn essence(&self) -> [u8; 32] {
        self.common.essence
    }

    /// The same run with another seed.
    #[must_use]
    pub(super) fn with_seed(&self, seed: u64) -> Self {
        Self {
            seed,
            common: Arc::clone(&self.common),
        }
    }

    /// The seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// What the simulation runs, with a seed that is not to be used.
    pub(super) fn common_spec(&self) -> &RunSpec {
        &self.common.run
    }

    /// The same, of which it is known that it can be run.
    pub(super) fn common_valid_spec(&self) -> &ValidSpec {
        &self.common.run
    }

    /// Counted epochs.
    pub fn epochs(&self) -> u32 {
        self.common.run.epochs
    }

    /// Robot-steps in all, as far as that is known before the run starts.
    pub fn robot_steps(&self) -> u64 {
        self.common.run.robot_steps()
    }

    /// What the simulation runs.
    pub fn run_spec(&self) -> ValidSpec {
        self.common.run.clone().with_seed(self.seed)
    }

    /// The target arena.
    pub fn arena(&self) -> &Arc<Arena> {
        &self.common.run.arena
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.common.run.controller.method
    }

    /// The physics.
    pub fn engine(&self) -> EngineKind {
        self.common.run.engine
    }

    /// Radius of the robot, which decides what it can reach.
    pub fn body_radius_m(&self) -> f64 {
        self.common.run.robot.parameters.body_radius_m
    }

    /// Length of a control step, seconds.
    pub fn step_s(&self) -> f64 {
        self.common.run.robot.parameters.step_s
    }

    /// Whether local programs can watch the run through shared memory.
    pub fn channels(&self) -> bool {
        self.common.beside.channels
    }

    /// What is recorded of the run.
    pub fn record(&self) -> Option<&RecordRequest> {
        self.common.beside.record.as_ref()
    }

    /// The same run without anything recorded or shown: what a recording is of.
    #[must_use]
    pub fn unrecorded(&self) -> Self {
        let mut shown = self.common.shown.clone();
        shown.record = Some(RecordRequest::shown(None));
        shown.channels = Some(false);
        Self::new(self.run_spec(), shown, Beside::default())
    }

    /// The spec with every field present but the seed.
    pub fn shown(&self) -> &api::RunSpec {
        &self.common.shown
    }

    /// The spec with every field present. Resolving it again gives an equal run.
    pub fn canonical(&self) -> api::RunSpec {
        api::RunSpec {
            seed: Some(self.seed),
            ..self.common.shown.clone()
        }
    }

    /// [`Self::canonical`] as the text of `spec.json`: equal runs give equal text.
    pub fn canonical_json(&self) -> String {
        // The seed is the second field: it follows the brace and the line with `schema`.
        let text = &self.common.text;
        let place = text
            .match_indices('\n')
            .nth(1)
            .map_or(0, |(end, _)| end + 1);
        let (before, after) = text.split_at(place);
        format!("{before}  \"seed\": {},\n{after}", self.seed)
    }

    /// The run's id: SHA-256, in hex, over the seed and the SHA-256 of the rest of the canonical
    /// spec, the contents of its arenas and the version of results. Equal keys mean equal results.
    pub fn key(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(self.common.digest);
        hash.update(self.seed.to_le_bytes());
        hex::encode(hash.finalize())
    }
}

fn text(spec: &api::RunSpec) -> String {
    #[allow(
        clippy::expect_used,
        reason = "strings, finite numbers and maps with string keys: JSON can hold all of them"
    )]
    let mut text = serde_json::to_string_pretty(spec).expect("a spec is JSON");
    text.push('\n');
    text
}

/// The digest with every parameter that the method does not have at its default; `None` where they
/// are.
fn essence(run: &RunSpec, shown: &api::RunSpec) -> Option<[u8; 32]> {
    let states_from = run.controller.parameters.states_from;
    let given = &shown.controller.as_ref()?.parameters;
    let mut plain = given.clone();
    for (name, value) in controller::defaults() {
        if !has_parameter(run.controller.method, states_from, &name) {
            plain.insert(name, value);
        }
    }
    if plain == *given {
        return None;
    }
    let mut shown = shown.clone();
    shown.controller.as_mut()?.parameters = plain;
    Some(digest(run, &text(&shown)))
}

/// SHA-256 over the version of results, the text of a spec and the contents of its arenas.
fn digest(run: &RunSpec, text: &str) -> [u8; 32] {
    let training = run.controller.training.as_ref();
    let parts = [
        RESULTS_VERSION.to_le_bytes().to_vec(),
        text.as_bytes().to_vec(),
        run.arena.content_key(),
        training
            .map(|training| training.arena.content_key())
            .unwrap_or_default(),
    ];
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().into()
}
