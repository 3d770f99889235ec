//! Differential drive: wheel commands to the exact arc of one control step.
//!
//! Headings are (cosine, sine) pairs turned by a polynomial and renormalised, so that no
//! trigonometric function of the platform takes part.

use crate::robot::RobotModel;

/// Constants of a step, derived once from a robot model.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    top_speed_rad_s: f32,
    acceleration_rad_s_step: f32,
    slip: f32,
    /// Half the turn, per difference of wheel speeds: r dt / (2 axle).
    half_turn_s: f32,
    /// Distance of the centre per sum of wheel speeds: r dt / 2.
    advance_m_s: f32,
}

/// Where a robot wants to be after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Chord of the arc, metres.
    pub dx_m: f32,
    /// Chord of the arc, metres.
    pub dy_m: f32,
    /// New heading.
    pub cos: f32,
    /// New heading.
    pub sin: f32,
}

/// Rounds a command in [-1, 1] to a tick, 1/1000.
#[inline(always)]
pub fn to_tick(command: f32) -> f32 {
    // Adding 1.5 * 2^23 leaves no fraction bits: rounds to nearest even on every machine.
    const ROUND: f32 = 12_582_912.0;
    ((command * 1000.0 + ROUND) - ROUND) * 0.001
}

impl Drive {
    /// The constants of a robot.
    pub fn new(model: &RobotModel) -> Self {
        let p = &model.parameters;
        let limit = p.max_wheel_acceleration_rad_s2 * p.step_s;
        Self {
            top_speed_rad_s: p.max_wheel_speed_rad_s as f32,
            acceleration_rad_s_step: if limit == 0.0 {
                f32::INFINITY
            } else {
                limit as f32
            },
            slip: p.wheel_slip as f32,
            half_turn_s: (p.wheel_radius_m * p.step_s / (2.0 * p.axle_m)) as f32,
            advance_m_s: (p.wheel_radius_m * p.step_s / 2.0) as f32,
        }
    }

    /// Whether wheels slip, so that [`Drive::step`] needs slip draws.
    #[inline(always)]
    pub fn slips(&self) -> bool {
        self.slip > 0.0
    }

    /// Wheel speeds after a step of acceleration towards the command.
    #[inline(always)]
    pub fn accelerate(&self, speed_rad_s: f32, command: f32) -> f32 {
        let command = if command > -1.0 { command } else { -1.0 };
        let command = if command < 1.0 { command } else { 1.0 };
        let change = to_tick(command) * self.top_speed_rad_s - speed_rad_s;
        let limit = self.acceleration_rad_s_step;
        let change = if change < limit { change } else { limit };
        let change = if change > -limit { change } else { -limit };
        speed_rad_s + change
    }

    /// A wheel's speed on the ground under slip; `unit` is uniform in [0, 1).
    #[inline(always)]
    pub fn slipped(&self, speed_rad_s: f32, unit: f32) -> f32 {
        speed_rad_s * (1.0 + self.slip * (2.0 * unit - 1.0))
    }

    /// The exact arc of one step with constant wheel speeds, from a heading.
    #[inline(always)]
    pub fn step(&self, left_rad_s: f32, right_rad_s: f32, cos: f32, sin: f32) -> Motion {
        let half = (right_rad_s - left_rad_s) * self.half_turn_s;
        let h2 = half * half;
        // Taylor polynomials, |half| <= 0.79: errors below 4e-8 (sine) and 3e-7 (cosine).
        let sinc = 1.0
            + h2 * (-1.0 / 6.0
                + h2 * (1.0 / 120.0 + h2 * (-1.0 / 5_040.0 + h2 * (1.0 / 362_880.0))));
        let ch =
            1.0 + h2 * (-0.5 + h2 * (1.0 / 24.0 + h2 * (-1.0 / 720.0 + h2 * (1.0 / 40_320.0))));
        let sh = half * sinc;
        let (mid_cos, mid_sin) = (cos * ch - sin * sh, sin * ch + cos * sh);
        let chord = (left_rad_s + right_rad_s) * self.advance_m_s * sinc;
        let (c, s) = (mid_cos * ch - mid_sin * sh, mid_sin * ch + mid_cos * sh);
        // One Newton step of 1 / sqrt(c^2 + s^2) from 1 keeps the heading a unit vector.
        let scale = 1.5 - 0.5 * (c * c + s * s);
        Motion {
            dx_m: chord * mid_cos,
            dy_m: chord * mid_sin,
            cos: c * scale,
            sin: s * scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The arc by its textbook formula, in f64.
    fn arc(model: &RobotModel, left: f64, right: f64, heading: f64) -> (f64, f64, f64) {
        let p = &model.parameters;
        let v = p.wheel_radius_m * (left + right) / 2.0;
        let w = p.wheel_radius_m * (right - left) / p.axle_m;
        let turn = w * p.step_s;
        if w.abs() < 1e-12 {
            return (
                v * p.step_s * heading.cos(),
                v * p.step_s * heading.sin(),
                heading,
            );
        }
        let r = v / w;
        let end = heading + turn;
        (
            r * (end.sin() - heading.sin()),
            r * (heading.cos() - end.cos()),
            end,
        )
    }

    #[test]
    fn follows_the_exact_arc() {
        let model = RobotModel::default();
        let drive = Drive::new(&model);
        for (left, right) in [
            (6.27, 6.27),
            (6.27, -6.27),
            (3.0, 1.0),
            (-2.0, 5.0),
            (0.0, 0.0),
        ] {
            for heading in [0.0_f64, 1.0, 2.5, -3.0] {
                let m = drive.step(
                    left as f32,
                    right as f32,
                    heading.cos() as f32,
                    heading.sin() as f32,
                );
                let (x, y, end) = arc(&model, left, right, heading);
                assert!(
                    (f64::from(m.dx_m) - x).abs() < 1e-8,
                    "{left} {right} {heading}"
                );
                assert!((f64::from(m.dy_m) - y).abs() < 1e-8);
                assert!((f64::from(m.cos) - end.cos()).abs() < 1e-6);
                assert!((f64::from(m.sin) - end.sin()).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn top_speed_is_reached_under_the_acceleration_limit() {
        let model = RobotModel::default();
        let drive = Drive::new(&model);
        let top = model.parameters.max_wheel_speed_rad_s as f32;
        let mut speed = 0.0;
        let mut steps = 0;
        while speed < top {
            speed = drive.accelerate(speed, 1.0);
            steps += 1;
        }
        // 6.28 rad/s at 20 rad/s2 and 0.064 s a step.
        assert_eq!(steps, 5);
        assert_eq!(drive.accelerate(speed, 5.0), speed);
        assert_eq!(
            drive.accelerate(speed, f32::NAN),
            drive.accelerate(speed, -1.0)
        );
    }

    #[test]
    fn commands_are_rounded_to_ticks() {
        assert_eq!(to_tick(0.12345), 123.0 * 0.001);
        assert_eq!(to_tick(-0.9996), -1000.0 * 0.001);
    }

    #[test]
    fn heading_stays_a_unit_vector() {
        let drive = Drive::new(&RobotModel::default());
        let (mut c, mut s) = (1.0, 0.0);
        for k in 0..1_000_000 {
            let m = drive.step((k % 7) as f32 - 3.0, (k % 11) as f32 - 5.0, c, s);
            (c, s) = (m.cos, m.sin);
        }
        assert!((c * c + s * s - 1.0).abs() < 1e-6);
    }
}
