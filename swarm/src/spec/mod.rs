//! What a run is made from, as plain data: parameters, choices, limits.

mod controller;
mod field_error;
mod limits;
mod method;
mod method_parameters;
mod run_spec;
mod sharing;

pub use controller::{
    ClusterScale, ControllerParameters, ControllerPreset, EpsilonIs, Insufficiency, SensorScale,
    StatesFrom, Ties,
};
pub use field_error::FieldError;
pub use limits::{MAX_EPOCHS, MAX_ROBOTS, MAX_STEPS_PER_EPOCH};
pub use method::{Method, Objective};
pub use method_parameters::MethodParameters;
pub use run_spec::{ControllerSpec, EngineKind, Episodes, Placement, RunSpec, Training};
pub use sharing::{
    DEFAULT_BYTES_PER_STEP, DEFAULT_RANGE_M, LEAST_BYTES_PER_STEP, MOST_BYTES_PER_STEP, RadioLink,
    Sharing, SharingMode,
};
