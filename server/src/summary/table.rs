//! A summary as CSV, and as a text in Markdown that reads well in a terminal too.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::collections::BTreeMap;
use std::fmt::Write;

use api::JobSummary;
use api::summary::Group;
use serde_json::Value;

/// One line a group and measure.
pub fn csv(summary: &JobSummary) -> String {
    let mut text = String::from("group,label,robots,measure,runs_done,n,mean,sd,median,low,high\n");
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for (place, group) in summary.groups.iter().enumerate() {
        let label = group.label.replace('"', "\"\"");
        for measure in &group.measures {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{place},\"{label}\",{},{},{},{},{},{},{},{},{}",
                group.robots,
                measure.name,
                group.runs_done,
                measure.n,
                number(measure.mean),
                number(measure.sd),
                number(measure.median),
                number(measure.interval.map(|interval| interval[0])),
                number(measure.interval.map(|interval| interval[1])),
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
        "# Job {} {}\n\n{} of {} runs done. Means with 95 % bootstrap intervals; `-` where no run has the measure.\n",
        summary.job_id, summary.name, summary.runs_done, summary.runs
    );
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
                    short(time.mean_steps),
                    with_interval(time.speed_up, time.speed_up_interval),
                    short(time.efficiency),
                    short(time.against_independent),
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
                short(Some(fit.a)),
                with_interval(Some(fit.b), fit.b_interval),
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
                    with_interval(point.difference, point.interval),
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

fn row(group: &Group) -> Vec<String> {
    let cell = |name: &str| {
        let measure = group.measures.iter().find(|measure| measure.name == name);
        measure.map_or("-".to_owned(), |measure| {
            with_interval(measure.mean, measure.interval)
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
        label.replace('|', "/"),
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

/// Four significant digits.
fn short(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) => {
            let digits = (3 - value.abs().log10().floor() as i32).clamp(0, 9);
            format!("{value:.*}", digits as usize)
        }
    }
}

fn with_interval(value: Option<f64>, interval: Option<[f64; 2]>) -> String {
    match interval {
        Some([low, high]) => {
            format!(
                "{} [{}, {}]",
                short(value),
                short(Some(low)),
                short(Some(high))
            )
        }
        None => short(value),
    }
}

/// A Markdown table with columns of even width.
fn table(text: &mut String, head: &[&str], rows: &[Vec<String>]) {
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
