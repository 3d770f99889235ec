//! The schema of a run spec.

use serde_json::{Map, Value, json};
use swarm::methods::Trains;
use swarm::parameters::{Domain, Parameter, Shown};
use swarm::robot::RobotParameters;
use swarm::spec::{ControllerParameters, DEFAULT_RANGE_M, Method};

use super::about::object;
use super::common::{reference, schema_link};
use crate::documents::controller::{
    CONTROLLER_PRESET, DEFAULT_TRAINING_ARENA, METHOD, PRESET, TRAINING_EPOCHS,
};
use crate::documents::learning::{BUDGET, BUDGETS, BYTES_PER_STEP, MODE, MOST_RANGE_M};
use crate::documents::listing::shown_value;
use crate::documents::placement::{ANYWHERE, KIND, KIND_ALONE};
use crate::documents::record::{EVERY_STEPS, field_names};
use crate::documents::resolve::{
    CHANNELS, DEFAULT_ARENA, ENGINE, EPISODES, EPOCHS, ROBOTS, SEED, STEPS_PER_EPOCH, VERSION,
};
use crate::documents::start::{MOST_M, MOST_RAD};

/// `RunSpec`, `RunFields` (a part of one) and what they are made of.
pub fn definitions(prefix: &str) -> Map<String, Value> {
    [
        ("RunSpec", run(prefix)),
        ("RunFields", fields(prefix)),
        ("Controller", controller(prefix)),
        ("Robot", robot()),
        ("SharingSpec", sharing()),
    ]
    .into_iter()
    .map(|(name, schema)| (name.to_owned(), schema))
    .collect()
}

/// All of a run: fields that only go together must.
fn run(prefix: &str) -> Value {
    json!({
        "description": "A run. It says only what differs from the defaults.",
        "$ref": format!("{prefix}RunFields"),
        "properties": {
            "controller": { "dependentSchemas": only_with_methods() },
            "sharing": { "dependentSchemas": {
                "range_m": { "properties": { "mode": { "const": "radio" } }, "required": ["mode"] },
                "bytes_per_step": { "properties": { "mode": { "const": "radio" } }, "required": ["mode"] },
            } },
        },
    })
}

fn fields(prefix: &str) -> Value {
    let arena = |default: &str| {
        let mut arena = reference(prefix, "ArenaRef");
        arena["default"] = json!(default);
        arena
    };
    object::<api::RunSpec>([
        ("$schema", schema_link()),
        (VERSION.name, VERSION.schema()),
        (SEED.name, SEED.schema()),
        ("arena", arena(DEFAULT_ARENA)),
        ("controller", reference(prefix, "Controller")),
        (EPOCHS.name, EPOCHS.schema()),
        (STEPS_PER_EPOCH.name, STEPS_PER_EPOCH.schema()),
        (ROBOTS.name, ROBOTS.schema()),
        ("placement", placement()),
        ("start", start()),
        (EPISODES.name, EPISODES.schema()),
        ("robot", reference(prefix, "Robot")),
        (ENGINE.name, ENGINE.schema()),
        (BUDGET.name, budget()),
        ("sharing", reference(prefix, "SharingSpec")),
        (
            "record",
            object::<api::RecordSpec>([
                (EVERY_STEPS.name, EVERY_STEPS.schema()),
                (
                    "robots",
                    json!({ "anyOf": [
                        { "const": "all" },
                        { "type": "integer", "minimum": 1, "maximum": ROBOTS.max },
                        { "type": "array", "minItems": 1, "uniqueItems": true,
                            "items": { "type": "integer", "minimum": 0, "maximum": ROBOTS.max - 1 } },
                    ], "default": "all" }),
                ),
                (
                    "fields",
                    json!({ "type": "array", "minItems": 1, "items": { "enum": field_names() } }),
                ),
            ]),
        ),
        (CHANNELS.name, CHANNELS.schema()),
    ])
}

fn controller(prefix: &str) -> Value {
    let mut arena = reference(prefix, "ArenaRef");
    arena["default"] = json!(DEFAULT_TRAINING_ARENA);
    let train = object::<api::TrainSpec>([
        ("arena", arena),
        (TRAINING_EPOCHS.name, TRAINING_EPOCHS.schema()),
    ]);
    let mut fields = vec![
        (METHOD.name, METHOD.schema()),
        (CONTROLLER_PRESET.name, CONTROLLER_PRESET.schema()),
        ("train", train),
    ];
    let defaults = ControllerParameters::default().shown();
    fields.extend(parameters(ControllerParameters::TABLE, &defaults));
    for &method in Method::ALL {
        let own = (method.definition().parameters)();
        fields.extend(parameters(own.table(), own.shown()));
    }
    object::<api::ControllerSpec>(fields)
}

