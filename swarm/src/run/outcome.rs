//! What a run tells its owner.

use serde::Serialize;

use super::coverage::CurveRow;
use super::robot_memory::RobotMemory;
use crate::bodies::ObjectPose;
use crate::caps::MemoryPlan;
use crate::learn::accuracy::Divergence;
use crate::metrics::Value;
use crate::spec::FieldError;
use crate::stages::Phase;

/// How far a run is. Steps are robot-steps, uncounted phases included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// What it is doing.
    pub phase: Phase,
    /// Counted epochs that are complete.
    pub epochs_done: u32,
    /// Counted epochs in all.
    pub epochs_total: u32,
    /// Robot-steps done.
    pub robot_steps_done: u64,
    /// Robot-steps in all.
    pub robot_steps_total: u64,
}

/// What a finished run has to say; nothing about time or machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Coverage after the last counted epoch.
    pub coverage: CurveRow,
    /// Squares that a robot of this size can reach from the first start pose.
    pub reachable: u32,
    /// Of these, the squares entered at least 1, 2, 5 and 10 times.
    pub coverage_reachable: [u32; 4],
    /// Squares in which at least 1, 2, 5 and 10 counted steps were spent.
    pub dwell: [u32; 4],
    /// Names and values of the swarm metrics at the end.
    pub metrics: Vec<(&'static str, Option<Value>)>,
    /// Robot-steps, uncounted phases included.
    pub robot_steps: u64,
    /// Robot-steps of the counted epochs that touched a wall or a robot.
    pub collisions: u64,
    /// Clusters of the first robot's learner; 0 where the method has none.
    pub sensor_clusters: u32,
    /// As above.
    pub actuator_clusters: u32,
    /// As above, of phase 1.
    pub sensori_motor_clusters: u32,
    /// How far the first robot's transition table is from a reference of random actions; `None` where
    /// it has none.
    pub model: Option<Divergence>,
    /// Bytes that robots, learners and squares hold, exactly counted.
    pub bytes: u64,
    /// What each robot's learner could hold.
    pub memory_plan: MemoryPlan,
    /// What each robot's learner held at the end; index is the robot's number.
    pub memory: Vec<RobotMemory>,
    /// What became of the target arena's movable objects, in their order.
    pub objects: Vec<ObjectOutcome>,
    /// SHA-256 of the final state, in hex.
    pub state_sha256: String,
}

/// What became of a movable object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ObjectOutcome {
    /// `box` or `disc`.
    pub kind: &'static str,
    /// Where it is at the end.
    pub pose: ObjectPose,
    /// Way that it was moved while visits counted, metres.
    pub moved_m: f64,
    /// How far it is at the end from where it began, metres.
    pub displaced_m: f64,
}

/// A snapshot that does not fit.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RestoreError {
    /// It was cut short, changed, or written by another version.
    #[error("the snapshot cannot be read: {0}")]
    Unreadable(String),
    /// It belongs to another spec.
    #[error("the snapshot belongs to another spec")]
    OtherSpec,
    /// It cannot be gone on from in this way.
    #[error("it cannot be gone on from: {0}")]
    CannotGoOn(String),
    /// The robots do not fit into the arenas of the spec.
    #[error("the spec cannot be run: {0:?}")]
    Spec(Vec<FieldError>),
}
