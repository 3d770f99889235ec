//! What the service offers: arenas, controllers with their parameters, prepared jobs.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// An arena in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ArenaListing {
    /// Name, as a run spec uses it.
    pub name: String,
    /// Whether it ships with the program; such an arena cannot be deleted.
    pub builtin: bool,
    /// Metres from left to right.
    pub width_m: f64,
    /// Metres from bottom to top.
    pub height_m: f64,
    /// Inner walls.
    pub walls: u64,
    /// Start poses.
    pub starts: u64,
    /// Columns and rows that visits are counted in.
    pub squares: crate::Squares,
    /// Squares that a robot of the default preset can reach from the first start pose.
    pub reachable: u32,
}

/// A method in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MethodListing {
    /// Name, as a run spec uses it.
    pub name: String,
    /// What it does.
    pub about: String,
    /// Equation, section or paper.
    pub source: String,
    /// Whether it takes a `train` block: `yes`, `no`, or on what it depends.
    pub trains: String,
    /// Parameters that it alone has, beside `controller.method`; absent where it has none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<ParameterListing>,
}

/// A parameter in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterListing {
    /// Name, as a run spec uses it.
    pub name: String,
    /// Value when a spec does not say.
    pub default: Value,
    /// What it may be, as `{"kind": "real" | "whole" | "choice", ...}`.
    pub domain: Value,
    /// SI unit, `1` for a pure number, or empty.
    pub unit: String,
    /// What it does.
    pub about: String,
    /// Equation, section or data sheet.
    pub source: String,
}

/// A named set of parameters that stand where a spec gives none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PresetListing {
    /// Name, for `controller.preset`.
    pub name: String,
    /// What it sets besides the defaults.
    pub parameters: BTreeMap<String, Value>,
}

/// Everything that `controller` and `robot` of a run spec may hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ControllerListing {
    /// Version of this format.
    pub schema: u32,
    /// Values of `controller.method`.
    pub methods: Vec<MethodListing>,
    /// Parameters beside `controller.method` that methods have in common.
    pub parameters: Vec<ParameterListing>,
    /// Values of `robot.preset`.
    pub presets: Vec<String>,
    /// Values of `controller.preset`, and what each sets.
    pub controller_presets: Vec<PresetListing>,
    /// Parameters beside `robot.preset`; defaults are those of the first preset.
    pub robot_parameters: Vec<ParameterListing>,
}

/// A prepared job in a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TemplateListing {
    /// Name, for `{"template": ...}`.
    pub name: String,
    /// What it runs.
    pub about: String,
    /// Runs that it makes.
    pub runs: u64,
    /// The job itself.
    pub job: Value,
}

/// Which program answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Version {
    /// Of the program.
    pub version: String,
    /// Of its results: runs of the same spec have the same id only where this is the same.
    pub results_version: u32,
    /// Of the documents that it takes and gives.
    pub schema: u32,
}

/// `GET /v1/arenas`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ArenaList {
    /// Those that ship with the program, then uploaded ones by name.
    pub items: Vec<ArenaListing>,
}

/// `GET /v1/templates`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TemplateList {
    /// All of them.
    pub items: Vec<TemplateListing>,
}

/// `GET /health/livez` and `/health/readyz`, where all is well.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Health {
    /// `ok`.
    pub status: String,
}
