//! Documents looked at before they are posted: what an arena is like, what a job would take.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ArenaListing;

/// A valid arena: what robots of the default preset can reach in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ArenaCheck {
    /// Its figures.
    pub arena: ArenaListing,
    /// Inner walls, generated ones too: x1, y1, x2, y2, metres; at most 10,000.
    pub walls_m: Vec<[f64; 4]>,
    /// A text for each row of squares, the lowest y first, with a letter for each square: `1` within
    /// reach of one of the starts, `0` not.
    pub reachable_rows: Vec<String>,
    /// Gates about as wide as the robot, from the narrowest; at most 100.
    pub gates: Vec<GateCheck>,
}

/// What of a run's arena its robots can reach from the first start pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reach {
    /// Squares that they can reach.
    pub reachable: u32,
    /// A text for each row of squares, the lowest y first, with a letter for each square: `1` within
    /// reach, `0` not.
    pub reachable_rows: Vec<String>,
}

/// A gate about as wide as a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GateCheck {
    /// Its middle, metres.
    pub x_m: f64,
    /// Its middle, metres.
    pub y_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Whether the robot passes.
    pub is_open: bool,
}

/// A valid job: what it would take.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JobCheck {
    /// Runs.
    pub runs: u64,
    /// Combinations of what varies, each with its seeds.
    pub combinations: u64,
    /// Robot-steps of all runs.
    pub robot_steps: u64,
    /// Most robots of a run.
    pub robots: u32,
    /// Most bytes that a robot's learner may hold at any moment.
    pub learner_bytes: u64,
    /// About how many bytes the largest run holds.
    pub run_bytes: u64,
    /// About how long all runs take, without others beside them, seconds.
    pub time_s: f64,
    /// Whether that is by runs of the same methods and engines that this server has done; else some
    /// cost was assumed.
    pub is_measured: bool,
    /// Runs that are stepped at a time.
    pub workers: u64,
}
