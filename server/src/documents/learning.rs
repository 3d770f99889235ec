//! What a learner may hold and what robots share: `memory_budget_bytes` and `sharing`.

use api::SharingSpec;
use serde_json::Value;
use swarm::memory::{E_PUCK_BYTES, E_PUCK2_BYTES};
use swarm::spec::{
    DEFAULT_BYTES_PER_STEP, DEFAULT_RANGE_M, LEAST_BYTES_PER_STEP, MOST_BYTES_PER_STEP, RadioLink,
    Sharing, SharingMode,
};

use super::domains::{Choice, Whole};
use super::fields::{Errors, Object, did_you_mean, kind};

/// Budgets by name.
pub(super) const BUDGETS: [(&str, u64); 2] = [("e-puck", E_PUCK_BYTES), ("e-puck2", E_PUCK2_BYTES)];
/// A budget as a number of bytes, at most 1 GiB a robot.
pub(super) const BUDGET: Whole = Whole {
    name: "memory_budget_bytes",
    min: 1,
    max: 1 << 30,
    default: 1 << 30,
};
/// Farthest that a radio may reach short of everywhere.
pub(super) const MOST_RANGE_M: f64 = 100.0;
pub(super) const MODE: Choice<SharingMode> = Choice {
    name: "mode",
    names: SharingMode::NAMES,
    read: SharingMode::from_name,
    shown: SharingMode::name,
    default: SharingMode::None,
};
pub(super) const BYTES_PER_STEP: Whole = Whole {
    name: "bytes_per_step",
    min: LEAST_BYTES_PER_STEP as u64,
    max: MOST_BYTES_PER_STEP as u64,
    default: DEFAULT_BYTES_PER_STEP as u64,
};

/// A budget in bytes: a number, a robot's name, or null for none.
pub fn memory_budget_bytes(spec: &Object<'_>, errors: &mut Errors) -> Option<u64> {
    let name = BUDGET.name;
    let value = spec.get(name)?;
    let names = BUDGETS.map(|(name, _)| name);
    let message = match value {
        Value::Null => return None,
        Value::String(text) => match BUDGETS.iter().find(|(name, _)| name == text) {
            Some((_, bytes)) => return Some(*bytes),
            None => format!("there is no budget {text:?}{}", did_you_mean(text, &names)),
        },
        Value::Number(_) => {
            return Some(spec.whole(&BUDGET, errors));
        }
        _ => format!("must be a number, a name or null, not {}", kind(value)),
    };
    let allowed = format!(
        "a whole number of bytes to {}, {} or null",
        BUDGET.max,
        names.join(", ")
    );
    errors.add(spec.pointer(name), message, allowed);
    None
}

/// Reads `sharing`, and says how it is shown with every default.
pub fn sharing(value: &Value, errors: &mut Errors) -> Option<(Sharing, SharingSpec)> {
    let known = ["mode", "range_m", "bytes_per_step"];
    let object = Object::open(value, "/sharing", known, errors)?;
    let mode = object.choice(&MODE, errors);
    let mut shown = SharingSpec {
        mode: Some(mode.name().to_owned()),
        ..SharingSpec::default()
    };
    if mode != SharingMode::Radio {
        for field in ["range_m", "bytes_per_step"] {
            if object.get(field).is_some() {
                let message = format!("sharing {:?} has no radio", mode.name());
                errors.add(object.pointer(field), message, "only with mode \"radio\"");
            }
        }
        let sharing = match mode {
            SharingMode::Arena => Sharing::Arena,
            _ => Sharing::None,
        };
        return Some((sharing, shown));
    }
    let range_m = range_m(&object, errors);
    // The most fits in 32 bits.
    let bytes_per_step = object.whole(&BYTES_PER_STEP, errors) as u32;
    shown.range_m = Some(range_m);
    shown.bytes_per_step = Some(bytes_per_step);
    let link = RadioLink {
        range_m,
        bytes_per_step,
    };
    Some((Sharing::Radio(link), shown))
}

/// Metres, or null for no limit.
fn range_m(object: &Object<'_>, errors: &mut Errors) -> Option<f64> {
    let message = match object.get("range_m") {
        None => return Some(DEFAULT_RANGE_M),
        Some(Value::Null) => return None,
        Some(Value::Number(number)) => match number.as_f64() {
            Some(range_m) if (0.0..=MOST_RANGE_M).contains(&range_m) => return Some(range_m),
            _ => format!("{number} is out of range"),
        },
        Some(value) => format!("must be a number or null, not {}", kind(value)),
    };
    let allowed = format!("a number from 0 to {MOST_RANGE_M}, or null for no limit");
    errors.add(object.pointer("range_m"), message, allowed);
    Some(DEFAULT_RANGE_M)
}
