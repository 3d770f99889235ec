//! `GET /v1/controllers` and `evswarm controllers`: the parameter tables as a document.

use api::{ControllerListing, MethodListing, ParameterListing, PresetListing, SCHEMA};
use serde_json::Value;
use swarm::parameters::{Parameter, Shown};
use swarm::robot::{Preset, RobotParameters};
use swarm::spec::{ControllerParameters, ControllerPreset, Method};

/// Every method, preset and parameter.
pub fn controllers() -> ControllerListing {
    ControllerListing {
        schema: SCHEMA,
        methods: Method::ALL.iter().map(|&method| listed(method)).collect(),
        parameters: parameters(
            ControllerParameters::TABLE,
            ControllerParameters::default().shown(),
        ),
        presets: Preset::NAMES
            .iter()
            .map(|name| (*name).to_owned())
            .collect(),
        controller_presets: ControllerPreset::ALL.iter().map(|&p| preset(p)).collect(),
        robot_parameters: parameters(RobotParameters::TABLE, RobotParameters::default().shown()),
    }
}

fn listed(method: Method) -> MethodListing {
    let definition = method.definition();
    let own = (definition.parameters)();
    MethodListing {
        name: method.name().to_owned(),
        about: definition.about.to_owned(),
        source: definition.source.to_owned(),
        trains: definition.trains.words().to_owned(),
        parameters: parameters(own.table(), own.shown().to_vec()),
    }
}

/// A preset with what it sets besides the defaults.
fn preset(preset: ControllerPreset) -> PresetListing {
    let own = ControllerParameters::preset(preset).shown();
    let defaults = ControllerParameters::default().shown();
    let set = own
        .into_iter()
        .zip(defaults)
        .filter(|(own, default)| own != default);
    PresetListing {
        name: preset.name().to_owned(),
        parameters: set
            .map(|((name, value), _)| (name.to_owned(), shown_value(value)))
            .collect(),
    }
}

/// A table with its defaults, which `shown` holds in table order.
fn parameters(
    table: &'static [Parameter],
    shown: Vec<(&'static str, Shown)>,
) -> Vec<ParameterListing> {
    table
        .iter()
        .zip(shown)
        .map(|(parameter, (_, default))| ParameterListing {
            name: parameter.name.to_owned(),
            default: shown_value(default),
            domain: serde_json::to_value(parameter.domain).unwrap_or(Value::Null),
            unit: parameter.unit.to_owned(),
            about: parameter.about.to_owned(),
            source: parameter.source.to_owned(),
        })
        .collect()
}

/// A parameter's value as JSON.
pub fn shown_value(shown: Shown) -> Value {
    match shown {
        Shown::Whole(number) => Value::from(number),
        Shown::Real(number) => Value::from(number),
        Shown::Name(name) => Value::from(name),
    }
}
