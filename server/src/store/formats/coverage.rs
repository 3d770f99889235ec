//! Curve, visits and dwell on disk.

use serde::{Deserialize, Serialize};
use swarm::run::CurveRow;

use super::envelope::{Damage, Kind, open, seal, whole};

/// Curve, visits, dwell.
pub type Coverage = (Vec<CurveRow>, Vec<u32>, Vec<u32>);

/// Layout 1, and 0 but for the envelope.
#[derive(Serialize, Deserialize)]
pub(super) struct V1 {
    curve: Vec<RowV1>,
    visits: Vec<u32>,
    dwell: Vec<u32>,
}

#[derive(Serialize, Deserialize)]
struct RowV1 {
    epoch: u32,
    p1: u32,
    p2: u32,
    p5: u32,
    p10: u32,
}

/// In the present layout.
pub(super) fn write(curve: &[CurveRow], visits: &[u32], dwell: &[u32]) -> Vec<u8> {
    let row = |row: &CurveRow| {
        let CurveRow {
            epoch,
            p1,
            p2,
            p5,
            p10,
        } = *row;
        RowV1 {
            epoch,
            p1,
            p2,
            p5,
            p10,
        }
    };
    let layout = V1 {
        curve: curve.iter().map(row).collect(),
        visits: visits.to_vec(),
        dwell: dwell.to_vec(),
    };
    seal(Kind::Coverage, 1, &layout)
}

/// From any layout.
pub(super) fn read(bytes: &[u8]) -> Result<Coverage, Damage> {
    match open(Kind::Coverage, bytes)? {
        (1, payload) => whole::<V1>(payload)?.into_coverage(),
        (version, _) => Err(Damage::Version(version)),
    }
}

impl V1 {
    pub(super) fn into_coverage(self) -> Result<Coverage, Damage> {
        let Self {
            curve,
            visits,
            dwell,
        } = self;
        if visits.len() != dwell.len() {
            let sizes = format!("{} visits, {} dwells", visits.len(), dwell.len());
            return Err(Damage::Content(sizes));
        }
        let row = |row: RowV1| {
            let RowV1 {
                epoch,
                p1,
                p2,
                p5,
                p10,
            } = row;
            CurveRow {
                epoch,
                p1,
                p2,
                p5,
                p10,
            }
        };
        Ok((curve.into_iter().map(row).collect(), visits, dwell))
    }
}
