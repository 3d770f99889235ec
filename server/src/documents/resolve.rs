//! A run spec as posted, checked field by field and filled in.

use api::{FieldError, SCHEMA};
use serde_json::Value;
use swarm::ValidSpec;
use swarm::spec::{EngineKind, Episodes, RunSpec};

use super::arena::{ArenaSource, Arenas};
use super::controller;
use super::domains::{Choice, Flag, SCHEMA_LINK, Whole};
use super::fields::{Errors, Object, field_error};
use super::learning;
use super::limits::{MAX_EPOCHS, MAX_ROBOTS, MAX_SEED, MAX_STEPS_PER_EPOCH};
use super::placement;
use super::record::{RecordRequest, Stretch, record};
use super::record_bytes::MOST_RECORDING_BYTES;
use super::resolved::{Beside, ResolvedRun};
use super::start::Start;

/// Fields of a run spec.
pub(super) const FIELDS: [&str; 17] = [
    SCHEMA_LINK,
    "schema",
    "seed",
    "arena",
    "controller",
    "epochs",
    "steps_per_epoch",
    "robots",
    "placement",
    "start",
    "episodes",
    "robot",
    "engine",
    "memory_budget_bytes",
    "sharing",
    "record",
    "channels",
];

/// Version of the format.
pub(super) const VERSION: Whole = Whole {
    name: "schema",
    min: SCHEMA as u64,
    max: SCHEMA as u64,
    default: SCHEMA as u64,
};
pub(super) const SEED: Whole = Whole {
    name: "seed",
    min: 0,
    max: MAX_SEED,
    default: 1,
};
pub(super) const DEFAULT_ARENA: &str = "maze";
pub(super) const EPOCHS: Whole = Whole {
    name: "epochs",
    min: 1,
    max: MAX_EPOCHS,
    default: 2_000,
};
pub(super) const STEPS_PER_EPOCH: Whole = Whole {
    name: "steps_per_epoch",
    min: 1,
    max: MAX_STEPS_PER_EPOCH,
    default: 2_000,
};
pub(super) const ROBOTS: Whole = Whole {
    name: "robots",
    min: 1,
    max: MAX_ROBOTS,
    default: 1,
};
pub(super) const EPISODES: Choice<Episodes> = Choice {
    name: "episodes",
    names: Episodes::NAMES,
    read: Episodes::from_name,
    shown: Episodes::name,
    default: Episodes::Reset,
};
pub(super) const ENGINE: Choice<EngineKind> = Choice {
    name: "engine",
    names: EngineKind::NAMES,
    read: EngineKind::from_name,
    shown: EngineKind::name,
    default: EngineKind::Kinematic,
};
pub(super) const CHANNELS: Flag = Flag {
    name: "channels",
    default: false,
};

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
        Some((run, shown, beside)) if errors.is_empty() => match run.validate() {
            Ok(run) => match check_size(&run, beside.record.as_ref()) {
                Ok(()) => return Ok(ResolvedRun::new(run, shown, beside)),
                Err(error) => errors.extend([error]),
            },
            Err(wrong) => errors.extend(wrong.into_iter().map(field_error)),
        },
        _ => {}
    }
    Err(errors.into_vec())
}

/// Whether what is recorded of a run is too much.
fn check_size(run: &ValidSpec, record: Option<&RecordRequest>) -> Result<(), FieldError> {
    let Some(record) = record else { return Ok(()) };
    let epochs = Stretch::whole(run).epochs;
    record.check_size(
        run,
        epochs,
        MOST_RECORDING_BYTES,
        "that a recording may take",
    )
}

fn read(
    spec: &Value,
    arenas: &mut Arenas<'_>,
    errors: &mut Errors,
) -> Option<(RunSpec, api::RunSpec, Beside)> {
    let object = Object::open(spec, "", FIELDS, errors)?;
    let empty = Value::Object(serde_json::Map::new());
    let section = |name| object.get(name).unwrap_or(&empty);

    object.whole(&VERSION, errors);
    let seed = object.whole(&SEED, errors);
    let default_arena = Value::from(DEFAULT_ARENA);
    let arena = object.get("arena").unwrap_or(&default_arena);
    let arena = arenas.read(arena, "/arena", errors);
    let controller = controller::controller(section("controller"), arenas, errors);
    // The caps of the three are of 32 bits.
    let epochs = object.whole(&EPOCHS, errors) as u32;
    let steps = object.whole(&STEPS_PER_EPOCH, errors) as u32;
    let robots = object.whole(&ROBOTS, errors) as u32;
    let placement = placement::read(&object, errors);
    let start = Start::read(&object, errors);
    let episodes = object.choice(&EPISODES, errors);
    let robot = controller::robot(section("robot"), errors);
    let engine = object.choice(&ENGINE, errors);
    let memory_budget_bytes = learning::memory_budget_bytes(&object, errors);
    let sharing = learning::sharing(section("sharing"), errors);
    let record = record(section("record"), robots, errors);
    let channels = object.flag(&CHANNELS, errors);

    let (
        mut arena,
        (mut controller, controller_shown),
        (robot, robot_shown),
        (sharing, sharing_shown),
    ) = (arena?, controller?, robot?, sharing?);
    if let Some(start) = &start {
        arena.arena = start.put_into(&arena.arena, errors);
        if let Some(training) = &mut controller.training {
            training.arena = start.put_into(&training.arena, errors);
        }
    }
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
        start: start.as_ref().map(Start::shown),
        episodes: Some(episodes.name().to_owned()),
        robot: Some(robot_shown),
        engine: Some(engine.name().to_owned()),
        memory_budget_bytes: memory_budget_bytes.map_or(Value::Null, Value::from),
        sharing: Some(sharing_shown),
        record: Some(RecordRequest::shown(record.as_ref())),
        channels: Some(channels),
    };
    Some((run, shown, Beside { record, channels }))
}
