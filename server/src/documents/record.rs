//! What is to be recorded of a run: `record` in a spec, and what is asked for afterwards.

use api::{FieldError, RecordSpec};
use recording::{Chosen, Fields};
use serde_json::Value;
use swarm::ValidSpec;
use swarm::run::StagePlan;

use super::domains::Whole;
use super::fields::{Errors, Object, did_you_mean, join, kind, read_whole};

/// Names of what is recorded of a robot, and how many bytes each takes a sample at most, about: of
/// robots that are given other commands at each step, and often touch things.
pub(super) const FIELDS: [(&str, f64); 4] = [
    ("pose", 5.0),
    ("command", 3.0),
    ("sensors", 10.0),
    ("decision", 2.0),
];
/// Steps between two samples of a run that records itself; 0 records nothing.
pub(super) const EVERY_STEPS: Whole = Whole {
    name: "every_steps",
    min: 0,
    max: u32::MAX as u64,
    default: 0,
};

/// What is to be recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordRequest {
    /// Every so many steps.
    pub every_steps: u32,
    /// Of which robots.
    pub robots: RobotChoice,
    /// What of them.
    pub fields: Fields,
}

/// Robots that are recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RobotChoice {
    /// All of them.
    All,
    /// The first so many.
    First(u32),
    /// These, in ascending order.
    List(Vec<u32>),
}

/// Epochs of a run that are recorded, counted from 0 over all its stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// The first.
    pub from_epoch: u64,
    /// How many.
    pub epochs: u64,
}

impl Stretch {
    /// All of a run.
    pub fn whole(spec: &ValidSpec) -> Self {
        let plan = spec.plan();
        Self {
            from_epoch: 0,
            epochs: plan.iter().map(StagePlan::arena_epochs).sum(),
        }
    }
}

impl Stretch {
    /// What of it is at or after an epoch.
    #[must_use]
    pub fn starting_at(self, epoch: u64) -> Self {
        let end = self.from_epoch + self.epochs;
        let from_epoch = self.from_epoch.max(epoch).min(end);
        Self {
            from_epoch,
            epochs: end - from_epoch,
        }
    }
}

impl RobotChoice {
    /// Of so many robots.
    pub fn of(&self, robots: u32) -> Chosen {
        match self {
            RobotChoice::All => Chosen::First(robots),
            RobotChoice::First(count) => Chosen::First((*count).min(robots)),
            RobotChoice::List(list) => Chosen::List(list.clone()),
        }
    }

    fn shown(&self) -> Value {
        match self {
            RobotChoice::All => Value::from("all"),
            RobotChoice::First(count) => Value::from(*count),
            RobotChoice::List(list) => Value::from(list.clone()),
        }
    }
}

impl RecordRequest {
    /// As a spec has it.
    pub fn shown(request: Option<&Self>) -> RecordSpec {
        RecordSpec {
            every_steps: Some(request.map_or(0, |request| u64::from(request.every_steps))),
            robots: request.map(|request| request.robots.shown()),
            fields: request.map(|request| {
                let names = names_of(request.fields);
                names.into_iter().map(str::to_owned).collect()
            }),
        }
    }
}

/// Names of what is recorded of a robot.
pub(super) fn field_names() -> [&'static str; 4] {
    FIELDS.map(|(name, _)| name)
}

pub(super) fn has(fields: Fields) -> [bool; 4] {
    [fields.pose, fields.command, fields.sensors, fields.decision]
}

/// The names of fields, in the order of their table.
pub fn names_of(fields: Fields) -> Vec<&'static str> {
    let named = FIELDS.iter().zip(has(fields));
    named
        .filter(|(_, has)| *has)
        .map(|((n, _), _)| *n)
        .collect()
}

/// Reads `record`; `None` where nothing is recorded.
pub fn record(value: &Value, robots: u32, errors: &mut Errors) -> Option<RecordRequest> {
    let known = ["every_steps", "robots", "fields"];
    let object = Object::open(value, "/record", known, errors)?;
    let every = object.whole(&EVERY_STEPS, errors) as u32;
    if every == 0 {
        for field in ["robots", "fields"] {
            if object.get(field).is_some() {
                let pointer = object.pointer(field);
                let message = "nothing is recorded: every_steps is 0";
                errors.add(pointer, message, "only with every_steps of at least 1");
            }
        }
        return None;
    }
    request(&object, every, robots, errors)
}

/// Reads what is recorded every so many steps, of a run with so many robots.
fn request(
    object: &Object<'_>,
    every_steps: u32,
    robots: u32,
    errors: &mut Errors,
) -> Option<RecordRequest> {
    let robots = chosen(object, robots, errors);
    let fields = fields(object, errors);
    Some(RecordRequest {
        every_steps,
        robots: robots?,
        fields: fields?,
    })
}

