//! From an expanded job to what the store keeps of it.

use api::{ArenaRef, FieldError};
use swarm::spec::EngineKind;

use crate::documents::{ArenaSource, BuiltinArenas, ExpandedJob, ResolvedRun};
use crate::recording::Limits;
use crate::store::{JobRequest, NewJob, NewRun};

/// About what a robot-step of rigid bodies costs against one of the kinematic engine, for one robot
/// (`docs/performance.md`). Only estimates of what is left depend on it.
const RAPIER_STEP_COST: u32 = 20;

/// The job with its runs, and the request that it came in. Whatever is stored of jobs is made here,
/// so no job is whose runs are to record more of themselves than these limits allow.
///
/// # Errors
/// What would fit.
pub fn new_job(
    job: ExpandedJob,
    request: JobRequest,
    limits: &Limits,
) -> Result<NewJob, Vec<FieldError>> {
    limits.check_job(&job.runs)?;
    let runs = job.runs.iter().zip(&job.labels);
    Ok(NewJob {
        runs: runs.map(|(run, label)| new_run(run, label)).collect(),
        // Strings and JSON values: JSON can hold all of them.
        design: serde_json::to_string(&job.designs).unwrap_or_default(),
        name: job.name,
        request,
    })
}

fn new_run(run: &ResolvedRun, label: &str) -> NewRun {
    NewRun {
        id: run.key(),
        spec: run.canonical_json(),
        seed: run.seed(),
        arena: run.arena().name().to_owned(),
        method: run.method().name().to_owned(),
        epochs_total: run.epochs(),
        robot_steps_total: run.robot_steps(),
        step_cost: step_cost(run.engine()),
        uploaded_arenas: uploaded_arenas(run.shown()),
        label: label.to_owned(),
        origin: None,
    }
}

/// About what a robot-step costs against one of the kinematic engine.
pub fn step_cost(engine: EngineKind) -> u32 {
    match engine {
        EngineKind::Kinematic => 1,
        EngineKind::Rapier => RAPIER_STEP_COST,
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
    .flatten()
    .filter_map(name_of)
    .filter(|name| BuiltinArenas.arena(name).is_none())
    .map(str::to_owned)
    .collect()
}

/// The name by which an arena, or the one that it is made of, was asked for.
fn name_of(arena: &ArenaRef) -> Option<&str> {
    match arena {
        ArenaRef::Name(name) => Some(name),
        ArenaRef::Inline(object) => {
            let mut from = object.get("from")?;
            while let Some(inner) = from.get("from") {
                from = inner;
            }
            from.as_str()
        }
    }
}
