//! Where a robot is expected next: dead reckoning from its commands, in whole-number ticks that
//! writer and reader come to alike. What touches nothing is found where it is expected.

use std::sync::LazyLock;

use crate::header::DriveModel;
use crate::units::{TICKS_PER_COMMAND, TICKS_PER_M, TICKS_PER_RAD};

/// Half a turn, and a whole one, in ticks.
const HALF_TURN: f64 = std::f64::consts::PI * TICKS_PER_RAD;
const TURN: f64 = 2.0 * HALF_TURN;

/// Directions by tick of a turn; made of a library's sine, the same on every machine.
pub struct Directions(Vec<[f64; 2]>);

static DIRECTIONS: LazyLock<Directions> = LazyLock::new(Directions::new);

impl Directions {
    /// The one table.
    pub fn get() -> &'static Self {
        &DIRECTIONS
    }

    fn new() -> Self {
        let turn = TURN as i32 + 1;
        let direction = |tick| {
            let angle_rad = f64::from(tick) / TICKS_PER_RAD;
            [libm::cos(angle_rad), libm::sin(angle_rad)]
        };
        Self((0..=turn).map(direction).collect())
    }

    /// The direction of a heading in ticks, at its nearest tick.
    fn of(&self, heading: f64) -> [f64; 2] {
        let within = heading - (heading / TURN).floor() * TURN;
        self.0[((within + 0.5) as usize).min(self.0.len() - 1)]
    }
}

/// Where something is expected, and which way it is taken to move.
#[derive(Clone, Copy, Debug)]
pub struct Guess {
    at: [i32; 3],
    along: [f64; 2],
}

impl Guess {
    /// Where it was.
    pub fn still(at: [i32; 3]) -> Self {
        Self {
            at,
            along: [1.0, 0.0],
        }
    }

    /// What a pose is off: on the axis that is nearer to the way; on the other, less what goes
    /// with that; of the heading. Wheels that slip leave the second near 0.
    pub fn off(&self, is: [i32; 3]) -> [i32; 3] {
        let off = |axis: usize| is[axis].wrapping_sub(self.at[axis]);
        let (first, second, slope) = self.axes();
        let along = off(first);
        [along, off(second).wrapping_sub(aside(along, slope)), off(2)]
    }

    /// The pose that is off by so much.
    pub fn corrected(&self, [along, beside, turned]: [i32; 3]) -> [i32; 3] {
        let (first, second, slope) = self.axes();
        let mut is = self.at;
        is[first] = is[first].wrapping_add(along);
        is[second] = is[second].wrapping_add(aside(along, slope).wrapping_add(beside));
        is[2] = is[2].wrapping_add(turned);
        is
    }

    /// The axis nearer to the way, the other, and how much of the other goes with the first.
    fn axes(&self) -> (usize, usize, f64) {
        let [cos, sin] = self.along;
        if cos.abs() >= sin.abs() {
            (0, 1, sin / cos)
        } else {
            (1, 0, cos / sin)
        }
    }
}

fn aside(along: i32, slope: f64) -> i32 {
    nearest(f64::from(along) * slope)
}

/// A robot that is followed.
pub struct Reckoning<'a> {
    directions: &'a Directions,
    top_speed_rad_s: f64,
    acceleration_rad_s_step: f64,
    advance: f64,
    turn: f64,
    wheels_rad_s: [f64; 2],
    /// x, y and heading in ticks, finer than they are kept.
    at: [f64; 3],
}

/// To the nearest tick.
pub fn nearest(value: f64) -> i32 {
    (value + 0.5).floor() as i32
}

/// A heading between minus half a turn and half a turn.
fn wrapped(heading: f64) -> f64 {
    if heading > HALF_TURN {
        heading - TURN
    } else if heading < -HALF_TURN {
        heading + TURN
    } else {
        heading
    }
}

impl<'a> Reckoning<'a> {
    /// A robot at rest at the origin.
    pub fn new(drive: &DriveModel, directions: &'a Directions) -> Self {
        Self {
            directions,
            top_speed_rad_s: drive.top_speed_rad_s,
            acceleration_rad_s_step: drive.acceleration_rad_s_step.unwrap_or(f64::INFINITY),
            advance: drive.advance_m_s * TICKS_PER_M,
            turn: drive.turn_s * TICKS_PER_RAD,
            wheels_rad_s: [0.0; 2],
            at: [0.0; 3],
        }
    }

    /// Puts it where it is known to be.
    pub fn put(&mut self, at: [i32; 3], wheels_rad_s: [f64; 2]) {
        self.at = at.map(f64::from);
        self.wheels_rad_s = wheels_rad_s;
    }

    /// Where it is expected after a step with these commands, in ticks.
    pub fn step(&mut self, command: [i16; 2]) -> Guess {
        for (speed, ticks) in self.wheels_rad_s.iter_mut().zip(command) {
            let wanted = f64::from(ticks) / TICKS_PER_COMMAND * self.top_speed_rad_s - *speed;
            let limit = self.acceleration_rad_s_step;
            *speed += wanted.clamp(-limit, limit);
        }
        let [left, right] = self.wheels_rad_s;
        let turn = (right - left) * self.turn;
        let half_rad = turn / (2.0 * TICKS_PER_RAD);
        // A chord against its arc.
        let chord = 1.0 - half_rad * half_rad / 6.0;
        let way = (left + right) * self.advance * chord;
        let [cos, sin] = self.directions.of(self.at[2] + 0.5 * turn);
        self.at[0] += way * cos;
        self.at[1] += way * sin;
        self.at[2] = wrapped(self.at[2] + turn);
        Guess {
            at: self.at.map(nearest),
            along: [cos, sin],
        }
    }

    /// Corrects what was expected by what was.
    pub fn correct(&mut self, expected: Guess, actual: [i32; 3]) {
        for ((at, expected), actual) in self.at.iter_mut().zip(expected.at).zip(actual) {
            if expected != actual {
                *at = f64::from(actual);
            }
        }
    }
}
