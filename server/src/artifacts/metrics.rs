//! Swarm metrics as JSON types and CSV text: whatever the table in `swarm::metrics` has.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use api::{MetricValues, Metrics, MetricsRow, SCHEMA};
use serde_json::Number;
use swarm::metrics::{Value, over_time};
use swarm::run::MetricsLog;

use super::fractions::fractions;
use crate::tables::Decimal;

/// Metrics by name.
pub fn metric_values<'a>(values: impl Iterator<Item = (&'a str, Option<Value>)>) -> MetricValues {
    let number = |value| match value {
        Value::Count(count) => Some(Number::from(count)),
        Value::Real(real) => Number::from_f64(real),
    };
    MetricValues(
        values
            .map(|(name, value)| (name.to_owned(), value.and_then(number)))
            .collect(),
    )
}

/// The metrics over time; `step_s` is the length of a control step.
pub fn metrics_json(log: &MetricsLog, step_s: f64) -> Metrics {
    let row = |row: &swarm::run::MetricsRow| MetricsRow {
        steps: row.steps,
        time_s: row.steps as f64 * step_s,
        epoch: row.epoch,
        fractions: fractions(row.entered, log.reachable),
        metrics: metric_values(row.values.iter()),
    };
    Metrics {
        schema: SCHEMA,
        reachable: log.reachable,
        rows: log.rows.iter().map(row).collect(),
    }
}

/// `metrics.csv`: the same rows; a metric that is not defined is empty.
pub fn metrics_csv(log: &MetricsLog, step_s: f64) -> String {
    let mut text = String::from("steps,time_s,epoch,fraction_1,fraction_2,fraction_5,fraction_10");
    for name in over_time() {
        text.push(',');
        text.push_str(name);
    }
    text.push('\n');
    for row in &log.rows {
        let time_s = Decimal(row.steps as f64 * step_s);
        let api::Fractions { p1, p2, p5, p10 } = fractions(row.entered, log.reachable);
        let [p1, p2, p5, p10] = [p1, p2, p5, p10].map(Decimal);
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "{},{time_s},{},{p1},{p2},{p5},{p10}",
            row.steps, row.epoch
        );
        for (_, value) in row.values.iter() {
            let _ = match value {
                Some(Value::Count(count)) => write!(text, ",{count}"),
                Some(Value::Real(real)) => write!(text, ",{}", Decimal(real)),
                None => write!(text, ","),
            };
        }
        text.push('\n');
    }
    text
}

/// `robots.csv`: what each robot did, and what its learner held.
pub fn robots_csv(log: &MetricsLog) -> String {
    let mut text = String::from(
        "robot,first_entries,contribution,distance_m,learner_bytes,clusters_saturated\n",
    );
    let all: u64 = log
        .robots
        .iter()
        .map(|robot| u64::from(robot.first_entries))
        .sum();
    for (number, robot) in log.robots.iter().enumerate() {
        let contribution = match all {
            0 => 0.0,
            all => f64::from(robot.first_entries) / all as f64,
        };
        let _ = writeln!(
            text,
            "{number},{},{},{},{},{}",
            robot.first_entries,
            Decimal(contribution),
            Decimal(robot.distance_m),
            robot.memory.bytes,
            robot.memory.clusters_saturated
        );
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use swarm::metrics::RowValues;
    use swarm::run::{RobotMemory, RobotMetrics};

    /// Where nothing moved yet all is whole, and columns are of the kind that they are elsewhere.
    #[test]
    fn columns_are_of_one_kind_in_every_run() {
        let row = |steps: u64, real: f64| swarm::run::MetricsRow {
            steps,
            epoch: 1,
            entered: [0; 4],
            values: RowValues::from_names(|name| match name {
                "collisions" => Some(Value::Count(steps)),
                _ => Some(Value::Real(real)),
            }),
        };
        let robot = |first_entries, distance_m| RobotMetrics {
            first_entries,
            distance_m,
            memory: RobotMemory {
                bytes: 0,
                clusters_saturated: 0,
            },
        };
        let log = |real, rows| MetricsLog {
            reachable: 20,
            rows,
            robots: vec![robot(0, real), robot(0, real)],
            first_entry: Vec::new(),
        };
        let kinds = |text: &str| -> Vec<Vec<bool>> {
            let kind = |cell: &str| cell.contains(['.', 'e']);
            let rows = text.lines().skip(1);
            rows.map(|row| row.split(',').map(kind).collect()).collect()
        };
        let whole = log(0.0, vec![row(1, 0.0), row(1000, 1.0)]);
        let other = log(0.25, vec![row(3, 0.25), row(5, 1e-9)]);
        for text in [metrics_csv, |log: &MetricsLog, _: f64| robots_csv(log)] {
            let [one, other] = [&whole, &other].map(|log| kinds(&text(log, 0.001)));
            assert_eq!(one, other);
        }
    }

    #[test]
    fn files_by_hand() {
        let row = swarm::run::MetricsRow {
            steps: 200,
            epoch: 1,
            entered: [10, 5, 1, 0],
            values: RowValues::from_names(|name| match name {
                "entropy" => Some(Value::Real(0.5)),
                "contribution_max" => Some(Value::Real(0.75)),
                "collisions" => Some(Value::Count(3)),
                "distance_m" => Some(Value::Real(1.5)),
                _ => None,
            }),
        };
        let robot = |first_entries, distance_m| RobotMetrics {
            first_entries,
            distance_m,
            memory: RobotMemory {
                bytes: 4_080,
                clusters_saturated: 7,
            },
        };
        let log = MetricsLog {
            reachable: 20,
            rows: vec![row],
            robots: vec![robot(3, 1.0), robot(1, 0.5)],
            first_entry: Vec::new(),
        };
        let text = metrics_csv(&log, 0.0625);
        let known = "200,12.5,1,0.5,0.25,0.05,0.0,0.5,,0.75,3,1.5";
        // A metric that is not known is an empty cell.
        let unknown = over_time().count() - 5;
        assert_eq!(
            text.lines().nth(1),
            Some(&*format!("{known}{}", ",".repeat(unknown)))
        );
        let lengths = text.lines().map(|line| line.split(',').count());
        assert!(lengths.clone().eq([7 + over_time().count(); 2]), "{text}");
        let json = serde_json::to_string(&metrics_json(&log, 0.0625).rows[0]).unwrap();
        assert!(
            json.starts_with(
                r#"{"steps":200,"time_s":12.5,"epoch":1,"fractions":{"p1":0.5,"p2":0.25,"p5":0.05,"p10":0.0},"entropy":0.5,"overlap":null,"contribution_max":0.75,"collisions":3,"distance_m":1.5"#
            ),
            "{json}"
        );
        let back: MetricsRow = serde_json::from_str(&json).unwrap();
        assert_eq!(back.metrics.get("distance_m"), Some(1.5));
        assert_eq!(serde_json::to_string(&back).unwrap(), json);
        assert_eq!(
            robots_csv(&log),
            "robot,first_entries,contribution,distance_m,learner_bytes,clusters_saturated\n\
             0,3,0.75,1.0,4080,7\n1,1,0.25,0.5,4080,7\n"
        );
    }
}
