//! How many numbers a robot senses and commands. Arrays of them have these lengths and no other.

/// Proximity sensors.
pub const PROXIMITY_SENSORS: usize = 8;
/// Wheels, and so numbers of a command: left, right.
pub const WHEELS: usize = 2;
/// Length of a sensori-motor vector: proximity values, then the command given in answer to them.
pub const SENSORI_MOTOR: usize = PROXIMITY_SENSORS + WHEELS;
