//! `GET /v1/controllers` and `evswarm controllers`: the parameter tables as a document.

use api::{ControllerListing, MethodListing, ParameterListing, SCHEMA};
use serde_json::Value;
use swarm::parameters::{Parameter, Shown};
use swarm::robot::{Preset, RobotParameters};
use swarm::spec::{ControllerParameters, Method, StatesFrom};

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
        robot_parameters: parameters(RobotParameters::TABLE, RobotParameters::default().shown()),
    }
}

fn listed(method: Method) -> MethodListing {
    let trains = match StatesFrom::ALL
        .iter()
        .filter(|from| method.trains(**from))
        .count()
    {
        0 => "no",
        n if n == StatesFrom::ALL.len() => "yes",
        _ => "with states_from \"phase-1\"",
    };
    MethodListing {
        name: method.name().to_owned(),
        about: about(method).to_owned(),
        trains: trains.to_owned(),
    }
}

fn about(method: Method) -> &'static str {
    match method {
        Method::Brownian => "Each command uniform in the action space",
        Method::Curiosity => "Evolved for the entropy of sensori-motor data (eq. 4.5)",
        Method::CuriosityA => "Evolved for the entropy of actuator data (eq. 4.5)",
        Method::Discovery => "Evolved for the differential entropy of sensori-motor data (eq. 4.6)",
        Method::DiscoveryA => "Evolved for the differential entropy of actuator data (eq. 4.6)",
        Method::Im => "Intrinsic motivation: the phase-3 controller with an empty repository",
        Method::EvIterC => "Ev-ITER after a phase 1 of curiosity",
        Method::EvIterD => "Ev-ITER after a phase 1 of discovery",
        Method::EvIterCa => "Ev-ITER after a phase 1 of curiosity-a",
        Method::EvIterDa => "Ev-ITER after a phase 1 of discovery-a",
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
