//! Swarm metrics as JSON types and CSV text; formulas in `docs/metrics.md`.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use api::{Metrics, MetricsRow, SCHEMA, SwarmMetrics};
use swarm::run::MetricsLog;

use super::fractions::fractions;

/// The metrics in `result.json`.
pub fn swarm_metrics(metrics: &swarm::run::Metrics) -> SwarmMetrics {
    let [t50_steps, t90_steps, t99_steps] = metrics.t_steps;
    let last = metrics.last;
    SwarmMetrics {
        t50_steps,
        t90_steps,
        t99_steps,
        mean_coverage: metrics.mean_coverage,
        entropy: last.entropy,
        overlap: last.overlap,
        overlap_robots: metrics.overlap_robots,
        contribution_max: last.contribution_max,
        contributors: metrics.contributors,
        distance_m: last.distance_m,
    }
}

/// The metrics over time; `step_s` is the length of a control step.
pub fn metrics_json(log: &MetricsLog, step_s: f64) -> Metrics {
    let row = |row: &swarm::run::MetricsRow| MetricsRow {
        steps: row.steps,
        time_s: row.steps as f64 * step_s,
        epoch: row.epoch,
        fractions: fractions(row.entered, log.reachable),
        entropy: row.entropy,
        overlap: row.overlap,
        contribution_max: row.contribution_max,
        collisions: row.collisions,
        distance_m: row.distance_m,
    };
    Metrics {
        schema: SCHEMA,
        reachable: log.reachable,
        rows: log.rows.iter().map(row).collect(),
    }
}

/// `metrics.csv`: the same rows; an overlap that is not defined is empty.
pub fn metrics_csv(log: &MetricsLog, step_s: f64) -> String {
    let mut text = String::from(
        "steps,time_s,epoch,fraction_1,fraction_2,fraction_5,fraction_10,entropy,overlap,\
         contribution_max,collisions,distance_m\n",
    );
    for row in metrics_json(log, step_s).rows {
        let api::Fractions { p1, p2, p5, p10 } = row.fractions;
        let overlap = row.overlap.map_or(String::new(), |share| share.to_string());
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{},{},{},{p1},{p2},{p5},{p10},{},{overlap},{},{},{}",
            row.steps,
            row.time_s,
            row.epoch,
            row.entropy,
            row.contribution_max,
            row.collisions,
            row.distance_m
        );
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
            "{number},{},{contribution},{},{},{}",
            robot.first_entries,
            robot.distance_m,
            robot.memory.bytes,
            robot.memory.clusters_saturated
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use swarm::run::{RobotMemory, RobotMetrics};

    #[test]
    fn files_by_hand() {
        let row = swarm::run::MetricsRow {
            steps: 200,
            epoch: 1,
            entered: [10, 5, 1, 0],
            entropy: 0.5,
            overlap: None,
            contribution_max: 0.75,
            collisions: 3,
            distance_m: 1.5,
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
        assert_eq!(
            text.lines().nth(1),
            Some("200,12.5,1,0.5,0.25,0.05,0,0.5,,0.75,3,1.5")
        );
        assert_eq!(
            robots_csv(&log),
            "robot,first_entries,contribution,distance_m,learner_bytes,clusters_saturated\n\
             0,3,0.75,1,4080,7\n1,1,0.25,0.5,4080,7\n"
        );
    }
}
