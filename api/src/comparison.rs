//! A job's groups against each other by one measure: `GET /v1/jobs/{id}/comparison`. Methods in
//! `docs/statistics.md`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::summary::Interval;

/// Every group against every other, and which is best.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// Version of this format.
    pub schema: u32,
    /// Id of the job.
    pub job_id: String,
    /// Its name.
    pub name: String,
    /// What is compared, such as `p1_fraction`.
    pub measure: String,
    /// What of it is better; null where neither is.
    pub better: Option<Better>,
    /// Field of the run spec whose values are the groups; null where each combination is one.
    pub by: Option<String>,
    /// Level of significance of all pairs together.
    pub alpha: f64,
    /// The groups, in order.
    pub groups: Vec<ComparedGroup>,
    /// Abscissae of the performance profiles.
    pub taus: Vec<f64>,
    /// Every pair of groups, in order.
    pub pairs: Vec<ComparedPair>,
    /// Place of the best group, if one is known to be best.
    pub best: Option<usize>,
    /// Which is best, or that it cannot be said yet, in one sentence.
    pub verdict: String,
    /// Runs of each group (seeds times what is pooled) that would say it; null where it is said, or
    /// where so many would be needed that it is not worth it.
    pub runs_needed: Option<u64>,
}

/// What of a measure is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Better {
    /// More.
    Higher,
    /// Less.
    Lower,
}

/// A group's runs by the measure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparedGroup {
    /// What tells it from the others, in words.
    pub label: String,
    /// The same by dotted path.
    pub values: BTreeMap<String, Value>,
    /// Runs that are done.
    pub runs_done: u64,
    /// Those that have the measure; all other figures but the profile are of these alone.
    pub n: u64,
    /// Runs that never got there, where the measure is a time.
    pub missed: Option<u64>,
    /// Mean.
    pub mean: Option<f64>,
    /// Sample standard deviation.
    pub sd: Option<f64>,
    /// Median.
    pub median: Option<f64>,
    /// Of the mean.
    pub interval: Option<Interval>,
    /// Mean without the lowest and the highest quarter.
    pub iqm: Option<f64>,
    /// Its interval, strata drawn anew each by itself.
    pub iqm_interval: Option<Interval>,
    /// Performance profile: share of the runs above each tau; of a time, that got there within it.
    pub profile: Vec<f64>,
}

/// A group against another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparedPair {
    /// Place of the first group.
    pub first: usize,
    /// Place of the second.
    pub second: usize,
    /// Whether runs were paired by seed (and by what else varies); else the groups are two samples.
    pub paired: bool,
    /// Pairs, or runs of the smaller group.
    pub n: u64,
    /// Of them, pairs in which a run never got there; 0 where the measure is no time.
    pub missed: u64,
    /// Mean of the first less that of the second, of those that got there.
    pub difference: Option<f64>,
    /// Its interval.
    pub interval: Option<Interval>,
    /// Probability that a run of the first is better than one of the second (higher, where neither
    /// is better); ties count half.
    pub improvement: Option<f64>,
    /// Its interval.
    pub improvement_interval: Option<Interval>,
    /// Two-sided.
    pub p: Option<f64>,
    /// Name of the test.
    pub test: Option<String>,
    /// After Holm's correction over all pairs.
    pub p_holm: Option<f64>,
    /// Whether they differ: `p_holm` is below alpha.
    pub differs: bool,
    /// Runs of each group at which a difference as large as this one would be found; null where it
    /// was found, or beyond 200.
    pub runs_needed: Option<u64>,
    /// All of it in one sentence.
    pub sentence: String,
}
