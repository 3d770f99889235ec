//! Swarm metrics on disk. Those over time are columns under their names, so that a further metric
//! needs no further layout: it is absent from what older programs stored.

use serde::{Deserialize, Serialize};
use swarm::metrics::{RowValues, Value, over_time};
use swarm::run::{MetricsLog, MetricsRow, RobotMemory, RobotMetrics};

use super::envelope::{Damage, Kind, open, seal, whole};

/// Layout 1.
#[derive(Serialize, Deserialize)]
struct V1 {
    reachable: u32,
    rows: Vec<RowV1>,
    /// A metric's name, and its value in each row.
    columns: Vec<(String, Vec<Option<ValueV1>>)>,
    robots: Vec<RobotV1>,
    first_entry: Vec<u64>,
}

#[derive(Serialize, Deserialize)]
struct RowV1 {
    steps: u64,
    epoch: u32,
    entered: [u32; 4],
}

#[derive(Clone, Copy, Serialize, Deserialize)]
enum ValueV1 {
    Count(u64),
    Real(f64),
}

/// A robot in layouts 0 and 1.
#[derive(Serialize, Deserialize)]
pub(super) struct RobotV1 {
    first_entries: u32,
    distance_m: f64,
    bytes: u64,
    clusters_saturated: u64,
}

/// In the present layout.
pub(super) fn write(metrics: &MetricsLog) -> Vec<u8> {
    let MetricsLog {
        reachable,
        rows,
        robots,
        first_entry,
    } = metrics;
    let layout = V1 {
        reachable: *reachable,
        rows: rows.iter().map(RowV1::of).collect(),
        columns: columns(rows),
        robots: robots.iter().map(RobotV1::of).collect(),
        first_entry: first_entry.clone(),
    };
    seal(Kind::Metrics, 1, &layout)
}

/// From any layout.
pub(super) fn read(bytes: &[u8]) -> Result<MetricsLog, Damage> {
    match open(Kind::Metrics, bytes)? {
        (1, payload) => whole::<V1>(payload)?.into_log(),
        (version, _) => Err(Damage::Version(version)),
    }
}

/// A column for each metric that has a value in some row.
fn columns(rows: &[MetricsRow]) -> Vec<(String, Vec<Option<ValueV1>>)> {
    let column = |name: &'static str| {
        let values = rows.iter().map(|row| row.values.get(name).map(ValueV1::of));
        (name.to_owned(), values.collect())
    };
    let has_values =
        |(_, values): &(String, Vec<Option<ValueV1>>)| values.iter().any(Option::is_some);
    over_time().map(column).filter(has_values).collect()
}

impl ValueV1 {
    fn of(value: Value) -> Self {
        match value {
            Value::Count(count) => Self::Count(count),
            Value::Real(real) => Self::Real(real),
        }
    }

    fn into_value(self) -> Value {
        match self {
            Self::Count(count) => Value::Count(count),
            Self::Real(real) => Value::Real(real),
        }
    }
}

impl V1 {
    fn into_log(self) -> Result<MetricsLog, Damage> {
        let Self {
            reachable,
            rows,
            columns,
            robots,
            first_entry,
        } = self;
        let short = columns
            .iter()
            .find(|(_, values)| values.len() != rows.len());
        if let Some((name, values)) = short {
            let sizes = format!("{} rows, {} values of {name}", rows.len(), values.len());
            return Err(Damage::Content(sizes));
        }
        let value = |name: &str, place: usize| {
            let (_, values) = columns.iter().find(|(known, _)| known == name)?;
            values[place].map(ValueV1::into_value)
        };
        let row = |(place, row): (usize, RowV1)| {
            let RowV1 {
                steps,
                epoch,
                entered,
            } = row;
            MetricsRow {
                steps,
                epoch,
                entered,
                values: RowValues::from_names(|name| value(name, place)),
            }
        };
        Ok(MetricsLog {
            reachable,
            rows: rows.into_iter().enumerate().map(row).collect(),
            robots: robots.into_iter().map(RobotV1::into_robot).collect(),
            first_entry,
        })
    }
}

impl RowV1 {
    fn of(row: &MetricsRow) -> Self {
        Self {
            steps: row.steps,
            epoch: row.epoch,
            entered: row.entered,
        }
    }
}

impl RobotV1 {
    fn of(robot: &RobotMetrics) -> Self {
        let RobotMetrics {
            first_entries,
            distance_m,
            memory:
                RobotMemory {
                    bytes,
                    clusters_saturated,
                },
        } = *robot;
        Self {
            first_entries,
            distance_m,
            bytes,
            clusters_saturated,
        }
    }

    pub(super) fn into_robot(self) -> RobotMetrics {
        let Self {
            first_entries,
            distance_m,
            bytes,
            clusters_saturated,
        } = self;
        RobotMetrics {
            first_entries,
            distance_m,
            memory: RobotMemory {
                bytes,
                clusters_saturated,
            },
        }
    }
}
