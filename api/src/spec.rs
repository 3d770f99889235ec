//! What a client posts: a run spec, and a job that sweeps one.
//!
//! Every field of a run spec is optional; the server fills in what is missing. The same type, with
//! every field present, is the resolved spec that is stored beside each run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

/// Version of the run spec, the job spec and the files that a run writes.
pub const SCHEMA: u32 = 1;

/// One simulation run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunSpec {
    /// Version of this format: [`SCHEMA`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<u32>,
    /// Seed of every random stream, at most 2^53 - 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Target arena, where visits count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arena: Option<ArenaRef>,
    /// How the robots learn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerSpec>,
    /// Counted epochs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epochs: Option<u32>,
    /// Control steps an epoch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps_per_epoch: Option<u32>,
    /// Robots in the arena.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robots: Option<u32>,
    /// `start`, `grid` or `random`; or an object, to place robots where no start pose reaches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placement: Option<PlacementSpec>,
    /// In place of the first start pose of the arena, and of the training arena; null for those.
    #[serde(default)]
    pub start: Option<StartSpec>,
    /// `reset`, `continue` or `continue-exploring`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub episodes: Option<String>,
    /// Body, wheels and sensors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotSpec>,
    /// `kinematic` or `rapier`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub engine: Option<String>,
    /// Bytes that each robot's learner may hold, a preset's name, or null for no budget.
    #[serde(default)]
    pub memory_budget_bytes: Value,
    /// Whether robots share what they learn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sharing: Option<SharingSpec>,
    /// What is recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub record: Option<RecordSpec>,
    /// Whether local programs can watch the run through shared memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<bool>,
}

/// An arena by name, or written out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ArenaRef {
    /// A built-in or uploaded arena.
    Name(String),
    /// An arena object; the server checks it.
    Inline(serde_json::Map<String, Value>),
}

/// A start pose; what is not given stays as the arena has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StartSpec {
    /// Metres from the left wall.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x_m: Option<f64>,
    /// Metres from the bottom wall.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_m: Option<f64>,
    /// Counter-clockwise from the x axis, radians.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading_rad: Option<f64>,
}

/// A method with its parameters beside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ControllerSpec {
    /// Name of the method, such as `ev-iter-c`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Named set of parameters that stand where none are given; a resolved spec has them instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// Where it trains, for the methods that do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub train: Option<TrainSpec>,
    /// Parameters by name; `GET /v1/controllers` lists them.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Value>,
}

/// Training of a controller.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrainSpec {
    /// Arena in which phase 1, or the evolution of a baseline, happens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arena: Option<ArenaRef>,
    /// Epochs of phase 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epochs: Option<u32>,
}

/// A robot preset with parameters that differ from it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RobotSpec {
    /// Name of the preset, such as `thesis`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// Parameters by name; `GET /v1/controllers` lists them.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Value>,
}

/// Sharing between robots.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SharingSpec {
    /// `none`, `arena` or `radio`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<String>,
    /// Greatest distance between two robots that hear each other, metres, null for no limit; with
    /// `radio` alone.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "present"
    )]
    pub range_m: Option<Option<f64>>,
    /// Bytes that a robot may tell in a step; with `radio` alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bytes_per_step: Option<u32>,
}

/// A field that is present, null included.
fn present<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Option<f64>>, D::Error> {
    Option::<f64>::deserialize(value).map(Some)
}

/// What a run records.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordSpec {
    /// Record every so many steps; 0 records nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_steps: Option<u64>,
    /// `"all"`, how many of the first, or a list of numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robots: Option<Value>,
    /// What of a robot: `pose`, `command`, `sensors`, `decision`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fields: Option<Vec<String>>,
}

/// A job: the product of a matrix over a base run and of seeds, or a prepared one by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JobSpec {
    /// Version of this format: [`SCHEMA`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<u32>,
    /// Any text, to recognise the job by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What all runs have in common.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<RunSpec>,
    /// Values to try by dotted path into the run spec, such as `controller.alpha`. Combined in
    /// alphabetical order of paths; the last path varies fastest.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub matrix: BTreeMap<String, Vec<Value>>,
    /// Seeds to repeat each combination with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seeds: Option<Seeds>,
    /// Instead of a matrix: jobs of their own, each with a base put over this one's.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<JobPart>,
    /// Name of a prepared job; stands alone, or with `name`, `base` and `seeds` that override its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub template: Option<String>,
}

/// A part of a job.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JobPart {
    /// Its name, no other part's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Put over the job's base, field by field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<RunSpec>,
    /// As of a job.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub matrix: BTreeMap<String, Vec<Value>>,
    /// As of a job, whose seeds it has where it says nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seeds: Option<Seeds>,
}

/// Seeds of a job.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Seeds {
    /// `count` seeds from `first` up.
    Range {
        /// The first seed.
        first: u64,
        /// How many.
        count: u64,
    },
    /// These.
    List(Vec<u64>),
}

/// Where robots stand when an epoch starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum PlacementSpec {
    /// `start`, `grid` or `random`.
    Kind(String),
    /// The same, with more said.
    Said {
        /// `grid` or `random`; `start` where nothing is anywhere.
        kind: String,
        /// Whether robots may stand where no start pose of the arena reaches.
        #[serde(default)]
        anywhere: bool,
    },
}
