//! A comparison as CSV and as Markdown.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use crate::summary::escape::escaped;
use crate::tables::Decimal;
use std::fmt::Write;

use api::comparison::Comparison;
use api::summary::Interval;

use super::super::table::{quoted, short, table, with_interval};

/// One line a pair.
pub fn csv(comparison: &Comparison) -> String {
    let mut text = String::from(
        "measure,first,second,paired,n,missed,difference,low,high,level,method,improvement,\
         improvement_low,improvement_high,p,test,p_holm,differs,runs_needed\n",
    );
    let number = Decimal;
    let low = |interval: &Option<Interval>| number(interval.as_ref().map(|it| it.low));
    let high = |interval: &Option<Interval>| number(interval.as_ref().map(|it| it.high));
    for pair in &comparison.pairs {
        let label = |place: usize| quoted(&comparison.groups[place].label);
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            comparison.measure,
            label(pair.first),
            label(pair.second),
            pair.paired,
            pair.n,
            pair.missed,
            number(pair.difference),
            low(&pair.interval),
            high(&pair.interval),
            number(pair.interval.as_ref().map(|it| it.level)),
            pair.interval.as_ref().map_or("", |it| it.method.as_str()),
            number(pair.improvement),
            low(&pair.improvement_interval),
            high(&pair.improvement_interval),
            number(pair.p),
            quoted(pair.test.as_deref().unwrap_or_default()),
            number(pair.p_holm),
            pair.differs,
            pair.runs_needed
                .map_or(String::new(), |runs| runs.to_string()),
        );
    }
    text
}

/// The verdict, the groups, and every pair.
pub fn markdown(comparison: &Comparison) -> String {
    let by = comparison
        .by
        .as_ref()
        .map_or(String::new(), |by| format!(", by {by}"));
    let mut text = format!(
        "# Job {} {}: {}{by}\n\n{}.\n\n",
        comparison.job_id,
        escaped(&comparison.name),
        comparison.measure,
        comparison.verdict
    );
    let rows: Vec<Vec<String>> = comparison
        .groups
        .iter()
        .map(|group| {
            vec![
                escaped(&group.label),
                group.n.to_string(),
                group
                    .missed
                    .map_or("-".to_owned(), |missed| missed.to_string()),
                with_interval(group.mean, group.interval.as_ref()),
                short(group.sd, 4),
                short(group.median, 4),
                with_interval(group.iqm, group.iqm_interval.as_ref()),
            ]
        })
        .collect();
    let head = [
        "group",
        "n",
        "never got there",
        "mean",
        "sd",
        "median",
        "interquartile mean",
    ];
    table(&mut text, &head, &rows);
    text.push('\n');
    let rows: Vec<Vec<String>> = comparison
        .pairs
        .iter()
        .map(|pair| {
            let labels = [pair.first, pair.second].map(|place| &comparison.groups[place].label);
            vec![
                escaped(&format!("{} - {}", labels[0], labels[1])),
                pair.n.to_string(),
                with_interval(pair.difference, pair.interval.as_ref()),
                with_interval(pair.improvement, pair.improvement_interval.as_ref()),
                short(pair.p_holm, 2),
            ]
        })
        .collect();
    let head = ["pair", "n", "difference", "chance to be better", "p (Holm)"];
    table(&mut text, &head, &rows);
    text.push('\n');
    for pair in &comparison.pairs {
        let _ = writeln!(text, "- {}", pair.sentence);
    }
    text
}
