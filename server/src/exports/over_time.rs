//! Columns of curves and of swarm metrics over time, as `curve.csv` and `metrics.csv` have them.

use std::io;

use swarm::metrics::{METRICS, Metric, Shown, Source, Value};
use swarm::run::{CurveRow, MetricsLog, MetricsRow};

use crate::tables::{Cell, Column, Form, Kind, real};

pub fn curve_columns() -> impl Iterator<Item = Column> {
    let names = ["epoch", "p1", "p2", "p5", "p10"].into_iter();
    names.map(|name| Column::new(name, Kind::Whole))
}

pub fn curve_cells(row: &CurveRow) -> [Cell; 5] {
    let CurveRow {
        epoch,
        p1,
        p2,
        p5,
        p10,
    } = *row;
    [epoch, p1, p2, p5, p10].map(Cell::from)
}

pub fn metrics_columns() -> Vec<Column> {
    let first = [
        ("steps", Kind::Whole),
        ("time_s", Kind::Real),
        ("epoch", Kind::Whole),
        ("fraction_1", Kind::Real),
        ("fraction_2", Kind::Real),
        ("fraction_5", Kind::Real),
        ("fraction_10", Kind::Real),
    ];
    let first = first.into_iter();
    let first = first.map(|(name, kind)| Column::new(name, kind));
    let rest = over_time().map(|metric| Column::new(metric.name, metric_kind(metric)));
    first.chain(rest).collect()
}

pub fn metrics_cells(row: &MetricsRow, reachable: u32, step_s: Option<f64>) -> Vec<Cell> {
    let share = |entered: u32| match reachable {
        0 => 0.0,
        reachable => f64::from(entered) / f64::from(reachable),
    };
    let mut cells = vec![
        row.steps.into(),
        real(step_s.map(|step_s| row.steps as f64 * step_s)),
        row.epoch.into(),
    ];
    cells.extend(row.entered.map(|entered| Cell::Real(share(entered))));
    cells.extend(over_time().map(|metric| {
        let number = row.values.get(metric.name).map(|value| match value {
            Value::Count(count) => count as f64,
            Value::Real(real) => real,
        });
        metric_cell(metric, number)
    }));
    cells
}

/// `metrics.parquet` of one run.
///
/// # Errors
/// When it cannot be made; memory that grows takes everything.
pub fn metrics_of_run(log: &MetricsLog, step_s: f64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut rows = Form::Parquet.begin(&metrics_columns(), &mut bytes)?;
    for row in &log.rows {
        rows.add(&metrics_cells(row, log.reachable, Some(step_s)))?;
    }
    rows.end()?;
    Ok(bytes)
}

/// What the cells of a metric hold: whole numbers where it counts steps.
pub fn metric_kind(metric: &Metric) -> Kind {
    match metric.unit {
        "steps" | "robot-steps" => Kind::Whole,
        _ => Kind::Real,
    }
}

/// A metric's value. Counts are below 2^53, so that they pass through a real number unchanged.
pub fn metric_cell(metric: &Metric, number: Option<f64>) -> Cell {
    let number = number.filter(|number| number.is_finite());
    match metric_kind(metric) {
        Kind::Whole => number.map(|number| number as u64).into(),
        _ => number.into(),
    }
}

fn over_time() -> impl Iterator<Item = &'static Metric> {
    let counted = |metric: &&Metric| matches!(metric.source, Source::Counted(_));
    METRICS
        .iter()
        .filter(|metric| metric.shows(Shown::OverTime))
        .filter(counted)
}
