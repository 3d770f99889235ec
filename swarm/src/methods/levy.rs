//! A Levy walk: straight steps whose lengths follow a power law, each after a turn by an angle drawn
//! uniformly. A step ends early at whatever is ahead, as a flight does at what it meets (Viswanathan
//! et al. 1999), and the next one begins.

use serde::{Deserialize, Serialize};

use super::definition::{Definition, Explores, Trains, explore_only};
use super::walker::Walker;
use crate::bodies::{Body, Reading};
use crate::controllers::Controller;
use crate::dimensions::WHEELS;
use crate::engine::drive::to_tick;
use crate::parameters::Domain::Real;
use crate::parameters::parameter_table;
use crate::random::{draw, unit};
use crate::spec::{FieldError, Method, MethodParameters, RunSpec};

pub(super) static LEVY: Definition = Definition {
    method: Method::Levy,
    about: "Levy walk: straight steps of power-law lengths, uniform turns; a step ends early at a wall or robot",
    source: "Viswanathan et al., Nature 401 (1999); Dimidov et al., ANTS 2016",
    trains: Trains::Never,
    objective: None,
    explores: Explores::Walking,
    parameters: || MethodParameters::new(LevyParameters::TABLE, LevyParameters::default().shown()),
    check,
    stages: explore_only,
};

parameter_table! {
    /// Parameters of the method `levy`.
    LevyParameters {
        mu: f64 = 2.0, Real { min: 1.001, max: 3.0 }, "1", "Exponent of the density of step lengths, l^-mu", "Viswanathan et al. 1999: 1 < mu <= 3, 2 is best for sparse targets";
        min_length_m: f64 = 0.07, Real { min: 0.001, max: 100.0 }, "m", "Shortest step", "a body's diameter";
        max_length_m: f64 = 10.0, Real { min: 0.001, max: 1_000.0 }, "m", "Longest step", "truncated power law; more than an epoch of 2,000 steps crosses in any of the arenas";
        wall_reading: f64 = 150.0, Real { min: 0.0, max: 4_095.0 }, "1", "Raw value of one of the two foremost sensors from which a step ends", "4 cm from the sensor: the way that an e-puck at top speed needs to stop";
    }
}

fn check(spec: &RunSpec) -> Option<FieldError> {
    let p = parameters(spec);
    (p.min_length_m > p.max_length_m).then(|| FieldError {
        pointer: "/controller/min_length_m".to_owned(),
        message: format!("{} is above max_length_m", p.min_length_m),
        allowed: format!("at most {}, the max_length_m", p.max_length_m),
    })
}

fn parameters(spec: &RunSpec) -> LevyParameters {
    let mut parameters = LevyParameters::default();
    let own = &spec.controller.own;
    own.hand_to(|name, value| parameters.set(name, value));
    parameters
}

/// Sensors that look ahead; the next ones, at 46 degrees, see both walls of a corridor.
const FRONT: [usize; 2] = [0, 7];
/// What is left of a turn or a way, in steps at top speed, when it counts as done: about half a
/// tick of the wheels, below which they stand still.
const DONE: f32 = 0.000_6;

/// The lengths of steps: density proportional to l^-mu between the shortest and the longest.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Lengths {
    shortest: f64,
    /// 1 / (mu - 1).
    exponent: f64,
    /// 1 - (shortest / longest)^(mu - 1): the share of an untruncated law below the longest.
    below_longest: f64,
}

impl Lengths {
    fn new(mu: f64, shortest: f64, longest: f64) -> Self {
        Self {
            shortest,
            exponent: 1.0 / (mu - 1.0),
            below_longest: 1.0 - libm::pow(shortest / longest, mu - 1.0),
        }
    }

    /// The inverse of the distribution at `u` in [0, 1).
    fn at(&self, u: f64) -> f64 {
        self.shortest / power(1.0 - u * self.below_longest, self.exponent)
    }
}

/// x^exponent for x in (0, 1] and an exponent that is not negative, by products and square roots
/// alone: x^(2^k) for each bit of the exponent, down to 2^-40.
fn power(x: f64, exponent: f64) -> f64 {
    let mut result = 1.0;
    let (mut whole, mut square) = (exponent as u64, x);
    let mut fraction = exponent - whole as f64;
    while whole > 0 {
        if whole & 1 == 1 {
            result *= square;
        }
        square *= square;
        whole >>= 1;
    }
    let mut root = x;
    for _ in 0..40 {
        root = root.sqrt();
        fraction *= 2.0;
        if fraction >= 1.0 {
            fraction -= 1.0;
            result *= root;
        }
    }
    result
}

