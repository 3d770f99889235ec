//! What listeners to all jobs, a job or a run hear. Nothing is queued for them: each keeps the number of the
//! last change of state that it heard, and is told what is new when it is ready for more. So a slow
//! listener costs nothing, misses steps of progress, and never a change of state.

mod board;
mod feed;
mod hub;

pub use feed::{Feed, Told};
pub use hub::Hub;
#[cfg(test)]
pub use hub::MAX_LISTENERS;
