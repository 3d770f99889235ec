//! What steers one robot: from sensors to wheel commands, and what it learns from the next sensors.

use crate::lanes::F8;

/// One robot's control program, called once before and once after every move.
///
/// Implementations are compiled into the step loop: they allocate nothing and mark both methods
/// `#[inline(always)]`.
pub trait Pilot: Send {
    /// Wheel commands, left and right in [-1, 1], at an arena's step. `raw` are the sensor values.
    fn act(&mut self, step: u64, raw: &F8) -> [f32; 2];

    /// Sees the sensor values after the move.
    fn learn(&mut self, raw: &F8);

    /// Called a few robots before [`Pilot::act`]: the place to ask for memory that it will need.
    #[inline(always)]
    fn expect_acting(&self) {}

    /// Called a few robots before [`Pilot::learn`]: the place to ask for memory that it will need.
    #[inline(always)]
    fn expect_learning(&self) {}
}
