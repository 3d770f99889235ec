//! Channels of a run beside its frames (what it covers, its metrics, its events, its status), and how
//! all channels are asked for and described over HTTP.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::frames::{TypeLayout, shared_type};
use iceoryx2::prelude::ZeroCopySend;

/// Version of the types of this file; part of their names, so that a reader of another version is
/// refused when it opens a channel.
pub const CHANNELS_VERSION: u32 = 1;

/// The key under which the blackboard holds the [`RunStatus`].
pub const STATUS_KEY: u64 = 0;

/// Names of [`RunStatus::state`].
pub const STATES: [&str; 5] = ["running", "let-go", "done", "waiting", "failed"];

/// Names of [`RunEvent::kind`].
pub const EVENTS: [&str; 4] = ["opened", "phase", "epoch", "ended"];

shared_type! {
    /// What a picture of the covered squares shows, beside them.
    CoverageHeader as "swarm.CoverageHeader.v1" {
        /// Pictures of the run sent before this one.
        sequence: u64,
        /// Steps of the arena since the run began.
        arena_step: u64,
        /// Steps in which visits counted.
        counted_steps: u64,
        /// Width of the arena, metres.
        width_m: f64,
        /// Height of the arena, metres.
        height_m: f64,
        /// Squares of the arena side by side.
        columns: u32,
        /// Squares of the arena one above the other.
        rows: u32,
        /// Squares that were entered at least once.
        entered: u32,
        /// [`CHANNELS_VERSION`] of the sender.
        version: u32,
    }
}

shared_type! {
    /// A square; row by row from the lowest y.
    SquareEntries as "swarm.SquareEntries.v1" {
        /// How often it was entered.
        entries: u32,
    }
}

shared_type! {
    /// The moment of a row of metrics.
    MetricsHeader as "swarm.MetricsHeader.v1" {
        /// Number of the row in the run, from 0.
        row: u64,
        /// Steps in which visits counted.
        counted_steps: u64,
        /// Counted epochs that are complete.
        epoch: u32,
        /// [`CHANNELS_VERSION`] of the sender.
        version: u32,
    }
}

shared_type! {
    /// A metric of a row; `docs/metrics.md` says what each is.
    MetricValue as "swarm.MetricValue.v1" {
        /// Its name in UTF-8, zeros behind it.
        name: [u8; 32],
        /// Its value; not a number where it has none.
        value: f64,
    }
}

impl MetricValue {
    /// A value under a name, of which the first 32 bytes are kept.
    pub fn new(name: &str, value: f64) -> Self {
        let mut place = [0; 32];
        for (to, from) in place.iter_mut().zip(name.bytes()) {
            *to = from;
        }
        Self { name: place, value }
    }

    /// The name.
    pub fn name(&self) -> &str {
        let end = self.name.iter().position(|&byte| byte == 0);
        let name = &self.name[..end.unwrap_or(self.name.len())];
        std::str::from_utf8(name).unwrap_or_default()
    }
}

shared_type! {
    /// Something that happened to a run.
    RunEvent as "swarm.RunEvent.v1" {
        /// Events since the channel was opened, before this one.
        sequence: u64,
        /// Steps of the arena since the run began.
        arena_step: u64,
        /// What it was, an index into [`EVENTS`].
        kind: u32,
        /// Of `opened` and `phase` the phase, of `epoch` the counted epochs that are complete, of
        /// `ended` an index into [`STATES`].
        value: u32,
    }
}

shared_type! {
    /// How a run is, on a blackboard.
    RunStatus as "swarm.RunStatus.v1" {
        /// Steps of the arena since the run began.
        arena_step: u64,
        /// Robot-steps done, all phases.
        robot_steps_done: u64,
        /// Robot-steps that the whole run has.
        robot_steps_total: u64,
        /// Simulated seconds since the run began.
        sim_time_s: f64,
        /// Robot-steps a second of wall time since the last look; 0 at the first.
        robot_steps_per_s: f64,
        /// What the run is doing, an index into `frames::PHASES`.
        phase: u32,
        /// How it is, an index into [`STATES`].
        state: u32,
        /// Counted epochs that are complete.
        epochs_done: u32,
        /// Counted epochs in all.
        epochs_total: u32,
        /// Robots of the run.
        robots: u32,
        /// [`CHANNELS_VERSION`] of the sender.
        version: u32,
    }
}

/// Name of a service of a run: `coverage`, `metrics`, `events`, `status` or `lossless`.
pub fn run_service(run_id: &str, name: &str) -> String {
    format!("swarm/{run_id}/{name}")
}

