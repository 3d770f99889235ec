//! A job's runs pooled over seeds: `GET /v1/jobs/{id}/summary`. Formulas in `docs/metrics.md`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A job's results by combination of its matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JobSummary {
    /// Version of this format.
    pub schema: u32,
    /// Id of the job.
    pub job_id: String,
    /// Its name.
    pub name: String,
    /// Runs in all.
    pub runs: u64,
    /// Runs that are done; only these are summed up.
    pub runs_done: u64,
    /// Runs that stand out, those that covered least of what was to be expected first; a hundred at
    /// most.
    pub odd_runs: Vec<OddRun>,
    /// One for each combination, in order.
    pub groups: Vec<Group>,
    /// How results change with the number of robots; empty where that does not vary.
    pub scaling: Vec<Scaling>,
    /// What sharing changes; empty where `sharing.mode` does not vary or lacks `none`.
    pub sharing: Vec<Sharing>,
}

/// A run that covered far less or more than those of its group, or whose explanation calls it odd.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OddRun {
    /// Its id.
    pub run_id: String,
    /// Place in the job.
    pub index: u64,
    /// What of the matrix it has, in words.
    pub label: String,
    /// Seed.
    pub seed: u64,
    /// Squares that it entered.
    pub p1: u32,
    /// The median of its group.
    pub median_p1: f64,
    /// How far it is from the median: 0.6745 of the distance over the median distance; null where
    /// the group has fewer than five runs that are done or these hardly differ.
    pub score: Option<f64>,
    /// Whether the score is beyond 3.5 or -3.5.
    pub is_outlier: bool,
    /// Why it did what it did, where that was asked for: `/v1/runs/{id}/explain`.
    pub explanation: Option<String>,
}

/// The runs of one combination.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Group {
    /// What of the matrix it has, in words.
    pub label: String,
    /// The same by dotted path.
    pub values: BTreeMap<String, Value>,
    /// Robots.
    pub robots: u32,
    /// Runs in all.
    pub runs: u64,
    /// Runs that are done.
    pub runs_done: u64,
    /// One for each measure.
    pub measures: Vec<Measure>,
}

/// A measure over the runs of a group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Measure {
    /// Its name, such as `p1` or `t90_steps`.
    pub name: String,
    /// Runs that have it: a run that never covered 90 % has no `t90_steps`. All other figures are of
    /// these runs alone.
    pub n: u64,
    /// Runs that never got there, where the measure is a time; null where it is none.
    pub missed: Option<u64>,
    /// Mean, sample standard deviation and median; null of no runs (deviation: of fewer than two).
    pub mean: Option<f64>,
    /// As above.
    pub sd: Option<f64>,
    /// As above.
    pub median: Option<f64>,
    /// Of the mean; null of fewer than two runs.
    pub interval: Option<Interval>,
    /// Mean without the lowest and the highest quarter of the runs.
    pub iqm: Option<f64>,
    /// Its interval.
    pub iqm_interval: Option<Interval>,
}

/// An interval, and how it was made; methods in `docs/statistics.md`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// How often such intervals hold what they are of, such as 0.95.
    pub level: f64,
    /// Name of the method.
    pub method: String,
}

/// Groups that differ in the number of robots (and what varies with it) alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Scaling {
    /// What they have in common, by dotted path.
    pub values: BTreeMap<String, Value>,
    /// Paths that vary, `robots` among them.
    pub paths: Vec<String>,
    /// In order of robots.
    pub points: Vec<ScalingPoint>,
    /// One for each of `t50_steps`, `t90_steps` and `t99_steps` that two numbers of robots have.
    pub fits: Vec<PowerLaw>,
}

/// One number of robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScalingPoint {
    /// Robots.
    pub robots: u32,
    /// Mean processor time a robot-step, nanoseconds.
    pub cpu_ns_per_robot_step: Option<f64>,
    /// One for each of `t50_steps`, `t90_steps` and `t99_steps`.
    pub times: Vec<SpeedUp>,
}

/// A coverage time against that of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpeedUp {
    /// `t50_steps`, `t90_steps` or `t99_steps`.
    pub name: String,
    /// Runs that got there.
    pub n: u64,
    /// Their mean, steps.
    pub mean_steps: Option<f64>,
    /// Mean time of one robot over this one.
    pub speed_up: Option<f64>,
    /// Its interval.
    pub speed_up_interval: Option<Interval>,
    /// Speed-up over the number of robots.
    pub efficiency: Option<f64>,
    /// Mean time, steps, of as many robots that do not meet: the union of runs of one robot each.
    /// Null where the arena varies too, or where there are fewer such runs than robots.
    pub independent_steps: Option<f64>,
    /// That time over `mean_steps`: above 1 the swarm is faster than robots that do not meet.
    pub against_independent: Option<f64>,
}

/// t = a N^-b, by least squares of ln t on ln N over all runs that got there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PowerLaw {
    /// `t50_steps`, `t90_steps` or `t99_steps`.
    pub name: String,
    /// Steps for one robot.
    pub a: f64,
    /// Exponent: 1 where twice the robots take half the time.
    pub b: f64,
    /// Its interval; null of two runs.
    pub b_interval: Option<Interval>,
    /// Runs that got there, and runs that did not.
    pub n: u64,
    /// As above.
    pub missed: u64,
}

/// A mode of sharing against none, all else equal, over numbers of robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sharing {
    /// `arena` or `radio`.
    pub mode: String,
    /// What the runs have in common, by dotted path.
    pub values: BTreeMap<String, Value>,
    /// In order of robots.
    pub points: Vec<SharingPoint>,
    /// Whether sharing helps, in one sentence.
    pub verdict: String,
}

/// The differences at one number of robots, paired by seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SharingPoint {
    /// Robots.
    pub robots: u32,
    /// Pairs of runs.
    pub pairs: u64,
    /// Mean of `mean_coverage` with sharing less that without.
    pub difference: Option<f64>,
    /// Its interval; null of fewer than two pairs.
    pub interval: Option<Interval>,
    /// `helps`, `hurts`, `no difference found` or `too few seeds`.
    pub verdict: String,
}
