//! What a recording is of: written once, at its beginning, as compressed JSON.

use serde::{Deserialize, Serialize};

/// A recording's first part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Hash of the run's spec but for what it records and shows, and of the version of results.
    pub subject: String,
    /// Version of results.
    pub results_version: u32,
    /// The run's spec with every default filled in, but for what it records and shows.
    pub spec: serde_json::Value,
    /// The arena in which visits count.
    pub arena: serde_json::Value,
    /// The arena in which robots train, where it is another.
    pub training_arena: Option<serde_json::Value>,
    /// Radius of a robot, metres.
    pub body_radius_m: f64,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Steps of an epoch.
    pub steps_per_epoch: u32,
    /// Whether robots are put back to their starts at the beginning of an epoch.
    pub resets: bool,
    /// The stages of the run, in order.
    pub stages: Vec<StageMark>,
    /// First epoch recorded, counted from 0 over all stages.
    pub from_epoch: u64,
    /// Epochs recorded.
    pub epochs: u64,
    /// Steps 0, n, 2n, ... of each epoch are recorded.
    pub every_steps: u32,
    /// Robots in all.
    pub robots_total: u32,
    /// Which of them are recorded.
    pub robots: Chosen,
    /// Movable objects, in the arena that has more.
    pub objects: u32,
    /// What is recorded of a robot.
    pub fields: Fields,
    /// How commands move a robot that touches nothing.
    pub drive: DriveModel,
}

/// Some or all robots.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Chosen {
    /// The first so many.
    First(u32),
    /// These, in ascending order.
    List(Vec<u32>),
}

impl Chosen {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Chosen::First(count) => *count as usize,
            Chosen::List(list) => list.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of the robot in a row.
    pub fn number(&self, row: usize) -> u32 {
        match self {
            Chosen::First(_) => row as u32,
            Chosen::List(list) => list[row],
        }
    }

    /// The row of a robot.
    pub fn row(&self, number: u32) -> Option<usize> {
        match self {
            Chosen::First(count) => (number < *count).then_some(number as usize),
            Chosen::List(list) => list.binary_search(&number).ok(),
        }
    }

    /// Whether they are in order, each once, and below a number.
    pub fn is_ascending_below(&self, end: u32) -> bool {
        match self {
            Chosen::First(count) => *count <= end,
            Chosen::List(list) => {
                list.is_sorted_by(|a, b| a < b) && list.last().is_none_or(|last| *last < end)
            }
        }
    }

    /// The numbers in order.
    pub fn numbers(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.len()).map(|row| self.number(row))
    }
}

/// What is recorded of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fields {
    /// Position and heading.
    pub pose: bool,
    /// Wheel commands.
    pub command: bool,
    /// What the proximity sensors read.
    pub sensors: bool,
    /// State and action.
    pub decision: bool,
}

impl Fields {
    /// Everything.
    pub const ALL: Self = Self {
        pose: true,
        command: true,
        sensors: true,
        decision: true,
    };
}

/// A stretch of epochs of one phase.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StageMark {
    /// Name of the phase.
    pub phase: String,
    /// Its epochs.
    pub epochs: u32,
    /// Whether it is in the training arena.
    pub in_training: bool,
    /// Whether each epoch is followed by one that shows the same in the other arena.
    pub shows: bool,
}

/// Constants of a step of a differential drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveModel {
    /// Wheel speed at command 1, rad/s.
    pub top_speed_rad_s: f64,
    /// Most change of a wheel's speed in a step, rad/s; none where it is absent.
    pub acceleration_rad_s_step: Option<f64>,
    /// Way of the centre per sum of both wheels' speeds, metres per rad/s.
    pub advance_m_s: f64,
    /// Turn per difference of wheel speeds, rad per rad/s.
    pub turn_s: f64,
}
