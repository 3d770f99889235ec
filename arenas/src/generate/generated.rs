//! What a generator makes.

use crate::arena::Pose;
use crate::segment::Segment;

/// Walls, and a place to start at.
pub(crate) struct Generated {
    pub walls: Vec<Segment>,
    /// Where robots start if the arena does not say.
    pub start: Pose,
}
