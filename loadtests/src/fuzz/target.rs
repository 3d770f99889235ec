//! What reads an input: the functions that the service and the command read it with.

use anyhow::{Result, anyhow};
use clap::ValueEnum;
use serde_json::{Value, json};
use server::documents::{BuiltinArenas, expand, parse, read_arena, resolve, run_count};
use sha2::{Digest, Sha256};
use swarm::ValidSpec;
use swarm::run::Run;

use super::corpus;

/// Steps that a restored run is taken on by.
const STEPS: u64 = 500;
/// A snapshot begins with magic and a digest of the state that follows.
const HEAD_BYTES: usize = 8 + 32;
/// Where it has later metrics, it ends with their digest, their length and magic.
const TAIL_BYTES: usize = 32 + 8 + 8;
const TAIL_MAGIC: &[u8] = b"evsrows1";

/// What is changed at random.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// A job, as posted.
    Job,
    /// A run spec.
    Run,
    /// An arena, as uploaded.
    Arena,
    /// A checkpoint of a run, which is taken up again where it can be.
    Checkpoint,
}

/// A target, and what it begins with.
pub struct Target {
    kind: Kind,
    corpus: Vec<Vec<u8>>,
    /// Of the runs that checkpoints are of.
    specs: Vec<ValidSpec>,
}

impl Target {
    /// The target of this kind.
    ///
    /// # Errors
    /// What it begins with is not right.
    pub fn new(kind: Kind) -> Result<Self> {
        let text = |documents: Vec<Value>| {
            documents
                .iter()
                .map(|document| document.to_string().into_bytes())
                .collect()
        };
        let (corpus, specs) = match kind {
            Kind::Job => (text(corpus::jobs()), Vec::new()),
            Kind::Run => (text(corpus::runs()), Vec::new()),
            Kind::Arena => (text(corpus::arenas()), Vec::new()),
            Kind::Checkpoint => checkpoints()?,
        };
        let target = Self {
            kind,
            corpus,
            specs,
        };
        for input in &target.corpus {
            if !target.read(input) {
                let shown = String::from_utf8_lossy(input);
                return Err(anyhow!(
                    "what the fuzzing begins with is refused: {shown:.500}"
                ));
            }
        }
        Ok(target)
    }

    /// What it begins with.
    pub fn corpus(&self) -> Vec<Vec<u8>> {
        self.corpus.clone()
    }

    /// Whether inputs are JSON.
    pub fn is_text(&self) -> bool {
        self.kind != Kind::Checkpoint
    }

    /// The input with the digests of what it holds, if it is to have them: without, changes of a
    /// checkpoint do not get far.
    pub fn sealed(&self, mut input: Vec<u8>, is_wanted: bool) -> Vec<u8> {
        // The first byte says which spec it is of, the snapshot follows.
        if let (Kind::Checkpoint, true, Some((_, snapshot))) =
            (self.kind, is_wanted, input.split_first_mut())
        {
            seal(snapshot);
        }
        input
    }

    /// Reads an input to its end; tells whether it was right.
    pub fn read(&self, input: &[u8]) -> bool {
        match self.kind {
            Kind::Job => document(input).is_some_and(|job| {
                run_count(&job);
                expand(&job, &BuiltinArenas).is_ok()
            }),
            Kind::Run => document(input).is_some_and(|spec| resolve(&spec, &BuiltinArenas).is_ok()),
            Kind::Arena => document(input).is_some_and(|arena| read_arena(&arena).is_ok()),
            Kind::Checkpoint => self.restore(input),
        }
    }

    fn restore(&self, input: &[u8]) -> bool {
        let Some((which, snapshot)) = input.split_first() else {
            return false;
        };
        let spec = self.specs[usize::from(*which) % self.specs.len()].clone();
        let Ok(mut run) = Run::restore(spec, snapshot) else {
            return false;
        };
        run.advance(STEPS);
        run.snapshot();
        true
    }
}

fn document(input: &[u8]) -> Option<Value> {
    parse(std::str::from_utf8(input).ok()?).ok()
}

/// Puts right digests into a snapshot, as far as it has the form of one.
fn seal(mut snapshot: &mut [u8]) {
    if snapshot.ends_with(TAIL_MAGIC) && snapshot.len() >= TAIL_BYTES {
        let (before, tail) = snapshot.split_at_mut(snapshot.len() - TAIL_BYTES);
        let length = tail[32..]
            .first_chunk()
            .map_or(0, |length| u64::from_le_bytes(*length));
        let columns = usize::try_from(length).ok();
        let Some(state) = columns.and_then(|columns| before.len().checked_sub(columns)) else {
            return;
        };
        let (state, columns) = before.split_at_mut(state);
        tail[..32].copy_from_slice(&Sha256::digest(columns));
        snapshot = state;
    }
    if snapshot.len() >= HEAD_BYTES {
        let (head, state) = snapshot.split_at_mut(HEAD_BYTES);
        head[HEAD_BYTES - 32..].copy_from_slice(&Sha256::digest(state));
    }
}

/// Snapshots of runs on the way, in every stage, and their specs.
fn checkpoints() -> Result<(Vec<Vec<u8>>, Vec<ValidSpec>)> {
    let small = |controller: Value, more: Value| {
        let mut spec = json!({
            "arena": "easy", "controller": controller, "epochs": 3, "steps_per_epoch": 100, "robots": 2,
            "placement": "grid",
        });
        for (name, value) in more.as_object().into_iter().flatten() {
            spec[name] = value.clone();
        }
        spec
    };
    let train = json!({ "arena": "easy", "epochs": 3 });
    let specs = [
        small(json!({ "method": "brownian" }), json!({})),
        small(json!({ "method": "levy" }), json!({ "robots": 1 })),
        small(
            json!({ "method": "im", "babbling_epochs": 1 }),
            json!({ "sharing": { "mode": "radio" } }),
        ),
        small(
            json!({ "method": "im", "babbling_epochs": 1 }),
            json!({ "sharing": { "mode": "arena" } }),
        ),
        small(json!({ "method": "ev-iter-c", "train": train }), json!({})),
        small(
            json!({ "method": "curiosity-a", "train": train }),
            json!({ "engine": "rapier" }),
        ),
    ];
    let (mut snapshots, mut valid) = (Vec::new(), Vec::new());
    for (number, spec) in (0_u8..).zip(specs) {
        let spec =
            resolve(&spec, &BuiltinArenas).map_err(|errors| anyhow!("{spec}: {errors:?}"))?;
        let spec = spec.run_spec();
        let mut run = Run::new(spec.clone()).map_err(|errors| anyhow!("{errors:?}"))?;
        while run.outcome().is_none() {
            run.advance(130);
            let mut input = vec![number];
            input.extend(run.snapshot());
            snapshots.push(input);
        }
        valid.push(spec);
    }
    Ok((snapshots, valid))
}
