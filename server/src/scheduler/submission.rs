//! From an expanded job to what the store keeps of it.

use api::ArenaRef;
use sha2::{Digest, Sha256};

use crate::spec::{ArenaSource, BuiltinArenas, ExpandedJob, ResolvedRun};
use crate::store::{NewJob, NewRun};

/// The job with its runs; `body` is the request that it came in.
pub fn new_job(job: ExpandedJob, body: &[u8], idempotency_key: Option<String>) -> NewJob {
    let digest = Sha256::digest(body);
    NewJob {
        runs: job.runs.iter().map(new_run).collect(),
        name: job.name,
        request_sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
        idempotency_key,
    }
}

fn new_run(run: &ResolvedRun) -> NewRun {
    let spec = run.run_spec();
    NewRun {
        id: run.key(),
        spec: run.canonical_json(),
        seed: run.seed(),
        arena: run.arena().name().to_owned(),
        method: run.method().name().to_owned(),
        epochs_total: spec.epochs,
        robot_steps_total: spec.robot_steps(),
        uploaded_arenas: uploaded_arenas(&run.canonical()),
    }
}

/// Names of the arenas in the spec that do not ship with the program.
fn uploaded_arenas(spec: &api::RunSpec) -> Vec<String> {
    let train = spec
        .controller
        .as_ref()
        .and_then(|controller| controller.train.as_ref());
    [
        spec.arena.as_ref(),
        train.and_then(|train| train.arena.as_ref()),
    ]
    .into_iter()
    .filter_map(|arena| match arena {
        Some(ArenaRef::Name(name)) if BuiltinArenas.arena(name).is_none() => Some(name.clone()),
        _ => None,
    })
    .collect()
}
