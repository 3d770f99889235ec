//! Life cycle and progress of jobs and runs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where a job or a run is in its life.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Waits for a free thread.
    Queued,
    /// Is being stepped.
    Running,
    /// Stopped on request; can go on.
    Paused,
    /// Finished, with a result.
    Done,
    /// Finished, with an error.
    Failed,
    /// Stopped on request for good.
    Cancelled,
}

impl State {
    /// Every state, in order of declaration.
    pub const ALL: [State; 6] = [
        State::Queued,
        State::Running,
        State::Paused,
        State::Done,
        State::Failed,
        State::Cancelled,
    ];

    /// The names in JSON, in the same order.
    pub const NAMES: [&'static str; 6] = {
        let mut names = [""; 6];
        let mut number = 0;
        while number < names.len() {
            names[number] = Self::ALL[number].name();
            number += 1;
        }
        names
    };

    /// The name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            State::Queued => "queued",
            State::Running => "running",
            State::Paused => "paused",
            State::Done => "done",
            State::Failed => "failed",
            State::Cancelled => "cancelled",
        }
    }

    /// The state of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }

    /// Whether nothing more will happen by itself or by resuming.
    pub const fn is_final(self) -> bool {
        matches!(self, State::Done | State::Failed | State::Cancelled)
    }
}

impl std::fmt::Display for State {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Whom a run waits for that a worker holds. It waits at a step boundary, and goes on by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WaitsFor {
    /// Readers of its lossless channel, that are to come or lag behind.
    LosslessReaders,
    /// The programs that steer its robots.
    Controllers,
    /// The store, which cannot keep its end: it has no room, most likely.
    Store,
}

impl WaitsFor {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::LosslessReaders, Self::Controllers, Self::Store];

    /// The name in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::LosslessReaders => "lossless_readers",
            Self::Controllers => "controllers",
            Self::Store => "store",
        }
    }
}

/// How far a run is. Steps are robot-steps, uncounted phases included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Progress {
    /// `babbling`, `evolution`, `repository`, `exploration` or `done`.
    pub phase: String,
    /// Counted epochs that are complete.
    pub epochs_done: u32,
    /// Counted epochs in all.
    pub epochs_total: u32,
    /// Robot-steps done.
    pub robot_steps_done: u64,
    /// Robot-steps in all.
    pub robot_steps_total: u64,
    /// Share of the work done, 0 to 1.
    pub fraction: f64,
    /// Seconds left at the present pace; null until it is known.
    pub eta_s: Option<f64>,
    /// Robot-steps a second at the present pace; null unless it is running.
    #[serde(default)]
    pub robot_steps_per_s: Option<f64>,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn names_are_those_of_json() {
        for state in State::ALL {
            assert_eq!(serde_json::to_value(state).unwrap(), state.name());
            assert_eq!(State::from_name(state.name()), Some(state));
        }
        assert_eq!(State::from_name("asleep"), None);
        for whom in WaitsFor::ALL {
            assert_eq!(serde_json::to_value(whom).unwrap(), whom.name());
        }
    }
}
