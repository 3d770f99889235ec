//! What crosses the process boundary: requests, responses, problems, events, channel payloads.
//!
//! Types only. Documents that are stored or sent to others carry a `schema` number.

pub mod catalog;
pub mod channels;
pub mod checks;
pub mod comparison;
pub mod control;
pub mod controller;
pub mod curves;
pub mod events;
pub mod explanation;
pub mod external;
pub mod frames;
pub mod job;
pub mod learnt;
pub mod objects;
pub mod problem;
pub mod problem_codes;
pub mod reader;
pub mod recording;
pub mod refusals;
pub mod result;
pub mod spec;
pub mod state;
pub mod summary;
mod workers;

pub use catalog::{
    ArenaList, ArenaListing, ControllerListing, Health, MethodListing, ParameterListing,
    PresetListing, TemplateList, TemplateListing, Version,
};
pub use control::{CheckpointInfo, Epochs, ExtendJob, Fork, Priority, RunLog, RunLogEntry};
pub use job::{Job, JobPage, RunCounts, RunOrigin, RunPage, RunSummary};
pub use objects::{ObjectSample, ObjectTrack, ObjectTracks};
pub use problem::{FieldError, Problem, ProblemList, ProblemMeaning};
pub use problem_codes::ProblemCode;
pub use recording::{
    AskRecording, RecordedEpoch, RecordedPhase, RecordedPoses, RecordedRobot, RecordingHead,
    RecordingList, RecordingSlice, RecordingState, RecordingSummary,
};
pub use result::{
    ClusterCounts, Coverage, CurveRow, Fractions, Levels, Memory, MemoryPlan, MetricValues,
    Metrics, MetricsRow, ModelAccuracy, ObjectResult, RunResult, Squares,
};
pub use spec::{
    ArenaRef, ControllerSpec, JobPart, JobSpec, PlacementSpec, RecordSpec, RobotSpec, RunSpec,
    SCHEMA, Seeds, SharingSpec, StartSpec, TrainSpec,
};
pub use state::{Progress, State, WaitsFor};
pub use summary::JobSummary;
pub use workers::{Worker, Workers};
