//! From an expanded job to what the store keeps of it.

use api::ArenaRef;
use sha2::{Digest, Sha256};
use swarm::spec::{Method, RunSpec, StatesFrom};

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
        robot_steps_total: expected_robot_steps(&spec),
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

/// Robot-steps to expect before the run itself says how many: its counted epochs, and those of its
/// training.
fn expected_robot_steps(spec: &RunSpec) -> u64 {
    let training = spec.controller.training.as_ref();
    let trained = training.map_or(0, |training| training.epochs);
    let parameters = &spec.controller.parameters;
    let uncounted = match spec.controller.method {
        Method::Brownian => 0,
        Method::Im if parameters.states_from == StatesFrom::Babbling => parameters.babbling_epochs,
        Method::Im => trained,
        // Phase 1, and its replay into the repository.
        Method::EvIterC | Method::EvIterD | Method::EvIterCa | Method::EvIterDa => 2 * trained,
        // Each controller is evaluated where it evolves, and run where visits count.
        Method::Curiosity | Method::CuriosityA | Method::Discovery | Method::DiscoveryA => {
            let elsewhere = training.is_some_and(|training| *training.arena != *spec.arena);
            if elsewhere { spec.epochs } else { 0 }
        }
    };
    (u64::from(spec.epochs) + u64::from(uncounted))
        * u64::from(spec.steps_per_epoch)
        * u64::from(spec.robots)
}
