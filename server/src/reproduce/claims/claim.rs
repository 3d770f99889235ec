//! A claim, its tests and what came of them.

use schemars::JsonSchema;
use serde::Serialize;

use crate::reproduce::results::Finding;

/// One claim and what came of it.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Claim {
    pub claim: u32,
    pub text: &'static str,
    /// How it is tested.
    pub how: String,
    /// By its tests at p1 and those of something else than squares.
    pub verdict: Verdict,
    /// By its tests at p10; not tested where it has none.
    pub verdict_p10: Verdict,
    /// By its tests of coverage over time; not tested where it has none.
    pub verdict_over_time: Verdict,
    /// Why it is not tested, or what the verdict leaves out.
    pub reason: Option<String>,
    pub tests: Vec<Test>,
}

/// Which squares a test compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// Those entered at least once, or something else than squares.
    P1,
    /// Those entered at least ten times.
    P10,
    /// p1 after each epoch, averaged over the epochs: larger if the same squares come sooner.
    OverTime,
}

impl Level {
    /// Every one.
    pub const ALL: [Self; 3] = [Self::P1, Self::P10, Self::OverTime];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::P1 => "p1",
            Self::P10 => "p10",
            Self::OverTime => "p1 over time",
        }
    }

    /// Squares of a run.
    pub fn squares(self, run: &Finding) -> f64 {
        match self {
            Self::P1 => f64::from(run.result.p1),
            Self::P10 => f64::from(run.result.p10),
            Self::OverTime => run.p1_over_time(),
        }
    }
}

/// One test of a claim.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Test {
    /// Name of the arena, or of the two that are compared.
    pub arena: String,
    pub hypothesis: String,
    pub level: Level,
    pub test: &'static str,
    /// Runs in each sample.
    pub n: Vec<usize>,
    /// U of the first sample, or runs that meet the condition.
    pub statistic: f64,
    /// One-sided; `None` for a bare count.
    pub p: Option<f64>,
    /// p after Holm's correction over all tests of the table.
    pub p_holm: Option<f64>,
    /// p for the opposite, corrected over all opposites.
    pub p_opposite_holm: Option<f64>,
    #[serde(skip)]
    pub(super) p_opposite: Option<f64>,
    /// What `effect` is.
    pub effect_size: &'static str,
    pub effect: f64,
    /// Median of the first sample less that of the second, in `unit`.
    pub median_difference: Option<f64>,
    pub unit: Option<&'static str>,
    pub verdict: Verdict,
}

/// What came of a claim or of one of its tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The test in the claim's direction is significant; for a claim, all of them.
    Reproduced,
    /// Neither direction is significant.
    Inconclusive,
    /// The opposite is significant; for a claim, in at least one of its tests.
    Contradicted,
    /// There are no runs that it could be tested on.
    NotTested,
}

impl Verdict {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Inconclusive => "inconclusive",
            Self::Contradicted => "contradicted",
            Self::NotTested => "not tested",
        }
    }
}
