//! What a run has found so far.

use swarm::run::{CurveRow, MetricsLog, Tracks};

/// What a run has covered so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// One row a completed counted epoch.
    pub curve: Vec<CurveRow>,
    /// Entries counted a square, row by row from the lowest y.
    pub visits: Vec<u32>,
    /// Steps spent a square, same shape.
    pub dwell: Vec<u32>,
    /// Swarm metrics over time; empty in results of versions that had none.
    pub metrics: MetricsLog,
    /// Movable objects over time; empty in results of versions that did not record them.
    pub tracks: Tracks,
}
