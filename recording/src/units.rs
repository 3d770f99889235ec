//! Ticks that samples are kept in, and how many sensors a robot has.

/// Ticks of a length: 0.1 mm.
pub const TICKS_PER_M: f64 = 10_000.0;
/// Ticks of a heading: 1 mrad.
pub const TICKS_PER_RAD: f64 = 1_000.0;
/// Ticks of a wheel command, as the robots' motors have them.
pub const TICKS_PER_COMMAND: f64 = 1_000.0;
/// Proximity sensors of a robot.
pub const SENSORS: usize = 8;
