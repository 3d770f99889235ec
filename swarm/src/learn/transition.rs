//! What followed an action in a state, as tables record it and robots tell it.

use serde::{Deserialize, Serialize};

/// What followed an action in a state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Transition {
    /// State i.
    pub state: u32,
    /// Action j.
    pub action: u32,
    /// State k that followed.
    pub next: u32,
}
