//! Findings as the blobs that a result or a checkpoint has.

use swarm::run::MetricsLog;

use super::coverage::Coverage;
use super::envelope::{Damage, Kind};
use super::{coverage, metrics, tracks};
use crate::store::findings::Findings;

/// Findings as their three blobs.
pub struct Blobs {
    /// Curve, visits, dwell.
    pub coverage: Vec<u8>,
    /// `None` in results of versions that had no metrics.
    pub metrics: Option<Vec<u8>>,
    /// `None` where the arena has no movable objects.
    pub objects: Option<Vec<u8>>,
}

impl Blobs {
    /// Findings in the present layouts.
    pub fn of(findings: &Findings) -> Self {
        let Findings {
            curve,
            visits,
            dwell,
            metrics,
            tracks,
        } = findings;
        Self {
            coverage: coverage::write(curve, visits, dwell),
            metrics: Some(metrics::write(metrics)),
            objects: (!tracks.is_empty()).then(|| tracks::write(tracks)),
        }
    }

    /// The findings; with the kind of the blob that is damaged, if one is.
    ///
    /// # Errors
    /// When a blob is damaged.
    pub fn read(&self) -> Result<Findings, (Kind, Damage)> {
        let of = |kind: Kind| move |damage: Damage| (kind, damage);
        let coverage = coverage::read(&self.coverage).map_err(of(Kind::Coverage))?;
        let metrics = self.metrics.as_deref().map(metrics::read).transpose();
        let tracks = self.objects.as_deref().map(tracks::read).transpose();
        let metrics = metrics.map_err(of(Kind::Metrics))?.unwrap_or_default();
        let tracks = tracks.map_err(of(Kind::Objects))?.unwrap_or_default();
        fits(&coverage, &metrics).map_err(of(Kind::Metrics))?;
        let (curve, visits, dwell) = coverage;
        Ok(Findings {
            curve,
            visits,
            dwell,
            metrics,
            tracks,
        })
    }
}

/// Whether a run could have found this.
pub fn fits(coverage: &Coverage, metrics: &MetricsLog) -> Result<(), Damage> {
    let (_, visits, dwell) = coverage;
    let squares = metrics.first_entry.len();
    if visits.len() != dwell.len() || (squares > 0 && squares != visits.len()) {
        return Err(Damage::Content("its parts are of different sizes".into()));
    }
    Ok(())
}
