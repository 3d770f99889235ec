//! A job's coverage over time, pooled by group: `GET /v1/jobs/{id}/curves`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The curves of every group, at the same abscissae.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JobCurves {
    /// Version of this format.
    pub schema: u32,
    /// Id of the job.
    pub job_id: String,
    /// Its name.
    pub name: String,
    /// What the curves show: `p1`, `p2`, `p5` or `p10`, squares; with `_fraction` behind it, these
    /// over the squares that can be reached.
    pub measure: String,
    /// What they run over: `epoch`.
    pub x: String,
    /// Field of the run spec whose values are the groups; null where each combination is one.
    pub by: Option<String>,
    /// How often a band holds the mean, at each x by itself; methods in `docs/statistics.md`.
    pub level: f64,
    /// Abscissae: counted epochs that are complete.
    pub at: Vec<u32>,
    /// The groups, in order.
    pub groups: Vec<GroupCurves>,
}

/// The curves of a group; lists have an entry for each abscissa.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroupCurves {
    /// What tells it from the others, in words.
    pub label: String,
    /// The same by dotted path.
    pub values: BTreeMap<String, Value>,
    /// Runs that are done, all of which are pooled.
    pub runs_done: u64,
    /// Runs that are as long.
    pub n: Vec<u64>,
    /// Their mean.
    pub mean: Vec<Option<f64>>,
    /// Lower end of the band of the mean; null of fewer than two runs.
    pub low: Vec<Option<f64>>,
    /// Upper end.
    pub high: Vec<Option<f64>>,
    /// Their median.
    pub median: Vec<Option<f64>>,
    /// Single runs, if they were asked for; at most 50, in order.
    pub runs: Vec<RunCurve>,
}

/// The curve of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunCurve {
    /// Its seed.
    pub seed: u64,
    /// Squares or shares, as far as the run went.
    pub values: Vec<Option<f64>>,
}

/// Where the runs of a group of a job went, over its arena.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroupCoverage {
    /// Version of this document.
    pub schema: u32,
    /// Id of the job.
    pub job_id: String,
    /// Place of the group among the job's, from 0.
    pub group: u64,
    /// Groups of the job.
    pub groups: u64,
    /// What the group's runs have in common.
    pub label: String,
    /// Finished runs that are pooled.
    pub n: u64,
    /// Columns and rows of squares.
    pub squares: [u32; 2],
    /// Squares that some run of the group entered.
    pub union_squares: u32,
    /// Mean of the squares that a run entered.
    pub mean_squares: f64,
    /// Runs that entered each square, row by row, the lowest y first.
    pub runs: Vec<Vec<u32>>,
    /// Mean entries of each square, in the same order.
    pub mean_entries: Vec<Vec<f32>>,
}
