//! Columns of the run spec: every field that is one value, under its dotted path, as in a job's
//! matrix. What a method or an arena does not have is empty.

use std::collections::BTreeSet;

use serde_json::Value;
use swarm::parameters::{Domain, Parameter};
use swarm::robot::RobotParameters;
use swarm::spec::{ControllerParameters, Method};

use crate::tables::{Cell, Column, Kind, real};

/// The fields that are no parameters. `seed`, `arena` and the method stand among the first columns.
const FIELDS: &[(&str, Kind)] = &[
    ("controller.method", Kind::Text),
    ("controller.train.arena", Kind::Text),
    ("controller.train.epochs", Kind::Whole),
    ("epochs", Kind::Whole),
    ("steps_per_epoch", Kind::Whole),
    ("robots", Kind::Whole),
    ("placement", Kind::Text),
    ("placement.anywhere", Kind::Truth),
    ("start.x_m", Kind::Real),
    ("start.y_m", Kind::Real),
    ("start.heading_rad", Kind::Real),
    ("episodes", Kind::Text),
    ("engine", Kind::Text),
    ("memory_budget_bytes", Kind::Whole),
    ("sharing.mode", Kind::Text),
    ("sharing.range_m", Kind::Real),
    ("sharing.bytes_per_step", Kind::Whole),
    ("record.every_steps", Kind::Whole),
    ("channels", Kind::Truth),
    ("robot.preset", Kind::Text),
];

pub fn columns() -> Vec<Column> {
    let fields = FIELDS.iter().map(|&(name, kind)| Column::new(name, kind));
    let own = Method::ALL
        .iter()
        .flat_map(|method| (method.definition().parameters)().table());
    let learner = ControllerParameters::TABLE.iter().chain(own);
    let learner = learner.map(|parameter| of_parameter("controller", parameter));
    let robot = RobotParameters::TABLE.iter();
    let robot = robot.map(|parameter| of_parameter("robot", parameter));
    let mut seen = BTreeSet::new();
    fields
        .chain(learner)
        .chain(robot)
        .filter(|column| seen.insert(column.name.clone()))
        .collect()
}

fn of_parameter(section: &str, parameter: &Parameter) -> Column {
    let kind = match parameter.domain {
        Domain::Real { .. } => Kind::Real,
        Domain::Whole { .. } => Kind::Whole,
        Domain::Choice { .. } => Kind::Text,
    };
    Column::new(format!("{section}.{}", parameter.name), kind)
}

/// The cells of a stored spec; empty ones where it is gone or cannot be read.
pub fn cells(spec: Option<&str>) -> Vec<Cell> {
    let spec = parsed(spec);
    let columns = columns().into_iter();
    columns.map(|column| cell(&spec, &column)).collect()
}

/// Length of a control step, seconds.
pub fn step_s(spec: Option<&str>) -> Option<f64> {
    parsed(spec).pointer("/robot/step_s")?.as_f64()
}

fn parsed(spec: Option<&str>) -> Value {
    let parsed = spec.and_then(|spec| serde_json::from_str(spec).ok());
    parsed.unwrap_or_default()
}

fn cell(spec: &Value, column: &Column) -> Cell {
    let pointer = format!("/{}", column.name.replace('.', "/"));
    let Some(value) = spec.pointer(&pointer) else {
        return Cell::Nothing;
    };
    match column.kind {
        Kind::Text => named(value).into(),
        Kind::Whole => value.as_u64().into(),
        Kind::Real => real(value.as_f64()),
        Kind::Truth => value.as_bool().into(),
    }
}

/// A name, or that of what is written out.
fn named(value: &Value) -> Option<&str> {
    let object = || {
        value
            .get("name")
            .or(value.get("kind"))
            .or(value.get("from"))
    };
    value.as_str().or_else(|| object()?.as_str())
}
