//! Which channels of a run are wanted.

use api::channels::{AskedChannels, AskedLossless};

/// Channels of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChannelSet {
    /// Frames, with movable objects.
    pub frames: bool,
    /// Covered squares.
    pub coverage: bool,
    /// Rows of metrics, and events.
    pub metrics: bool,
    /// The status on a blackboard.
    pub status: bool,
    /// Frames of which none is lost.
    pub lossless: Option<LosslessSettings>,
}

/// How frames are sent of which none is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LosslessSettings {
    /// A frame of each step whose number this divides.
    pub every_steps: u32,
    /// Longest time that the run waits for a reader.
    pub timeout_ms: u32,
    /// Readers that it waits for before the first frame.
    pub readers: u32,
}

impl ChannelSet {
    /// What `channels` in a spec opens: all that slow no run down.
    pub fn of_spec(channels: bool) -> Self {
        Self {
            frames: channels,
            coverage: channels,
            metrics: channels,
            status: channels,
            lossless: None,
        }
    }

    /// What either wants.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            frames: self.frames || other.frames,
            coverage: self.coverage || other.coverage,
            metrics: self.metrics || other.metrics,
            status: self.status || other.status,
            lossless: self.lossless.or(other.lossless),
        }
    }

    /// Whether nothing is wanted.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// As HTTP shows it.
    pub fn shown(&self) -> AskedChannels {
        AskedChannels {
            frames: self.frames,
            coverage: self.coverage,
            metrics: self.metrics,
            status: self.status,
            lossless: self.lossless.map(|lossless| AskedLossless {
                every_steps: Some(lossless.every_steps),
                timeout_ms: Some(lossless.timeout_ms),
                readers: Some(lossless.readers),
            }),
        }
    }
}