fn robot() -> Value {
    let mut fields = vec![(PRESET.name, PRESET.schema())];
    let defaults = RobotParameters::default().shown();
    fields.extend(parameters(RobotParameters::TABLE, &defaults));
    object::<api::RobotSpec>(fields)
}

/// Parameters of a table, whose defaults are in table order.
fn parameters(
    table: &'static [Parameter],
    defaults: &[(&'static str, Shown)],
) -> Vec<(&'static str, Value)> {
    let told = |(parameter, (_, default)): (&Parameter, &(&str, Shown))| {
        let mut schema = match parameter.domain {
            Domain::Real { min, max } => {
                json!({ "type": "number", "minimum": min, "maximum": max })
            }
            Domain::Whole { min, max } => {
                json!({ "type": "integer", "minimum": min, "maximum": max })
            }
            Domain::Choice { names } => json!({ "enum": names }),
        };
        let unit = match parameter.unit {
            "" | "1" => String::new(),
            unit => format!(", {unit}"),
        };
        let about = format!("{}{unit} ({})", parameter.about, parameter.source);
        schema["description"] = json!(about);
        schema["default"] = shown_value(*default);
        (parameter.name, schema)
    };
    table.iter().zip(defaults).map(told).collect()
}

/// Fields of a controller that only some methods have, with what the others then must be.
fn only_with_methods() -> Value {
    let method_in = |methods: Vec<&str>| {
        let mut schema = json!({ "properties": { (METHOD.name): { "enum": methods } } });
        if !methods.contains(&(METHOD.shown)(METHOD.default)) {
            schema["required"] = json!([METHOD.name]);
        }
        schema
    };
    let mut fields = Map::new();
    let trains = |wanted: fn(Trains) -> bool| {
        let methods = Method::ALL.iter();
        methods
            .filter(|method| wanted(method.definition().trains))
            .map(|method| method.name())
            .collect::<Vec<_>>()
    };
    let mut by_phase_1 = method_in(trains(|trains| trains == Trains::WithPhase1States));
    by_phase_1["properties"]["states_from"] = json!({ "const": "phase-1" });
    by_phase_1["required"] = json!([METHOD.name, "states_from"]);
    fields.insert(
        "train".to_owned(),
        json!({ "anyOf": [method_in(trains(|trains| trains == Trains::Always)), by_phase_1] }),
    );
    let tables = Method::ALL
        .iter()
        .map(|method| (method.definition().parameters)());
    for name in tables.flat_map(|own| own.table().iter().map(|parameter| parameter.name)) {
        let has = |method: &&Method| {
            let own = (method.definition().parameters)();
            own.table().iter().any(|parameter| parameter.name == name)
        };
        let methods = Method::ALL.iter().filter(has).map(|method| method.name());
        fields.insert(name.to_owned(), method_in(methods.collect()));
    }
    Value::Object(fields)
}

fn placement() -> Value {
    let said = object::<api::PlacementSpec>([
        (KIND.name, KIND.schema()),
        (ANYWHERE.name, ANYWHERE.schema()),
    ]);
    let default = (KIND_ALONE.shown)(KIND_ALONE.default);
    json!({ "anyOf": [{ "enum": KIND_ALONE.names }, said], "default": default })
}

fn start() -> Value {
    let place = json!({ "type": "number", "minimum": 0, "maximum": MOST_M });
    let heading = json!({ "type": "number", "minimum": -MOST_RAD, "maximum": MOST_RAD });
    let pose = object::<api::StartSpec>([
        ("x_m", place.clone()),
        ("y_m", place),
        ("heading_rad", heading),
    ]);
    json!({ "anyOf": [pose, { "type": "null" }], "default": null })
}

fn budget() -> Value {
    let names = BUDGETS.map(|(name, _)| name);
    json!({
        "anyOf": [
            { "type": "integer", "minimum": BUDGET.min, "maximum": BUDGET.max },
            { "enum": names },
            { "type": "null" },
        ],
        "default": null,
    })
}

fn sharing() -> Value {
    let range = json!({
        "anyOf": [{ "type": "number", "minimum": 0, "maximum": MOST_RANGE_M }, { "type": "null" }],
        "default": DEFAULT_RANGE_M,
    });
    object::<api::SharingSpec>([
        (MODE.name, MODE.schema()),
        ("range_m", range),
        (BYTES_PER_STEP.name, BYTES_PER_STEP.schema()),
    ])
}
