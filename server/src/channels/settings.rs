//! Where channels are.

use std::path::PathBuf;

use api::frames::default_root;

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