/// A robot on its walk. It measures turns and ways by what its wheels do, in steps at top speed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Levy {
    key: u64,
    /// Steps begun.
    begun: u64,
    lengths: Lengths,
    /// Way of a control step at top speed, metres.
    way_m: f64,
    /// Turn of a control step with the wheels at opposite top speeds.
    turn_rad: f64,
    /// Most that a wheel's speed changes in a control step, as a share of the top speed.
    acceleration: f32,
    wall_reading: f32,
    /// Speeds of the wheels as shares of the top speed, left and right.
    wheels: [f32; WHEELS],
    /// What is left of the turn; to the left where it is positive.
    turn_left: f32,
    /// What is left of the way after it.
    way_left: f32,
}

impl Levy {
    /// Draws turn and length of the next step.
    #[inline(never)]
    fn begin(&mut self) {
        let bits = draw(self.key, self.begun);
        self.begun += 1;
        let u = f64::from(bits as u32) * (1.0 / 4_294_967_296.0);
        let half_turns = 2.0 * f64::from(unit((bits >> 32) as u32)) - 1.0;
        self.way_left = (self.lengths.at(u) / self.way_m) as f32;
        self.turn_left = (half_turns * std::f64::consts::PI / self.turn_rad) as f32;
    }

    /// The speed towards a goal `left` away, from which the wheels can still stop there: the
    /// greatest s with s + (s - a) + (s - 2 a) ... <= left, a the acceleration.
    #[inline(always)]
    fn towards(&self, left: f32) -> f32 {
        let a = self.acceleration;
        let stops = 0.5 * a * ((1.0 + 8.0 * left / a).sqrt() - 1.0);
        let stops = if stops < left { stops } else { left };
        if stops < 1.0 { stops } else { 1.0 }
    }

    /// Gives a command, and takes into account what the wheels make of it.
    #[inline(always)]
    fn drive(&mut self, command: [f32; WHEELS]) -> [f32; WHEELS] {
        for (wheel, command) in self.wheels.iter_mut().zip(command) {
            let change = to_tick(command) - *wheel;
            let limit = self.acceleration;
            let change = if change < limit { change } else { limit };
            *wheel += if change > -limit { change } else { -limit };
        }
        command
    }
}

impl Walker for Levy {
    fn new(spec: &RunSpec, key: u64) -> Self {
        let (own, robot) = (parameters(spec), &spec.robot.parameters);
        let top_rad_s = robot.max_wheel_speed_rad_s;
        let limit_rad_s = robot.max_wheel_acceleration_rad_s2 * robot.step_s;
        let way_m = top_rad_s * robot.wheel_radius_m * robot.step_s;
        let limited = limit_rad_s > 0.0 && limit_rad_s < top_rad_s;
        Self {
            key,
            begun: 0,
            lengths: Lengths::new(own.mu, own.min_length_m, own.max_length_m),
            // A robot that cannot move is for ever on its first turn.
            way_m: way_m.max(1e-9),
            turn_rad: (2.0 * way_m / robot.axle_m).max(1e-9),
            acceleration: if limited {
                (limit_rad_s / top_rad_s) as f32
            } else {
                2.0
            },
            wall_reading: own.wall_reading as f32,
            wheels: [0.0; 2],
            turn_left: 0.0,
            way_left: 0.0,
        }
    }

    /// A robot that was put back begins a new step.
    #[inline(always)]
    fn begin_epoch(&mut self, body: &Body) {
        if body.wheels_rad_s == [0.0; 2] {
            self.wheels = [0.0; 2];
            (self.turn_left, self.way_left) = (0.0, 0.0);
        }
    }
}

