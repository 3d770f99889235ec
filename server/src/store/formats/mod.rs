//! What findings are on disk: types of the store's own, each layout with a version, in an envelope
//! with a digest. To change a layout: add the next version beside the old one, write the new, read
//! both, and add a data directory of the new program to `tests/data_directories`.

mod coverage;
mod metrics;
mod tracks;
mod v0;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use swarm::run::{CurveRow, MetricsLog};

use super::Findings;
pub use v0::{findings as findings_v0, upgrade as upgrade_v0};

const MAGIC: [u8; 4] = *b"EVSF";
/// Magic, kind, version, digest.
const HEAD_BYTES: usize = 4 + 1 + 1 + 32;

/// What a blob is about; the number is on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Curve, visits, dwell.
    Coverage = 1,
    /// Swarm metrics over time and robot by robot.
    Metrics = 2,
    /// Movable objects over time.
    Objects = 3,
}

impl Kind {
    /// As messages and columns call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Coverage => "coverage",
            Self::Metrics => "metrics",
            Self::Objects => "objects",
        }
    }
}

/// Why bytes on disk cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// They do not begin as such bytes do.
    #[error("it does not begin as it should")]
    Foreign,
    /// Bytes were changed, cut off or added.
    #[error("its digest does not match")]
    Digest,
    /// A later program wrote them.
    #[error("it has version {0}, which this program does not know")]
    Version(u8),
    /// They are whole, but do not fit together.
    #[error("{0}")]
    Content(String),
}

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

/// A layout with its version, in its envelope.
fn seal(kind: Kind, version: u8, layout: &impl Serialize) -> Vec<u8> {
    // Serializing plain data into memory has no way to fail: no sequence is of unknown length.
    #[allow(clippy::expect_used, reason = "see above")]
    let payload = postcard::to_stdvec(layout).expect("plain data serializes");
    let mut bytes = Vec::with_capacity(HEAD_BYTES + payload.len());
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&[kind as u8, version]);
    bytes.extend_from_slice(&digest(kind, version, &payload));
    bytes.extend_from_slice(&payload);
    bytes
}

/// The version and the layout's bytes, once the envelope is found whole and of this kind.
fn open(kind: Kind, bytes: &[u8]) -> Result<(u8, &[u8]), Damage> {
    let rest = bytes.strip_prefix(&MAGIC).ok_or(Damage::Foreign)?;
    let ([found, version], rest) = rest.split_first_chunk().ok_or(Damage::Foreign)?;
    let (expected, payload) = rest.split_first_chunk().ok_or(Damage::Digest)?;
    if *found != kind as u8 {
        return Err(Damage::Foreign);
    }
    if *expected != digest(kind, *version, payload) {
        return Err(Damage::Digest);
    }
    Ok((*version, payload))
}

fn digest(kind: Kind, version: u8, payload: &[u8]) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update([kind as u8, version]);
    hash.update(payload);
    hash.finalize().into()
}

/// A layout that takes up all of these bytes.
fn whole<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Damage> {
    let (layout, rest) = taken(bytes)?;
    match rest {
        [] => Ok(layout),
        rest => Err(Damage::Content(format!(
            "{} bytes are left over",
            rest.len()
        ))),
    }
}

/// A layout at the beginning of these bytes, and what follows it.
fn taken<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), Damage> {
    postcard::take_from_bytes(bytes).map_err(|error| Damage::Content(error.to_string()))
}

/// Curve, visits, dwell.
type Coverage = (Vec<CurveRow>, Vec<u32>, Vec<u32>);

/// Whether a run could have found this.
fn fits(coverage: &Coverage, metrics: &MetricsLog) -> Result<(), Damage> {
    let (_, visits, dwell) = coverage;
    let squares = metrics.first_entry.len();
    if visits.len() != dwell.len() || (squares > 0 && squares != visits.len()) {
        return Err(Damage::Content("its parts are of different sizes".into()));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
