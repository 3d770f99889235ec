//! What a metric is: name, unit, formula, where it shows and where its value comes from.

use serde::{Deserialize, Serialize};

use super::counted::Counted;

/// The value of a metric.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// Of steps, squares or robots.
    Count(u64),
    /// Anything else.
    Real(f64),
}

/// Where a metric shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// In each row of `metrics.csv` and of its route.
    OverTime,
    /// In `result.json`.
    AtEnd,
    /// In a job's summary, pooled over seeds.
    Summary,
}

impl Shown {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::OverTime => "over time",
            Self::AtEnd => "at the end",
            Self::Summary => "summary",
        }
    }
}

/// Where the value of a metric comes from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// Computed from what the robots did; `None` where it is not defined.
    Counted(fn(&Counted<'_>) -> Option<Value>),
    /// A field that every row or result has besides its metrics, or made of such fields.
    Fields,
}

/// A metric.
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// Its name in JSON and CSV.
    pub name: &'static str,
    /// SI unit, what is counted, or `1`.
    pub unit: &'static str,
    /// In Markdown; symbols as in `docs/metrics.md`.
    pub formula: &'static str,
    /// Where it shows.
    pub shown: &'static [Shown],
    /// Where its value comes from.
    pub source: Source,
}

impl Metric {
    /// Whether it shows there.
    pub const fn shows(&self, there: Shown) -> bool {
        let mut place = 0;
        while place < self.shown.len() {
            if self.shown[place] as u8 == there as u8 {
                return true;
            }
            place += 1;
        }
        false
    }

    pub(super) const fn is_counted(&self, there: Shown) -> bool {
        matches!(self.source, Source::Counted(_)) && self.shows(there)
    }

    pub(super) fn value(&self, counted: &Counted<'_>) -> Option<Value> {
        match self.source {
            Source::Counted(value) => value(counted),
            Source::Fields => None,
        }
    }
}