impl Controller for Levy {
    #[inline(always)]
    fn act(&mut self, _step: u64, reading: &Reading) -> [f32; WHEELS] {
        let turned = self.turn_left.abs() < DONE;
        if turned {
            let meets = FRONT
                .iter()
                .any(|&sensor| reading.proximity[sensor] >= self.wall_reading);
            if meets || self.way_left < DONE {
                self.begin();
            }
        }
        let [left, right] = self.wheels;
        if self.turn_left.abs() < DONE {
            if (right - left).abs() > DONE {
                // Wheels that speed up alike would go on turning.
                return self.drive([0.0, 0.0]);
            }
            let speed = self.towards(self.way_left);
            let command = self.drive([speed, speed]);
            self.way_left -= 0.5 * (self.wheels[0] + self.wheels[1]);
            return command;
        }
        if (left + right).abs() > DONE {
            // To turn on the spot the robot stops first.
            return self.drive([0.0, 0.0]);
        }
        let speed = self.towards(self.turn_left.abs());
        let speed = if self.turn_left < 0.0 { -speed } else { speed };
        let command = self.drive([-speed, speed]);
        self.turn_left -= 0.5 * (self.wheels[1] - self.wheels[0]);
        command
    }

    #[inline(always)]
    fn learn(&mut self, _reading: &Reading) {}
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::engine::drive::Drive;
    use crate::parameters::Value;
    use crate::run::Run;

    fn spec(own: &[(&str, f64)]) -> RunSpec {
        let mut parameters = (LEVY.parameters)();
        for (name, value) in own {
            parameters.set(name, Value::Number(*value)).unwrap();
        }
        let arena = Arc::new(arenas::builtin("easy").unwrap());
        let mut spec = RunSpec::new(Method::Levy, arena);
        spec.controller.own = parameters;
        spec
    }

    fn reading(proximity: [f32; 8]) -> Reading {
        Reading { proximity }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// Kolmogorov-Smirnov: the greatest difference between the share of lengths below l and
        /// (1 - (l / min)^(1 - mu)) / (1 - (max / min)^(1 - mu)) is below 3 / sqrt(n), which by
        /// chance is not so once in 10^7.
        #[test]
        fn lengths_follow_the_power_law(
            mu in 1.001..=3.0_f64, shortest in 0.001..1.0_f64, ratio in 1.01..1e4_f64, key: u64,
        ) {
            let longest = shortest * ratio;
            let mut levy = Levy::new(&spec(&[
                ("mu", mu), ("min_length_m", shortest), ("max_length_m", longest.min(1_000.0)),
            ]), key);
            let longest = longest.min(1_000.0);
            let n = 20_000;
            let mut lengths: Vec<f64> = (0..n)
                .map(|_| {
                    levy.begin();
                    f64::from(levy.way_left) * levy.way_m
                })
                .collect();
            lengths.sort_by(f64::total_cmp);
            prop_assert!(lengths[0] >= shortest * (1.0 - 1e-6));
            prop_assert!(lengths[n - 1] <= longest * (1.0 + 1e-6));
            let below = |l: f64| {
                (1.0 - libm::pow(l / shortest, 1.0 - mu))
                    / (1.0 - libm::pow(longest / shortest, 1.0 - mu))
            };
            let farthest = lengths.iter().enumerate().fold(0.0_f64, |farthest, (place, &length)| {
                farthest.max((below(length) - place as f64 / n as f64).abs())
            });
            prop_assert!(farthest < 3.0 / libm::sqrt(n as f64), "{farthest}");
        }

        #[test]
        fn powers_are_those_of_libm(x in 1e-9..=1.0_f64, exponent in 0.0..50.0_f64) {
            let expected = libm::pow(x, exponent);
            prop_assert!((power(x, exponent) - expected).abs() <= 1e-11 * expected + 1e-300);
        }
    }

    #[test]
    fn turns_are_uniform() {
        let mut levy = Levy::new(&spec(&[]), 9);
        let n = 20_000;
        let mut turns_rad: Vec<f64> = (0..n)
            .map(|_| {
                levy.begin();
                f64::from(levy.turn_left) * levy.turn_rad
            })
            .collect();
        turns_rad.sort_by(f64::total_cmp);
        for (place, turn_rad) in turns_rad.iter().enumerate() {
            let below = 0.5 + turn_rad / std::f64::consts::TAU;
            let difference = below - place as f64 / n as f64;
            assert!(difference.abs() < 3.0 / libm::sqrt(n as f64), "{turn_rad}");
        }
    }

