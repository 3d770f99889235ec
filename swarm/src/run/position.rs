//! How far a run is.

/// Where a run stands in its stages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) struct RunPosition {
    pub stage: u32,
    /// Epochs of the stage that are complete.
    pub epoch: u32,
    /// In an epoch that shows in the target arena what was evaluated in the training arena.
    pub showing: bool,
    /// Steps of the epoch that are done.
    pub step: u32,
    /// Arena steps done in all.
    pub steps: u64,
}
