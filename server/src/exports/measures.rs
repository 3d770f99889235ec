//! Columns of a run's result: every field of `result.json` that is one value, under its dotted path.
//! All are empty until the run is done.

use api::RunResult;
use swarm::metrics::{METRICS, Metric, Shown, Source};

use super::over_time::{metric_cell, metric_kind};
use crate::tables::{Cell, Column, Kind, real};

/// A column with where its value comes from.
type Measure = (&'static str, Kind, fn(&RunResult) -> Cell);

const BEFORE_METRICS: &[Measure] = &[
    ("p1", Kind::Whole, |found| found.p1.into()),
    ("p2", Kind::Whole, |found| found.p2.into()),
    ("p5", Kind::Whole, |found| found.p5.into()),
    ("p10", Kind::Whole, |found| found.p10.into()),
    ("reachable", Kind::Whole, |found| found.reachable.into()),
    ("fractions.p1", Kind::Real, |found| {
        found.fractions.p1.into()
    }),
    ("fractions.p2", Kind::Real, |found| {
        found.fractions.p2.into()
    }),
    ("fractions.p5", Kind::Real, |found| {
        found.fractions.p5.into()
    }),
    ("fractions.p10", Kind::Real, |found| {
        found.fractions.p10.into()
    }),
    ("dwell.p1", Kind::Whole, |found| {
        found.dwell.map(|levels| levels.p1).into()
    }),
    ("dwell.p2", Kind::Whole, |found| {
        found.dwell.map(|levels| levels.p2).into()
    }),
    ("dwell.p5", Kind::Whole, |found| {
        found.dwell.map(|levels| levels.p5).into()
    }),
    ("dwell.p10", Kind::Whole, |found| {
        found.dwell.map(|levels| levels.p10).into()
    }),
];

const AFTER_METRICS: &[Measure] = &[
    ("steps", Kind::Whole, |found| found.steps.into()),
    ("collisions", Kind::Whole, |found| found.collisions.into()),
    ("clusters.sensor", Kind::Whole, |found| {
        found.clusters.sensor.into()
    }),
    ("clusters.actuator", Kind::Whole, |found| {
        found.clusters.actuator.into()
    }),
    ("clusters.sensori_motor", Kind::Whole, |found| {
        found.clusters.sensori_motor.into()
    }),
    ("model.divergence_nats", Kind::Real, |found| {
        real(found.model.map(|model| model.divergence_nats))
    }),
    ("model.pairs", Kind::Whole, |found| {
        found.model.map(|model| model.pairs).into()
    }),
    ("bytes", Kind::Whole, |found| found.bytes.into()),
    ("memory.most_bytes", Kind::Whole, |found| {
        found.memory.most_bytes.into()
    }),
    ("memory.least_bytes", Kind::Whole, |found| {
        found.memory.least_bytes.into()
    }),
    ("memory.clusters_saturated", Kind::Whole, |found| {
        found.memory.clusters_saturated.into()
    }),
    ("memory.robots_saturated", Kind::Whole, |found| {
        found.memory.robots_saturated.into()
    }),
    ("memory.plan.bytes", Kind::Whole, |found| {
        found.memory.plan.bytes.into()
    }),
    ("state_sha256", Kind::Text, |found| {
        Cell::text(&found.state_sha256)
    }),
];

/// Processor time: the one column in which two equal runs may differ.
const COST: &str = "cpu_ns_per_robot_step";

pub fn columns() -> Vec<Column> {
    let measure = |(name, kind, _): &Measure| Column::new(*name, *kind);
    let metric =
        |metric: &Metric| Column::new(format!("metrics.{}", metric.name), metric_kind(metric));
    let mut columns: Vec<Column> = BEFORE_METRICS.iter().map(measure).collect();
    columns.extend(metrics().map(metric));
    columns.extend(AFTER_METRICS.iter().map(measure));
    columns.push(Column::new(COST, Kind::Real));
    columns
}

pub fn cells(result: Option<&RunResult>, cost: Option<f64>) -> Vec<Cell> {
    let measure = |(_, _, value): &Measure| result.map_or(Cell::Nothing, value);
    let metric = |metric: &Metric| {
        let number = result.and_then(|result| result.metrics.as_ref()?.get(metric.name));
        metric_cell(metric, number)
    };
    let mut cells: Vec<Cell> = BEFORE_METRICS.iter().map(measure).collect();
    cells.extend(metrics().map(metric));
    cells.extend(AFTER_METRICS.iter().map(measure));
    cells.push(real(cost));
    cells
}

/// The metrics that `result.json` has below `metrics`.
fn metrics() -> impl Iterator<Item = &'static Metric> {
    let counted = |metric: &&Metric| matches!(metric.source, Source::Counted(_));
    METRICS
        .iter()
        .filter(|metric| metric.shows(Shown::AtEnd))
        .filter(counted)
}
