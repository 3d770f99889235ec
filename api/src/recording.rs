//! Recordings of runs: what there are, what is asked for, and slices of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most moments of a slice.
pub const MOST_MOMENTS: u32 = 10_000;
/// Most robots and objects of a slice, together, times its moments.
pub const MOST_SLICE_POSES: u32 = 100_000;

/// How far a recording has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RecordingState {
    /// It waits for the one before it.
    Queued,
    /// It is being made.
    Recording,
    /// All of it is there.
    Done,
    /// It was given up; what there is of it can be read.
    Cut,
}

/// A stretch of epochs of one phase.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RecordedPhase {
    /// The phase.
    pub phase: String,
    /// Its first epoch, counted from 0 over all phases.
    pub from_epoch: u64,
    /// Epochs of an arena that it takes.
    pub epochs: u64,
    /// Whether it is in the training arena.
    pub in_training: bool,
    /// Whether every second epoch shows the one before in the target arena.
    pub shows: bool,
}

/// What a recording is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordingHead {
    /// How far it is.
    pub state: RecordingState,
    /// Hash of what was simulated: recordings of the same are comparable byte by byte.
    pub subject: String,
    /// First epoch, counted from 0 over all phases.
    pub from_epoch: u64,
    /// Epochs.
    pub epochs: u64,
    /// Steps of an epoch.
    pub steps_per_epoch: u32,
    /// Steps 0, n, 2n, ... of each epoch are recorded.
    pub every_steps: u32,
    /// Steps of the arena, counted over all phases, before which moments are there.
    pub to_step: u64,
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Whether robots are put back at the beginning of an epoch.
    pub resets: bool,
    /// Radius of a robot, metres.
    pub body_radius_m: f64,
    /// Robots of the run.
    pub robots_total: u32,
    /// Robots that are recorded: the first so many, where there is no list.
    pub robots: u32,
    /// Their numbers, where they are not the first.
    pub robot_numbers: Option<Vec<u32>>,
    /// Movable objects.
    pub objects: u32,
    /// What is recorded of a robot.
    pub fields: Vec<String>,
    /// Phases of the run.
    pub phases: Vec<RecordedPhase>,
}

/// An epoch of an arena.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RecordedEpoch {
    /// Its number, from 0 over all phases.
    pub epoch: u64,
    /// Its phase.
    pub phase: String,
    /// Its number within the phase, from 0.
    pub phase_epoch: u64,
    /// Whether it is in the training arena.
    pub in_training: bool,
}

/// Poses over time, metres and radians.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordedPoses {
    /// Centre.
    pub x_m: Vec<f64>,
    /// Centre.
    pub y_m: Vec<f64>,
    /// Heading.
    pub heading_rad: Vec<f64>,
}

/// A robot over time; what is not recorded is empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordedRobot {
    /// Its number.
    pub robot: u32,
    /// Where it was.
    #[serde(flatten)]
    pub poses: RecordedPoses,
    /// The command of the left wheel that led here, -1 to 1.
    pub left: Vec<f64>,
    /// As above, of the right wheel.
    pub right: Vec<f64>,
    /// The state that it was in; null where its learner has none.
    pub state: Vec<Option<u16>>,
    /// The action whose command led here.
    pub action: Vec<Option<u16>>,
    /// What the proximity sensors ps0 to ps7 read, 0 to 4095.
    pub sensors: Vec<[u16; 8]>,
}

/// `GET /v1/runs/{id}/recording.json`: moments in order of time, column by column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordingSlice {
    /// What it is a slice of.
    pub recording: RecordingHead,
    /// Epochs that moments are in.
    pub epochs: Vec<RecordedEpoch>,
    /// Of each moment, the steps of the arena that were done, counted over all phases.
    pub step: Vec<u64>,
    /// Of each moment, its epoch.
    pub epoch: Vec<u64>,
    /// Of each moment, the steps of its epoch that were done; 0 is where robots begin.
    pub epoch_step: Vec<u32>,
    /// Robots.
    pub robots: Vec<RecordedRobot>,
    /// Movable objects, in the arena's order.
    pub objects: Vec<RecordedPoses>,
    /// Where to go on, when the slice was too long for one answer.
    pub next_step: Option<u64>,
}

/// `POST /v1/runs/{id}/recordings`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AskRecording {
    /// First epoch, counted from 0 over all phases; 0 unless it is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_epoch: Option<u64>,
    /// Epochs; all that follow unless it is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epochs: Option<u64>,
    /// Every so many steps; 1 unless it is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_steps: Option<u64>,
    /// `"all"`, how many of the first, or a list of numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robots: Option<serde_json::Value>,
    /// What of a robot: `pose`, `command`, `sensors`, `decision`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fields: Option<Vec<String>>,
}

/// One recording of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordingSummary {
    /// `live` for what the run recorded of itself, else a number.
    pub name: String,
    /// How far it is.
    pub state: RecordingState,
    /// Of one that is being made, the share that is done.
    pub progress: Option<f64>,
    /// Why it was given up.
    pub reason: Option<String>,
    /// First epoch, counted from 0 over all phases.
    pub from_epoch: u64,
    /// Epochs.
    pub epochs: u64,
    /// Every so many steps.
    pub every_steps: u32,
    /// `"all"`, how many of the first, or a list of numbers.
    pub robots: serde_json::Value,
    /// What of a robot.
    pub fields: Vec<String>,
    /// Bytes so far.
    pub bytes: u64,
}

/// `GET /v1/runs/{id}/recordings`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordingList {
    /// Them: what the run recorded of itself first, then in the order in which they were asked for.
    pub items: Vec<RecordingSummary>,
}
