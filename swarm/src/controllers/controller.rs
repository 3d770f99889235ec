//! What steers robots: from sensors to wheel commands, and what is learnt from the next sensors.

use crate::bodies::{Bodies, Reading};
use crate::dimensions::WHEELS;

/// One robot's control program, called once before and once after every move.
///
/// Implementations are compiled into the step loop: they allocate nothing and mark both methods
/// `#[inline(always)]`.
pub trait Controller: Send {
    /// Wheel commands, left and right in [-1, 1], at an arena's step. `reading` are the sensor values.
    fn act(&mut self, step: u64, reading: &Reading) -> [f32; WHEELS];

    /// Sees the sensor values after the move.
    fn learn(&mut self, reading: &Reading);

    /// Called a few robots before [`Controller::act`]: the place to ask for memory that it will need.
    #[inline(always)]
    fn expect_acting(&self) {}

    /// Called a few robots before [`Controller::learn`]: the place to ask for memory that it will need.
    #[inline(always)]
    fn expect_learning(&self) {}
}

/// The control programs of all robots of an arena: one controller each, or robots that have to do with
/// each other. `robot` is a robot's number.
///
/// In whatever order the robots are taken within a step, the result has to be the same: what
/// robots tell each other waits for [`Controllers::end_step`].
pub trait Controllers {
    /// Robots.
    fn len(&self) -> usize;

    /// Whether there is no robot.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// As [`Controller::act`].
    fn act(&mut self, robot: usize, step: u64, reading: &Reading) -> [f32; WHEELS];

    /// As [`Controller::learn`].
    fn learn(&mut self, robot: usize, reading: &Reading);

    /// As [`Controller::expect_acting`].
    #[inline(always)]
    fn expect_acting(&self, _robot: usize) {}

    /// As [`Controller::expect_learning`].
    #[inline(always)]
    fn expect_learning(&self, _robot: usize) {}

    /// Called once all robots have moved and learnt; `bodies` are reached by their numbers.
    #[inline(always)]
    fn end_step(&mut self, _step: u64, _bodies: &Bodies) {}
}

impl<P: Controller> Controllers for [P] {
    #[inline(always)]
    fn len(&self) -> usize {
        <[P]>::len(self)
    }

    #[inline(always)]
    fn act(&mut self, robot: usize, step: u64, reading: &Reading) -> [f32; WHEELS] {
        self[robot].act(step, reading)
    }

    #[inline(always)]
    fn learn(&mut self, robot: usize, reading: &Reading) {
        self[robot].learn(reading);
    }

    #[inline(always)]
    fn expect_acting(&self, robot: usize) {
        self[robot].expect_acting();
    }

    #[inline(always)]
    fn expect_learning(&self, robot: usize) {
        self[robot].expect_learning();
    }
}
