//! The values of metrics by name, wherever they show.

use super::counted::Counted;
use super::metric::{Metric, Shown, Value};
use super::table::METRICS;

/// The counted metrics that show somewhere, in the order of the table.
fn counted(there: Shown) -> impl Iterator<Item = &'static Metric> {
    METRICS
        .iter()
        .filter(move |metric| metric.is_counted(there))
}

/// Counted metrics that show over time.
const OVER_TIME: usize = {
    let (mut count, mut place) = (0, 0);
    while place < METRICS.len() {
        count += METRICS[place].is_counted(Shown::OverTime) as usize;
        place += 1;
    }
    count
};

/// A value of each counted metric that shows over time, in the order of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowValues([Option<Value>; OVER_TIME]);

impl RowValues {
    /// What has been counted so far.
    pub fn of(now: &Counted<'_>) -> Self {
        Self::from_metrics(|metric| metric.value(now))
    }

    /// From values by name; `None` for a metric that is not defined, or was not known when the row
    /// was made.
    pub fn from_names(mut value: impl FnMut(&'static str) -> Option<Value>) -> Self {
        Self::from_metrics(|metric| value(metric.name))
    }

    fn from_metrics(mut value: impl FnMut(&'static Metric) -> Option<Value>) -> Self {
        let mut values = [None; OVER_TIME];
        for (kept, metric) in values.iter_mut().zip(counted(Shown::OverTime)) {
            *kept = value(metric);
        }
        Self(values)
    }

    /// Names and values.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, Option<Value>)> {
        let names = counted(Shown::OverTime).map(|metric| metric.name);
        names.zip(self.0)
    }

    /// A value by name.
    pub fn get(&self, name: &str) -> Option<Value> {
        self.iter().find(|(known, _)| *known == name)?.1
    }
}

/// Names of the counted metrics that show over time: those of every [`RowValues`].
pub fn over_time() -> impl Iterator<Item = &'static str> {
    counted(Shown::OverTime).map(|metric| metric.name)
}

/// Names and values of the counted metrics that show at the end of a run.
pub fn at_end(end: &Counted<'_>) -> Vec<(&'static str, Option<Value>)> {
    counted(Shown::AtEnd)
        .map(|metric| (metric.name, metric.value(end)))
        .collect()
}

/// Names of the metrics that a summary pools.
pub fn pooled() -> impl Iterator<Item = &'static str> {
    let pooled = METRICS.iter().filter(|metric| metric.shows(Shown::Summary));
    pooled.map(|metric| metric.name)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn names_are_unique_and_values_keep_their_order() {
        for (place, metric) in METRICS.iter().enumerate() {
            let before = METRICS[..place].iter();
            assert!(before.clone().all(|other| other.name != metric.name));
            assert!(!metric.shown.is_empty(), "{} shows nowhere", metric.name);
        }
        let mut next = 0;
        let values = RowValues::from_names(|_| {
            next += 1;
            Some(Value::Count(next))
        });
        assert_eq!(next as usize, OVER_TIME);
        for (place, name) in over_time().enumerate() {
            assert_eq!(values.get(name), Some(Value::Count(place as u64 + 1)));
        }
        assert_eq!(values.get("no such metric"), None);
    }

    /// The lines of the table in `docs/metrics.md`.
    fn documented() -> String {
        let mut lines = "| Name | Unit | Formula | Shown |\n|---|---|---|---|\n".to_owned();
        for metric in METRICS {
            let shown: Vec<&str> = metric.shown.iter().map(|shown| shown.words()).collect();
            let cells = [metric.unit, metric.formula, &shown.join(", ")].join(" | ");
            lines.push_str(&format!("| `{}` | {cells} |\n", metric.name));
        }
        lines
    }

    /// With `EVSWARM_WRITE_DOCS` set, the table is written anew first.
    #[test]
    fn the_table_in_the_documentation_is_this_one() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/metrics.md");
        let text = std::fs::read_to_string(path).unwrap();
        let begin = text.find("| Name | Unit |").unwrap();
        let table = &text[begin..];
        let table = &table[..table.find("\n\n").unwrap() + 1];
        if std::env::var_os("EVSWARM_WRITE_DOCS").is_some() {
            std::fs::write(path, text.replacen(table, &documented(), 1)).unwrap();
            return;
        }
        assert!(
            table == documented(),
            "docs/metrics.md has another table of metrics: write it anew with \
             EVSWARM_WRITE_DOCS=1 cargo test --release -p swarm metrics"
        );
    }
}
