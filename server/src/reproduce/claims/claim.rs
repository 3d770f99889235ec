//! A claim, its tests and what came of them.

use schemars::JsonSchema;
use serde::Serialize;

/// One claim and what came of it.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Claim {
    pub claim: u32,
    pub text: &'static str,
    /// How it is tested.
    pub how: String,
    /// By all its tests but those at p10.
    pub verdict: Verdict,
    /// By its tests at p10; not tested where it has none.
    pub verdict_p10: Verdict,
    /// Why it is not tested, or what the verdict leaves out.
    pub reason: Option<String>,
    pub tests: Vec<Test>,
}

/// Which squares a test compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Those entered at least once, or something else than squares.
    P1,
    /// Those entered at least ten times.
    P10,
}

impl Level {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::P1 => "p1",
            Self::P10 => "p10",
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
