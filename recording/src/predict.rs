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

/// Where something is expected.
#[derive(Clone, Copy)]
pub enum Guess<'a> {
    /// Where it was.
    Still([i32; 3]),
    /// Where its wheels take it.
    Rolling(Step<'a>),
}

/// A pose that is known, and where it was expected.
#[derive(Clone, Copy)]
pub struct Found {
    /// The pose.
    pub is: [i32; 3],
    turned: i32,
    /// Where the step ended of one that rolled, in ticks finer than they are kept.
    end: Option<[f64; 2]>,
}

/// A step by the wheels: what it comes to depends on how far the robot turned, as both come of the
/// same slipping wheels.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    directions: &'a Directions,
    /// x, y and heading before it, in ticks.
    from: [f64; 3],
    /// Heading after it without slip.
    heading: i32,
    /// Turn and way as commanded, in ticks.
    turn: f64,
    way: f64,
    /// Way that a tick of turn more is likely to go with, if it is by slip.
    way_by_turn: f64,
}

/// Most ticks of turn that are taken for slip.
const MOST_SLIP: f64 = 200.0;

impl Step<'_> {
    /// Where it ends, and the direction of its way, with a turn of so many ticks more.
    fn end(&self, turned: i32) -> ([f64; 2], [f64; 2]) {
        let slip = f64::from(turned).clamp(-MOST_SLIP, MOST_SLIP);
        let turn = self.turn + slip;
        let half_rad = turn / (2.0 * TICKS_PER_RAD);
        // A chord against its arc.
        let chord = 1.0 - half_rad * half_rad / 6.0;
        let way = (self.way + slip * self.way_by_turn) * chord;
        let along @ [cos, sin] = self.directions.of(self.from[2] + 0.5 * turn);
        ([self.from[0] + way * cos, self.from[1] + way * sin], along)
    }
}

impl Guess<'_> {
    /// What a pose is off: on the axis that is nearer to the way; on the other, less what goes
    /// with that; of the heading.
    pub fn off(&self, is: [i32; 3]) -> ([i32; 3], Found) {
        let turned = is[2].wrapping_sub(self.heading());
        let Place { at, axes, end } = self.place(turned);
        let off = |axis: usize| is[axis].wrapping_sub(at[axis]);
        let along = off(axes.first);
        let beside = off(1 - axes.first).wrapping_sub(axes.aside(along));
        ([along, beside, turned], Found { is, turned, end })
    }

    /// The pose that is off by so much.
    pub fn corrected(&self, [along, beside, turned]: [i32; 3]) -> Found {
        let Place { at, axes, end } = self.place(turned);
        let [mut x, mut y] = at;
        let across = axes.aside(along).wrapping_add(beside);
        let (first, second) = if axes.first == 0 {
            (&mut x, &mut y)
        } else {
            (&mut y, &mut x)
        };
        *first = first.wrapping_add(along);
        *second = second.wrapping_add(across);
        let is = [x, y, self.heading().wrapping_add(turned)];
        Found { is, turned, end }
    }

    fn heading(&self) -> i32 {
        match self {
            Guess::Still(at) => at[2],
            Guess::Rolling(step) => step.heading,
        }
    }

    /// The place that is expected of what turned by so much.
    fn place(&self, turned: i32) -> Place {
        match self {
            Guess::Still([x, y, _]) => Place {
                at: [*x, *y],
                axes: Axes::along([1.0, 0.0]),
                end: None,
            },
            Guess::Rolling(step) => {
                let (end, along) = step.end(turned);
                Place {
                    at: end.map(nearest),
                    axes: Axes::along(along),
                    end: Some(end),
                }
            }
        }
    }
}

/// Where something is expected that turned by so much, and the axes to measure from there.
struct Place {
    at: [i32; 2],
    axes: Axes,
    end: Option<[f64; 2]>,
}

/// The axis nearer to a way, 0 or 1, and how much of the other goes with it.
struct Axes {
    first: usize,
    slope: f64,
}

impl Axes {
    fn along([cos, sin]: [f64; 2]) -> Self {
        if cos.abs() >= sin.abs() {
            Self {
                first: 0,
                slope: sin / cos,
            }
        } else {
            Self {
                first: 1,
                slope: cos / sin,
            }
        }
    }

    fn aside(&self, along: i32) -> i32 {
        nearest(f64::from(along) * self.slope)
    }
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

    /// Where it is expected after a step with these commands; what was found there corrects it before
    /// the next.
    pub fn step(&mut self, command: [i16; 2]) -> Guess<'a> {
        for (speed, ticks) in self.wheels_rad_s.iter_mut().zip(command) {
            let wanted = f64::from(ticks) / TICKS_PER_COMMAND * self.top_speed_rad_s - *speed;
            let limit = self.acceleration_rad_s_step;
            *speed += wanted.clamp(-limit, limit);
        }
        let (from, [left, right]) = (self.at, self.wheels_rad_s);
        let turn = (right - left) * self.turn;
        // Wheels slip by shares of their speeds, each by itself: the regression of way on turn.
        let squares = left * left + right * right;
        let way_by_turn = if squares > 0.0 {
            self.advance / self.turn * (right * right - left * left) / squares
        } else {
            0.0
        };
        self.at[2] = wrapped(self.at[2] + turn);
        Guess::Rolling(Step {
            directions: self.directions,
            from,
            heading: nearest(self.at[2]),
            turn,
            way: (left + right) * self.advance,
            way_by_turn,
        })
    }

    /// Corrects what was expected by what was.
    pub fn correct(&mut self, found: Found) {
        if let Some([x, y]) = found.end {
            [self.at[0], self.at[1]] = [x, y];
            if found.turned != 0 {
                self.at[2] = f64::from(found.is[2]);
            }
        }
        for (at, is) in self.at.iter_mut().zip(found.is) {
            if nearest(*at) != is {
                *at = f64::from(is);
            }
        }
    }
}