/// What is asked of `POST /v1/runs/{id}/channels`; it takes the place of what was asked before.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct AskedChannels {
    /// Frames, with the movable objects where there are some.
    #[serde(default)]
    pub frames: bool,
    /// The covered squares.
    #[serde(default)]
    pub coverage: bool,
    /// Rows of metrics, and events.
    #[serde(default)]
    pub metrics: bool,
    /// The status on a blackboard.
    #[serde(default)]
    pub status: bool,
    /// Frames of which none is lost: the run waits for its readers.
    #[serde(default)]
    pub lossless: Option<AskedLossless>,
}

/// How frames are sent of which none is lost.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct AskedLossless {
    /// A frame of each step whose number this divides (1 to 1,000,000; 1 where it is absent).
    #[serde(default)]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub every_steps: Option<u32>,
    /// Longest time that the run waits for a reader before the channel is closed, in milliseconds
    /// (1 to 60,000; 5,000 where it is absent).
    #[serde(default)]
    #[schemars(range(min = 1, max = 60_000))]
    pub timeout_ms: Option<u32>,
    /// Readers that the run waits for before the first frame (0 to 8; 0 where it is absent).
    #[serde(default)]
    #[schemars(range(max = 8))]
    pub readers: Option<u32>,
}

/// Who asked for a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AskedBy {
    /// `channels` in the spec.
    Spec,
    /// Somebody over HTTP.
    Request,
    /// The method: robots are steered from outside.
    Method,
}

/// A channel of a run, as `GET /v1/runs/{id}/channels` describes it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelDescription {
    /// What it carries: `frames`, `objects` where there are movable objects, `lossless`, `coverage`,
    /// `metrics`, `events`, `status`, or `external`, the questions to a controller.
    pub name: String,
    /// Whether it is open now.
    pub is_open: bool,
    /// Who asked for it; null where nobody did.
    pub asked_by: Option<AskedBy>,
    /// Why it is closed although somebody asked for it, where that is known.
    pub closed_because: Option<String>,
    /// Library and version that a reader must use.
    pub transport: String,
    /// Messaging pattern: `publish-subscribe`, `blackboard` or `request-response`.
    pub pattern: String,
    /// Name of the service.
    pub service: String,
    /// Event services that ring when something was sent: `asked`, `answered`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bells: Vec<String>,
    /// Folder of the transport's bookkeeping (`global.root-path`); readers must set it.
    pub root_path: String,
    /// Prefix of the transport's files (`global.prefix`); readers must set it.
    pub prefix: String,
    /// Version of the types.
    pub version: u32,
    /// Element of the slice that a sample carries, or of a blackboard the value; of `external` of a
    /// question.
    pub payload: TypeLayout,
    /// Elements of a sample: exactly, or at most where that changes.
    pub payload_elements: usize,
    /// Bytes of a sample's payload, likewise.
    pub payload_bytes: usize,
    /// User header of a sample, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub header: Option<TypeLayout>,
    /// Element of the slice that an answer carries (`external`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answer: Option<TypeLayout>,
    /// User header of an answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answer_header: Option<TypeLayout>,
    /// Most samples sent a second of wall time, where there is a limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_per_second: Option<u32>,
    /// Most readers at once; of `external` most controllers.
    pub max_subscribers: usize,
    /// Samples that a reader may lag behind: then it loses the oldest, or, of `lossless`, the run
    /// waits.
    pub subscriber_buffer: usize,
    /// Past samples that a new reader gets at once.
    pub history: usize,
    /// Names that fields of the types index, by field.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<FieldNames>,
}

/// Names that a field is an index into.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FieldNames {
    /// The field.
    pub field: String,
    /// The names, from 0.
    pub names: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn version_1_never_changes_its_layout() {
        let sizes = [
            CoverageHeader::layout(),
            SquareEntries::layout(),
            MetricsHeader::layout(),
            MetricValue::layout(),
            RunEvent::layout(),
            RunStatus::layout(),
        ]
        .map(|layout| {
            let fields: usize = layout.fields.iter().map(|field| field.size_bytes).sum();
            assert_eq!(fields, layout.size_bytes, "padding in {}", layout.type_name);
            assert!(layout.type_name.ends_with(&format!(".v{CHANNELS_VERSION}")));
            layout.size_bytes
        });
        assert_eq!(sizes, [56, 4, 24, 40, 24, 64]);
    }

    #[test]
    fn metrics_carry_their_names() {
        assert_eq!(MetricValue::new("fraction_1", 0.5).name(), "fraction_1");
        let long = "x".repeat(40);
        assert_eq!(MetricValue::new(&long, 0.0).name(), &long[..32]);
    }
}
