//! The `controller` and `robot` sections: names and ranges come from the parameter tables.

use std::collections::BTreeMap;

use serde_json::Value;
use swarm::methods::Trains;
use swarm::parameters::{Parameter, ParameterError, Shown, Value as ParameterValue};
use swarm::robot::{Preset, RobotModel, RobotParameters};
use swarm::spec::{ControllerParameters, ControllerPreset, ControllerSpec, Method, Training};

use super::arena::Arenas;
use super::domains::{Choice, Whole};
use super::fields::{Errors, Object, kind};
use super::limits::MAX_EPOCHS;
use super::listing::shown_value;

pub(super) const METHOD: Choice<Method> = Choice {
    name: "method",
    names: Method::NAMES,
    read: Method::from_name,
    shown: Method::name,
    default: Method::EvIterC,
};
pub(super) const CONTROLLER_PRESET: Choice<ControllerPreset> = Choice {
    name: "preset",
    names: ControllerPreset::NAMES,
    read: ControllerPreset::from_name,
    shown: ControllerPreset::name,
    default: ControllerPreset::Default,
};
pub(super) const PRESET: Choice<Preset> = Choice {
    name: "preset",
    names: Preset::NAMES,
    read: Preset::from_name,
    shown: Preset::name,
    default: Preset::Thesis,
};
pub(super) const DEFAULT_TRAINING_ARENA: &str = "easy";
pub(super) const TRAINING_EPOCHS: Whole = Whole {
    name: "epochs",
    min: 1,
    max: MAX_EPOCHS,
    default: 200,
};

/// Resolves `controller`, and says how it is shown with every default.
pub fn controller(
    value: &Value,
    arenas: &mut Arenas<'_>,
    errors: &mut Errors,
) -> Option<(ControllerSpec, api::ControllerSpec)> {
    let known = ["method", "preset", "train"]
        .into_iter()
        .chain(names(ControllerParameters::TABLE))
        .chain(Method::ALL.iter().flat_map(|&method| own_names(method)));
    let object = Object::open(value, "/controller", known, errors)?;
    let method = object.choice(&METHOD, errors);
    // Not shown: a resolved spec has every parameter, so that the same run is one run.
    let preset = object.choice(&CONTROLLER_PRESET, errors);
    let mut parameters = ControllerParameters::preset(preset);
    set_all(
        &object,
        ControllerParameters::TABLE,
        |n, v| parameters.set(n, v),
        errors,
    );
    let mut own = (method.definition().parameters)();
    set_all(&object, own.table(), |n, v| own.set(n, v), errors);
    refuse_others(&object, method, errors);

    let trains = method.definition().trains;
    let (training, train) = if trains.with(parameters.states_from) {
        let (training, shown) = training(object.get("train"), arenas, errors)?;
        (Some(training), Some(shown))
    } else {
        if object.get("train").is_some() {
            let reason = match trains {
                Trains::Never | Trains::Always => format!("{} has no training", method.name()),
                Trains::WithPhase1States => {
                    format!("{} trains only {}", method.name(), trains.words())
                }
            };
            errors.add(object.pointer("train"), reason, "no train field");
        }
        (None, None)
    };
    let shown = api::ControllerSpec {
        method: Some(method.name().to_owned()),
        preset: None,
        train,
        parameters: shown_values(parameters.shown().into_iter().chain(own.shown().to_vec())),
    };
    Some((
        ControllerSpec {
            method,
            parameters,
            own,
            training,
        },
        shown,
    ))
}

fn own_names(method: Method) -> impl Iterator<Item = &'static str> {
    names((method.definition().parameters)().table())
}

/// Refuses parameters that another method alone has.
fn refuse_others(object: &Object<'_>, method: Method, errors: &mut Errors) {
    let own: Vec<&str> = own_names(method).collect();
    let others = Method::ALL.iter().filter(|&&other| other != method);
    for (other, name) in others.flat_map(|&other| own_names(other).map(move |name| (other, name))) {
        if object.get(name).is_some() && !own.contains(&name) {
            let other = other.name();
            errors.add(
                object.pointer(name),
                format!(
                    "{} has no {name}: it is a parameter of {other}",
                    method.name()
                ),
                format!("no {name}, or the method {other}"),
            );
        }
    }
}

fn training(
    value: Option<&Value>,
    arenas: &mut Arenas<'_>,
    errors: &mut Errors,
) -> Option<(Training, api::TrainSpec)> {
    let empty = Value::Object(serde_json::Map::new());
    let pointer = "/controller/train";
    let object = Object::open(
        value.unwrap_or(&empty),
        pointer,
        ["arena", "epochs"],
        errors,
    )?;
    let default = Value::from(DEFAULT_TRAINING_ARENA);
    let named = object.get("arena").unwrap_or(&default);
    let found = arenas.read(named, &object.pointer("arena"), errors);
    // MAX_EPOCHS fits in 32 bits.
    let epochs = object.whole(&TRAINING_EPOCHS, errors) as u32;
    let found = found?;
    let shown = api::TrainSpec {
        arena: Some(found.shown),
        epochs: Some(epochs),
    };
    Some((
        Training {
            arena: found.arena,
            epochs,
        },
        shown,
    ))
}

/// Resolves `robot`, and says how it is shown with every default.
pub fn robot(value: &Value, errors: &mut Errors) -> Option<(RobotModel, api::RobotSpec)> {
    let known = std::iter::once("preset").chain(names(RobotParameters::TABLE));
    let object = Object::open(value, "/robot", known, errors)?;
    let preset = object.choice(&PRESET, errors);
    let mut model = RobotModel::preset(preset);
    set_all(
        &object,
        RobotParameters::TABLE,
        |n, v| model.parameters.set(n, v),
        errors,
    );
    let shown = api::RobotSpec {
        preset: Some(preset.name().to_owned()),
        parameters: shown_values(model.parameters.shown()),
    };
    Some((model, shown))
}

fn names(table: &'static [Parameter]) -> impl Iterator<Item = &'static str> {
    table.iter().map(|parameter| parameter.name)
}

/// Sets each parameter of the table that the object holds.
fn set_all(
    object: &Object<'_>,
    table: &'static [Parameter],
    mut set: impl FnMut(&str, ParameterValue<'_>) -> Result<(), ParameterError>,
    errors: &mut Errors,
) {
    for parameter in table {
        let Some(value) = object.get(parameter.name) else {
            continue;
        };
        let allowed = parameter.domain.allowed();
        let outcome = match value {
            Value::Number(number) => match number.as_f64() {
                Some(number) => set(parameter.name, ParameterValue::Number(number)),
                None => Err(ParameterError::Domain(allowed.clone())),
            },
            Value::String(text) => set(parameter.name, ParameterValue::Text(text)),
            _ => {
                let message = format!("must be {allowed}, not {}", kind(value));
                errors.add(object.pointer(parameter.name), message, allowed);
                continue;
            }
        };
        if let Err(error) = outcome {
            errors.add(object.pointer(parameter.name), error.to_string(), allowed);
        }
    }
}

/// Parameters of the learner as they are shown, at their defaults.
pub fn defaults() -> BTreeMap<String, Value> {
    shown_values(ControllerParameters::default().shown())
}

fn shown_values(shown: impl IntoIterator<Item = (&'static str, Shown)>) -> BTreeMap<String, Value> {
    shown
        .into_iter()
        .map(|(name, value)| (name.to_owned(), shown_value(value)))
        .collect()
}
