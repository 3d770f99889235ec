//! Findings as programs without envelopes stored them: read where a database is upgraded, and in
//! checkpoints of such a program.

use serde::{Deserialize, Serialize};
use swarm::metrics::{RowValues, Value};
use swarm::run::{MetricsLog, MetricsRow};

use super::blobs::{Blobs, fits};
use super::envelope::{Damage, taken, whole};
use super::metrics::RobotV1;
use super::{coverage, metrics, tracks};
use crate::store::findings::Findings;

#[derive(Serialize, Deserialize)]
struct MetricsV0 {
    reachable: u32,
    rows: Vec<RowV0>,
    robots: Vec<RobotV1>,
    first_entry: Vec<u64>,
}

#[derive(Serialize, Deserialize)]
struct RowV0 {
    steps: u64,
    epoch: u32,
    entered: [u32; 4],
    entropy: f64,
    overlap: Option<f64>,
    contribution_max: f64,
    collisions: u64,
    distance_m: f64,
}

/// The present blobs of a result's old ones.
///
/// # Errors
/// When one of them is not what such a program stored.
pub fn upgrade(old: &Blobs) -> Result<Blobs, Damage> {
    let coverage = whole::<coverage::V1>(&old.coverage)?.into_coverage()?;
    let metrics = old.metrics.as_deref().map(whole::<MetricsV0>).transpose()?;
    let tracks = old
        .objects
        .as_deref()
        .map(whole::<tracks::V1>)
        .transpose()?;
    let metrics = metrics.map(MetricsV0::into_log);
    let tracks = tracks.map(tracks::V1::into_tracks).transpose()?;
    let (known, recorded) = (
        metrics.clone().unwrap_or_default(),
        tracks.unwrap_or_default(),
    );
    fits(&coverage, &known)?;
    let (curve, visits, dwell) = coverage;
    Ok(Blobs {
        coverage: coverage::write(&curve, &visits, &dwell),
        metrics: metrics.as_ref().map(metrics::write),
        objects: (!recorded.is_empty()).then(|| tracks::write(&recorded)),
    })
}

/// The findings in a checkpoint's first part.
///
/// # Errors
/// When they are not what such a program stored.
pub fn findings(bytes: &[u8]) -> Result<Findings, Damage> {
    let (coverage, rest) = taken::<coverage::V1>(bytes)?;
    let (metrics, rest) = taken::<MetricsV0>(rest)?;
    let tracks = whole::<tracks::V1>(rest)?.into_tracks()?;
    let (coverage, metrics) = (coverage.into_coverage()?, metrics.into_log());
    fits(&coverage, &metrics)?;
    let (curve, visits, dwell) = coverage;
    Ok(Findings {
        curve,
        visits,
        dwell,
        metrics,
        tracks,
    })
}

impl MetricsV0 {
    fn into_log(self) -> MetricsLog {
        let Self {
            reachable,
            rows,
            robots,
            first_entry,
        } = self;
        let row = |row: RowV0| {
            let RowV0 {
                steps,
                epoch,
                entered,
                entropy,
                overlap,
                contribution_max,
                collisions,
                distance_m,
            } = row;
            MetricsRow {
                steps,
                epoch,
                entered,
                values: RowValues::from_names(|name| match name {
                    "entropy" => Some(Value::Real(entropy)),
                    "overlap" => overlap.map(Value::Real),
                    "contribution_max" => Some(Value::Real(contribution_max)),
                    "collisions" => Some(Value::Count(collisions)),
                    "distance_m" => Some(Value::Real(distance_m)),
                    _ => None,
                }),
            }
        };
        MetricsLog {
            reachable,
            rows: rows.into_iter().map(row).collect(),
            robots: robots.into_iter().map(RobotV1::into_robot).collect(),
            first_entry,
        }
    }
}
