//! A run spec as posted, checked field by field and filled in.

use api::{FieldError, RecordSpec, SCHEMA};
use serde_json::Value;
use swarm::spec::{EngineKind, Episodes, RunSpec};

use super::arena::{ArenaSource, Arenas};
use super::controller;
use super::fields::{Errors, Object, field_error};
use super::learning;
use super::limits::{MAX_EPOCHS, MAX_ROBOTS, MAX_SEED, MAX_STEPS_PER_EPOCH};
use super::placement;
use super::resolved::ResolvedRun;

/// Fields of a run spec.
pub(super) const FIELDS: [&str; 15] = [
    "schema",
    "seed",
    "arena",
    "controller",
    "epochs",
    "steps_per_epoch",
    "robots",
    "placement",
    "episodes",
    "robot",
    "engine",
    "memory_budget_bytes",
    "sharing",
    "record",
    "channels",
];

/// Checks a run spec and fills in every default.
///
/// # Errors
/// Every wrong field, with its JSON pointer into `spec` and what is allowed there.
pub fn resolve(spec: &Value, arenas: &dyn ArenaSource) -> Result<ResolvedRun, Vec<FieldError>> {
    resolve_with(spec, &mut Arenas::new(arenas))
}

/// As [`resolve`], with arenas that were read before.
pub(super) fn resolve_with(
    spec: &Value,
    arenas: &mut Arenas<'_>,
) -> Result<ResolvedRun, Vec<FieldError>> {
    let mut errors = Errors::default();
    let read = read(spec, arenas, &mut errors);
    match read {
        Some((run, shown, channels)) if errors.is_empty() => match run.validate() {
            Ok(run) => return Ok(ResolvedRun::new(run, shown, channels)),
            Err(wrong) => errors.extend(wrong.into_iter().map(field_error)),
        },
        _ => {}
    }
    Err(errors.into_vec())
}

fn read(
    spec: &Value,
    arenas: &mut Arenas<'_>,
    errors: &mut Errors,
) -> Option<(RunSpec, api::RunSpec, bool)> {
    let object = Object::open(spec, "", FIELDS, errors)?;
    let empty = Value::Object(serde_json::Map::new());
    let section = |name| object.get(name).unwrap_or(&empty);

    let schema = u64::from(SCHEMA);
    object.whole("schema", schema, schema, schema, errors);
    let seed = object.whole("seed", 0, MAX_SEED, 1, errors);
    let default_arena = Value::from("maze");
    let arena = object.get("arena").unwrap_or(&default_arena);
    let arena = arenas.read(arena, "/arena", errors);
    let controller = controller::controller(section("controller"), arenas, errors);
    // The caps of the three are of 32 bits.
    let epochs = object.whole("epochs", 1, MAX_EPOCHS, 2_000, errors) as u32;
    let steps = object.whole("steps_per_epoch", 1, MAX_STEPS_PER_EPOCH, 2_000, errors) as u32;
    let robots = object.whole("robots", 1, MAX_ROBOTS, 1, errors) as u32;
    let placement = placement::read(&object, errors);
    let episodes = object.choice(
        "episodes",
        Episodes::NAMES,
        Episodes::from_name,
        Episodes::Reset,
        errors,
    );
    let robot = controller::robot(section("robot"), errors);
    let engine = object.choice(
        "engine",
        EngineKind::NAMES,
        EngineKind::from_name,
        EngineKind::Kinematic,
        errors,
    );
    let memory_budget_bytes = learning::memory_budget_bytes(&object, errors);
    let sharing = learning::sharing(section("sharing"), errors);
    record(section("record"), errors);
    let channels = object.flag("channels", false, errors);

    let (arena, (controller, controller_shown), (robot, robot_shown), (sharing, sharing_shown)) =
        (arena?, controller?, robot?, sharing?);
    let run = RunSpec {
        seed,
        arena: arena.arena,
        controller,
        epochs,
        steps_per_epoch: steps,
        robots,
        placement,
        episodes,
        robot,
        engine,
        memory_budget_bytes,
        sharing,
    };
    let shown = api::RunSpec {
        schema: Some(SCHEMA),
        seed: Some(seed),
        arena: Some(arena.shown),
        controller: Some(controller_shown),
        epochs: Some(epochs),
        steps_per_epoch: Some(steps),
        robots: Some(robots),
        placement: Some(placement::shown(placement)),
        episodes: Some(episodes.name().to_owned()),
        robot: Some(robot_shown),
        engine: Some(engine.name().to_owned()),
        memory_budget_bytes: memory_budget_bytes.map_or(Value::Null, Value::from),
        sharing: Some(sharing_shown),
        record: Some(RecordSpec {
            every_steps: Some(0),
        }),
        channels: Some(channels),
    };
    Some((run, shown, channels))
}

/// Part of the contract, of which only a run without a recording is built.
fn record(value: &Value, errors: &mut Errors) {
    let Some(object) = Object::open(value, "/record", ["every_steps"], errors) else {
        return;
    };
    if object.whole("every_steps", 0, u64::from(u32::MAX), 0, errors) != 0 {
        errors.add(
            object.pointer("every_steps"),
            "recording is not supported yet",
            "0",
        );
    }
}
