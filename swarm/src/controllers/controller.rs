//! What steers robots: from sensors to wheel commands, and what is learnt from the next sensors.

use crate::bodies::{Bodies, Reading};
use crate::dimensions::WHEELS;

/// One robot's control program, called once before and once after every move.
///
/// Implementations are compiled into the step loop: they allocate nothing and mark both methods
/// `#[inline(always)]`.
pub trait Controller: Send {
    /// Whether a robot has so much that many do not fit the caches: then it is worth asking for
    /// memory before the robot's turn comes.
    const IS_LARGE: bool = false;

    /// Called before [`Controller::act`] with the same arguments, for several robots before the first
    /// of them acts: the place to find out which memory that will need, and to ask for it.
    #[inline(always)]
    fn choose(&mut self, _step: u64, _reading: &Reading) {}

    /// Wheel commands, left and right in [-1, 1], at an arena's step. `reading` are the sensor values.
    fn act(&mut self, step: u64, reading: &Reading) -> [f32; WHEELS];

    /// Sees the sensor values after the move.
    fn learn(&mut self, reading: &Reading);

    /// Called a few robots before [`Controller::choose`]: the place to ask for memory that it will need.
    #[inline(always)]
    fn expect_acting(&self) {}

    /// Called a few robots before [`Controller::learn`]: the place to ask for memory that it will need.
    #[inline(always)]
    fn expect_learning(&self) {}
}

/// The control programs of all robots of an arena: one controller each, or robots that have to do with
/// each other. A robot is known by its number.
///
/// Within a step every robot changes what it has for itself, and reads what all have in common: so
/// robots can be taken in any order and by any number of threads. What robots tell each other waits
/// for [`Controllers::end_step`].
pub trait Controllers: Send {
    /// What a robot has for itself.
    type Robot: Send;

    /// What all robots read.
    type Common: Sync;

    /// As [`Controller::IS_LARGE`].
    const ARE_LARGE: bool;

    /// Whether [`Controllers::end_step`] does anything.
    const ENDS_STEPS: bool;

    /// What the robots have for themselves, by number, and what they have in common.
    fn parts(&mut self) -> (&mut [Self::Robot], &Self::Common);

    /// As [`Controller::choose`].
    #[inline(always)]
    fn choose(_: &Self::Common, _robot: &mut Self::Robot, _step: u64, _reading: &Reading) {}

    /// As [`Controller::act`].
    fn act(
        common: &Self::Common,
        robot: &mut Self::Robot,
        step: u64,
        reading: &Reading,
    ) -> [f32; WHEELS];

    /// As [`Controller::learn`].
    fn learn(common: &Self::Common, robot: &mut Self::Robot, reading: &Reading);

    /// As [`Controller::expect_acting`].
    #[inline(always)]
    fn expect_acting(_robot: &Self::Robot) {}

    /// As [`Controller::expect_learning`].
    #[inline(always)]
    fn expect_learning(_robot: &Self::Robot) {}

    /// Called once all robots have moved and learnt; `bodies` are reached by their numbers.
    #[inline(always)]
    fn end_step(&mut self, _step: u64, _bodies: &Bodies) {}
}

impl<P: Controller> Controllers for [P] {
    type Robot = P;
    type Common = ();
    const ARE_LARGE: bool = P::IS_LARGE;
    const ENDS_STEPS: bool = false;

    #[inline(always)]
    fn parts(&mut self) -> (&mut [P], &()) {
        (self, &())
    }

    #[inline(always)]
    fn choose((): &(), robot: &mut P, step: u64, reading: &Reading) {
        robot.choose(step, reading);
    }

    #[inline(always)]
    fn act((): &(), robot: &mut P, step: u64, reading: &Reading) -> [f32; WHEELS] {
        robot.act(step, reading)
    }

    #[inline(always)]
    fn learn((): &(), robot: &mut P, reading: &Reading) {
        robot.learn(reading);
    }

    #[inline(always)]
    fn expect_acting(robot: &P) {
        robot.expect_acting();
    }

    #[inline(always)]
    fn expect_learning(robot: &P) {
        robot.expect_learning();
    }
}