    /// Wheels take time to change their speed; turns and ways come out as drawn all the same.
    #[test]
    fn what_is_driven_is_what_was_drawn() {
        for acceleration_rad_s2 in [0.0, 10.0, 100.0] {
            let mut spec = spec(&[("max_length_m", 2.0)]);
            spec.robot.parameters.max_wheel_acceleration_rad_s2 = acceleration_rad_s2;
            let mut levy = Levy::new(&spec, 7);
            let drive = Drive::new(&spec.robot);
            let (mut wheels, mut cos, mut sin) = ([0.0_f32; 2], 1.0_f32, 0.0_f32);
            let (mut x_m, mut y_m) = (0.0_f64, 0.0_f64);
            // Length and direction of each step, as drawn and as driven.
            let mut drawn: Vec<(f64, f64)> = Vec::new();
            let mut driven: Vec<(f64, f64)> = Vec::new();
            let (mut from, mut heading_rad) = ((0.0, 0.0), 0.0);
            while driven.len() < 200 {
                let begun = levy.begun;
                let drawing = levy.clone();
                let command = levy.act(0, &reading([0.0; 8]));
                if levy.begun > begun {
                    if begun > 0 {
                        let (dx_m, dy_m) = (x_m - from.0, y_m - from.1);
                        driven.push((libm::hypot(dx_m, dy_m), libm::atan2(dy_m, dx_m)));
                    }
                    let mut drawing = drawing;
                    drawing.begin();
                    heading_rad += f64::from(drawing.turn_left) * levy.turn_rad;
                    drawn.push((f64::from(drawing.way_left) * levy.way_m, heading_rad));
                    from = (x_m, y_m);
                }
                for (wheel, command) in wheels.iter_mut().zip(command) {
                    *wheel = drive.accelerate(*wheel, command);
                }
                let motion = drive.step(wheels[0], wheels[1], cos, sin);
                (x_m, y_m) = (x_m + f64::from(motion.dx_m), y_m + f64::from(motion.dy_m));
                (cos, sin) = (motion.cos, motion.sin);
            }
            let mut off_rad = 0.0;
            for ((length_m, heading_rad), (driven_m, direction_rad)) in drawn.iter().zip(&driven) {
                assert!((length_m - driven_m).abs() < 0.003, "{length_m} {driven_m}");
                // Small errors of turns add up: each is told from the step before.
                let difference = direction_rad - heading_rad - off_rad;
                let turns = libm::round(difference / std::f64::consts::TAU);
                let difference = difference - turns * std::f64::consts::TAU;
                assert!(difference.abs() < 0.05, "{difference}");
                off_rad += difference;
            }
        }
    }

    #[test]
    fn a_wall_ahead_ends_the_step() {
        let mut levy = Levy::new(&spec(&[("min_length_m", 5.0)]), 1);
        let mut free = [34.0; 8];
        while levy.begun == 0 || levy.turn_left.abs() >= DONE {
            levy.act(0, &reading(free));
        }
        free[1..7].fill(4_000.0);
        levy.act(0, &reading(free));
        assert_eq!(levy.begun, 1, "what is beside or behind ends nothing");
        free[7] = 200.0;
        levy.act(0, &reading(free));
        assert_eq!(levy.begun, 2);
    }

    #[test]
    fn lengths_that_do_not_go_together_are_refused() {
        let wrong = spec(&[("min_length_m", 2.0), ("max_length_m", 1.0)]);
        let errors = wrong.validate().unwrap_err();
        assert_eq!(errors.len(), 1);
        assert_eq!(errors[0].pointer, "/controller/min_length_m");
        let equal = spec(&[("min_length_m", 1.0), ("max_length_m", 1.0)]);
        assert!(equal.validate().is_ok());
    }

    #[test]
    fn corridors_do_not_hold_it_up() {
        let way_m = |method| {
            let arena = Arc::new(arenas::builtin("maze").unwrap());
            let spec = RunSpec {
                epochs: 5,
                ..RunSpec::new(method, arena)
            };
            let mut run = Run::new(spec.validate().unwrap()).unwrap();
            run.advance(u64::MAX);
            run.metrics().robots[0].distance_m
        };
        let [levy_m, brownian_m] = [Method::Levy, Method::Brownian].map(way_m);
        assert!(levy_m > 1.5 * brownian_m, "{levy_m} {brownian_m}");
    }
}
