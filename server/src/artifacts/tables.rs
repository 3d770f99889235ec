//! A run's figures as JSON types and CSV text.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use api::{
    ClusterCounts, Coverage, Memory, MemoryPlan, ModelAccuracy, ObjectResult, RunResult, SCHEMA,
};
use arenas::Arena;
use swarm::run::{CurveRow, ObjectOutcome, Outcome, RobotMemory, counts_within};
use swarm::world::ObjectPose;

use super::fractions::fractions;
use super::metrics::metric_values;
use super::palette::STEPS;

/// `result.json`.
pub fn run_result(outcome: &Outcome) -> RunResult {
    let CurveRow {
        p1, p2, p5, p10, ..
    } = outcome.coverage;
    RunResult {
        schema: SCHEMA,
        p1,
        p2,
        p5,
        p10,
        reachable: outcome.reachable,
        fractions: fractions(outcome.coverage_reachable, outcome.reachable),
        dwell: Some(outcome.dwell.into()),
        metrics: Some(metric_values(outcome.metrics.iter().copied())),
        steps: outcome.robot_steps,
        collisions: outcome.collisions,
        clusters: ClusterCounts {
            sensor: outcome.sensor_clusters,
            actuator: outcome.actuator_clusters,
            sensori_motor: outcome.sensori_motor_clusters,
        },
        model: outcome.model.map(|model| ModelAccuracy {
            divergence_nats: model.sum_nats,
            pairs: model.pairs,
        }),
        bytes: outcome.bytes,
        memory: memory(&outcome.memory, &outcome.memory_plan),
        objects: outcome.objects.iter().map(object).collect(),
        state_sha256: outcome.state_sha256.clone(),
    }
}

fn object(object: &ObjectOutcome) -> ObjectResult {
    let ObjectPose { x_m, y_m, cos, sin } = object.pose;
    ObjectResult {
        kind: object.kind.to_owned(),
        x_m: x_m.into(),
        y_m: y_m.into(),
        cos: cos.into(),
        sin: sin.into(),
        moved_m: object.moved_m,
        displaced_m: object.displaced_m,
    }
}

/// What learners hold and may hold, as a document.
pub fn memory(robots: &[RobotMemory], plan: &swarm::memory::MemoryPlan) -> Memory {
    let bytes = || robots.iter().map(|robot| robot.bytes);
    let saturated = || robots.iter().map(|robot| robot.clusters_saturated);
    Memory {
        plan: memory_plan(plan),
        most_bytes: bytes().max().unwrap_or(0),
        least_bytes: bytes().min().unwrap_or(0),
        clusters_saturated: saturated().sum(),
        // A run has at most 100,000 robots.
        robots_saturated: saturated().filter(|count| *count > 0).count() as u32,
    }
}

/// What each robot's learner may hold, as a document.
pub fn memory_plan(plan: &swarm::memory::MemoryPlan) -> MemoryPlan {
    MemoryPlan {
        sensor_clusters: plan.sensor_clusters,
        actuator_clusters: plan.actuator_clusters,
        sensori_motor_clusters: plan.sensori_motor_clusters,
        sample: plan.sample,
        actuator_sample: plan.actuator_sample,
        lambda: plan.lambda,
        genomes: plan.genomes,
        bytes: plan.bytes,
    }
}

/// `curve.csv`: one row an epoch.
pub fn curve_csv(curve: &[CurveRow]) -> String {
    let mut text = String::from("epoch,p1,p2,p5,p10\n");
    for CurveRow {
        epoch,
        p1,
        p2,
        p5,
        p10,
    } in curve
    {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{epoch},{p1},{p2},{p5},{p10}");
    }
    text
}

/// Squares entered at least 1, 2, 5 and 10 times.
pub fn coverage_counts(visits: &[u32]) -> [u32; STEPS.len()] {
    std::array::from_fn(|step| {
        let entered = visits.iter().filter(|&&count| count >= STEPS[step].from);
        // An arena has at most 1,000 x 1,000 squares.
        entered.count() as u32
    })
}

/// Entries counted a square, as a document; `mask` has the reachable squares.
pub fn coverage_json(arena: &Arena, visits: &[u32], mask: &[bool]) -> Coverage {
    let [p1, p2, p5, p10] = coverage_counts(visits);
    let reachable = mask.iter().filter(|&&reached| reached).count() as u32;
    Coverage {
        schema: SCHEMA,
        arena: arena.name().to_owned(),
        width_m: arena.width_m(),
        height_m: arena.height_m(),
        squares: arena.squares().into(),
        p1,
        p2,
        p5,
        p10,
        reachable,
        fractions: fractions(counts_within(visits, mask), reachable),
        visits: visits
            .chunks(arena.squares()[0].max(1) as usize)
            .map(<[u32]>::to_vec)
            .collect(),
    }
}

/// One line a square that was entered: column, row (0 the lowest y), entries.
pub fn coverage_csv(visits: &[u32], columns: u32) -> String {
    let mut text = String::from("column,row,visits\n");
    let columns = columns.max(1) as usize;
    for (place, count) in visits.iter().enumerate().filter(|(_, count)| **count > 0) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{},{count}", place % columns, place / columns);
    }
    text
}

/// A row of a run's curve.
pub fn curve_row(row: &swarm::run::CurveRow) -> api::CurveRow {
    let swarm::run::CurveRow {
        epoch,
        p1,
        p2,
        p5,
        p10,
    } = *row;
    api::CurveRow {
        epoch,
        p1,
        p2,
        p5,
        p10,
    }
}
