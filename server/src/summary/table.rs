//! A summary as CSV, and as a text in Markdown that reads well in a terminal too.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use super::escape::escaped;
use crate::tables::Decimal;
use std::collections::BTreeMap;
use std::fmt::Write;

use api::JobSummary;
use api::summary::{Group, Interval};
use serde_json::Value;

/// One line a group and measure.
pub fn csv(summary: &JobSummary) -> String {
    let mut text = String::from(
        "group,label,robots,measure,runs_done,n,mean,sd,median,low,high,level,method,missed,iqm,iqm_low,\
         iqm_high,iqm_method\n",
    );
    let number = Decimal;
    let low = |interval: &Option<Interval>| number(interval.as_ref().map(|it| it.low));
    let high = |interval: &Option<Interval>| number(interval.as_ref().map(|it| it.high));
    let method =
        |interval: &Option<Interval>| interval.clone().map_or(String::new(), |it| it.method);
    for (place, group) in summary.groups.iter().enumerate() {
        let label = quoted(&group.label);
        for measure in &group.measures {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{place},{label},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                group.robots,
                measure.name,
                group.runs_done,
                measure.n,
                number(measure.mean),
                number(measure.sd),
                number(measure.median),
                low(&measure.interval),
                high(&measure.interval),
                number(measure.interval.as_ref().map(|it| it.level)),
                method(&measure.interval),
                measure
                    .missed
                    .map_or(String::new(), |runs| runs.to_string()),
                number(measure.iqm),
                low(&measure.iqm_interval),
                high(&measure.iqm_interval),
                method(&measure.iqm_interval),
            );
        }
    }
    text
}

/// Tables of groups, scaling and sharing.
pub fn markdown(summary: &JobSummary) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "# Job {} {}\n\n{} of {} runs done. Means with 95 % intervals; n where not all of these runs have the measure, `-` where none has.\n",
        summary.job_id,
        escaped(&summary.name),
        summary.runs_done,
        summary.runs
    );
    odd_runs(&mut text, summary);
    let head = [
        "group",
        "n",
        "p1",
        "p10",
        "t50",
        "t90",
        "t99",
        "mean coverage",
        "overlap",
        "ns/robot-step",
    ];
    let rows: Vec<Vec<String>> = summary.groups.iter().map(row).collect();
    table(&mut text, &head, &rows);
    for scaling in &summary.scaling {
        let _ = writeln!(text, "\n## Scaling {}\n", words(&scaling.values));
        let mut rows = Vec::new();
        for point in &scaling.points {
            for time in &point.times {
                rows.push(vec![
                    point.robots.to_string(),
                    time.name.clone(),
                    time.n.to_string(),
                    short(time.mean_steps, 4),
                    with_interval(time.speed_up, time.speed_up_interval.as_ref()),
                    short(time.efficiency, 4),
                    short(time.against_independent, 4),
                ]);
            }
        }
        let head = [
            "robots",
            "time",
            "n",
            "steps",
            "speed-up",
            "efficiency",
            "against independent",
        ];
        table(&mut text, &head, &rows);
        for fit in &scaling.fits {
            let _ = writeln!(
                text,
                "\n{} = {} N^-b, b = {} ({} runs, {} never got there)",
                fit.name,
                short(Some(fit.a), 4),
                with_interval(Some(fit.b), fit.b_interval.as_ref()),
                fit.n,
                fit.missed
            );
        }
    }
    for sharing in &summary.sharing {
        let _ = writeln!(
            text,
            "\n## Sharing {} {}\n",
            sharing.mode,
            words(&sharing.values)
        );
        let rows: Vec<Vec<String>> = sharing
            .points
            .iter()
            .map(|point| {
                vec![
                    point.robots.to_string(),
                    point.pairs.to_string(),
                    with_interval(point.difference, point.interval.as_ref()),
                    point.verdict.clone(),
                ]
            })
            .collect();
        let head = ["robots", "pairs", "difference of mean coverage", "verdict"];
        table(&mut text, &head, &rows);
        let _ = writeln!(text, "\n{}.", sharing.verdict);
    }
    text
}

/// Runs that stand out, a line each.
fn odd_runs(text: &mut String, summary: &JobSummary) {
    if summary.odd_runs.is_empty() {
        return;
    }
    let _ = writeln!(text, "Runs that stand out:\n");
    for run in &summary.odd_runs {
        let id: String = run.run_id.chars().take(12).collect();
        let label = match run.label.as_str() {
            "" => String::new(),
            label => format!(" {}", escaped(label)),
        };
        let _ = write!(
            text,
            "- {id}{label} seed {}: p1 {}, the median of its group is {}",
            run.seed,
            run.p1,
            short(Some(run.median_p1), 4)
        );
        let _ = match &run.explanation {
            Some(why) => writeln!(text, ". {why}"),
            None => writeln!(text, "; `evswarm explain {}` says why", run.run_id),
        };
    }
    text.push('\n');
}

fn row(group: &Group) -> Vec<String> {
    let cell = |name: &str| {
        let measure = group.measures.iter().find(|measure| measure.name == name);
        measure.map_or("-".to_owned(), |measure| {
            let text = with_interval(measure.mean, measure.interval.as_ref());
            if measure.n == 0 || measure.n == group.runs_done {
                text
            } else {
                format!("{text}, n = {}", measure.n)
            }
        })
    };
    let label = if group.label.is_empty() {
        "all"
    } else {
        &group.label
    };
    let names = [
        "p1",
        "p10",
        "t50_steps",
        "t90_steps",
        "t99_steps",
        "mean_coverage",
        "overlap",
        "cpu_ns_per_robot_step",
    ];
    [
        escaped(label),
        format!("{}/{}", group.runs_done, group.runs),
    ]
    .into_iter()
    .chain(names.map(cell))
    .collect()
}

fn words(values: &BTreeMap<String, Value>) -> String {
    let words: Vec<String> = values
        .iter()
        .map(|(path, value)| format!("{path} {value}"))
        .collect();
    words.join(", ")
}

/// This many significant digits, and no more than all of a whole number's.
pub fn short(value: Option<f64>, significant: i32) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) => {
            let digits = (significant - 1 - value.abs().log10().floor() as i32).clamp(0, 9);
            format!("{value:.*}", digits as usize)
        }
    }
}

/// A figure with its interval.
pub fn with_interval(value: Option<f64>, interval: Option<&Interval>) -> String {
    match interval {
        Some(interval) => {
            format!(
                "{} [{}, {}]",
                short(value, 4),
                short(Some(interval.low), 4),
                short(Some(interval.high), 4)
            )
        }
        None => short(value, 4),
    }
}

/// A text as a field of a CSV line.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// A Markdown table with columns of even width.
pub fn table(text: &mut String, head: &[&str], rows: &[Vec<String>]) {
    let widths: Vec<usize> = (0..head.len())
        .map(|column| {
            let cells = rows.iter().map(|row| row[column].chars().count());
            cells.max().unwrap_or(0).max(head[column].len())
        })
        .collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let cells: Vec<String> = cells
            .zip(&widths)
            .map(|(cell, &width)| format!("{cell:<width$}"))
            .collect();
        format!("| {} |\n", cells.join(" | "))
    };
    text.push_str(&line(&mut head.iter().copied()));
    let rules: Vec<String> = widths.iter().map(|&width| "-".repeat(width)).collect();
    text.push_str(&line(&mut rules.iter().map(String::as_str)));
    for row in rows {
        text.push_str(&line(&mut row.iter().map(String::as_str)));
    }
}