/// What is asked for afterwards of a run, which has epochs from `first` on.
///
/// # Errors
/// Every wrong field.
pub fn asked(
    value: &Value,
    spec: &ValidSpec,
    first: u64,
) -> Result<(RecordRequest, Stretch), Vec<FieldError>> {
    let mut errors = Errors::default();
    let known = ["from_epoch", "epochs", "every_steps", "robots", "fields"];
    let Some(object) = Object::open(value, "", known, &mut errors) else {
        return Err(errors.into_vec());
    };
    let all = Stretch::whole(spec).epochs;
    let first = first.min(all - 1);
    let whole = |name, min, max, default| Whole {
        name,
        min,
        max,
        default,
    };
    let field = whole("from_epoch", first, all - 1, first);
    let from_epoch = object.whole(&field, &mut errors);
    let left = all - from_epoch;
    let epochs = object.whole(&whole("epochs", 1, left, left), &mut errors);
    let field = whole("every_steps", 1, u64::from(u32::MAX), 1);
    let every_steps = object.whole(&field, &mut errors) as u32;
    let request = request(&object, every_steps, spec.robots, &mut errors);
    match request {
        Some(request) if errors.is_empty() => Ok((request, Stretch { from_epoch, epochs })),
        _ => Err(errors.into_vec()),
    }
}

fn chosen(object: &Object<'_>, robots: u32, errors: &mut Errors) -> Option<RobotChoice> {
    let pointer = object.pointer("robots");
    let allowed = format!(
        "\"all\", how many of the first (1 to {robots}), or a list of numbers from 0 to {}",
        robots.saturating_sub(1)
    );
    let message = match object.get("robots") {
        None => return Some(RobotChoice::All),
        Some(Value::String(text)) if text == "all" => return Some(RobotChoice::All),
        Some(value @ Value::Number(number)) => match read_whole(value) {
            Some(count) if (1..=u64::from(robots)).contains(&count) => {
                return Some(RobotChoice::First(count as u32));
            }
            _ => format!("{number} is not from 1 to {robots}"),
        },
        Some(Value::Array(list)) => return listed(list, robots, &pointer, &allowed, errors),
        Some(Value::String(_)) => "is not \"all\"".to_owned(),
        Some(value) => format!("must be \"all\", a number or a list, not {}", kind(value)),
    };
    errors.add(pointer, message, allowed);
    None
}

fn listed(
    list: &[Value],
    robots: u32,
    pointer: &str,
    allowed: &str,
    errors: &mut Errors,
) -> Option<RobotChoice> {
    let mut numbers = Vec::new();
    for (place, value) in list.iter().enumerate() {
        match read_whole(value).filter(|number| *number < u64::from(robots)) {
            Some(number) => numbers.push(number as u32),
            None => errors.add(
                join(pointer, &place.to_string()),
                format!(
                    "is not the number of a robot, 0 to {}",
                    robots.saturating_sub(1)
                ),
                allowed,
            ),
        }
    }
    if numbers.len() < list.len() {
        return None;
    }
    numbers.sort_unstable();
    let twice = numbers.windows(2).find(|both| both[0] == both[1]);
    if let Some(twice) = twice {
        errors.add(
            pointer,
            format!("robot {} is listed twice", twice[0]),
            allowed,
        );
        return None;
    }
    if numbers.is_empty() {
        errors.add(pointer, "no robot is listed", allowed);
        return None;
    }
    Some(RobotChoice::List(numbers))
}

fn fields(object: &Object<'_>, errors: &mut Errors) -> Option<Fields> {
    let names = FIELDS.map(|(name, _)| name);
    let allowed = format!("a list of some of {}", names.join(", "));
    let pointer = object.pointer("fields");
    let list = match object.get("fields") {
        None => return Some(Fields::ALL),
        Some(Value::Array(list)) if !list.is_empty() => list,
        Some(Value::Array(_)) => {
            errors.add(pointer, "the list is empty", allowed);
            return None;
        }
        Some(value) => {
            let message = format!("must be a list, not {}", kind(value));
            errors.add(pointer, message, allowed);
            return None;
        }
    };
    let mut has = [false; 4];
    let mut sound = true;
    for (place, value) in list.iter().enumerate() {
        let name = value.as_str().unwrap_or_default();
        match names.iter().position(|known| *known == name) {
            Some(known) => has[known] = true,
            None => {
                sound = false;
                let told = match value {
                    Value::String(_) => {
                        format!("there is no such field{}", did_you_mean(name, &names))
                    }
                    _ => format!("must be a name, not {}", kind(value)),
                };
                errors.add(join(&pointer, &place.to_string()), told, allowed.clone());
            }
        }
    }
    let [pose, command, sensors, decision] = has;
    sound.then_some(Fields {
        pose,
        command,
        sensors,
        decision,
    })
}
