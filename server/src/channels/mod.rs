//! What programs on the same machine see of a run, through shared memory: frames, covered squares,
//! metrics, events and status, and the questions to programs that steer robots. A run's results never
//! depend on it, and a channel that cannot be opened is a warning.

mod cleaning;
mod describe;
mod desk;
mod extent;
mod external;
mod frame;
mod lossless;
mod observer;
mod port;
mod ports;
mod publisher;
mod reports;
mod room;
mod set;
mod slot;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use api::frames::default_root;

pub use cleaning::Cleaner;
pub use describe::describe;
pub use desk::{Desk, Desks, Fate, MAX_ASKED_RUNS, TooMany};
pub use extent::Extent;
pub use external::{AskError, External, Lookout};
pub use observer::RunChannels;
pub use port::ChannelError;
pub use set::{ChannelSet, LosslessSettings};

/// Where channels are and how often they send.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelSettings {
    /// Folder under which this user's servers and readers meet.
    pub root: PathBuf,
    /// Most frames sent a second of wall time, at least 1.
    pub max_frames_per_second: u32,
}

impl Default for ChannelSettings {
    fn default() -> Self {
        Self {
            root: default_root(),
            max_frames_per_second: 60,
        }
    }
}
