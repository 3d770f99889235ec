//! Why a run did what it did: it is stepped again before the eyes of a watcher that remembers where
//! robots stayed, in which states, by which actions and scores, and tells it in words.

mod kind;
mod simulate;
mod stretch;
#[cfg(test)]
mod tests;
mod watch;
mod words;

pub use kind::Kind;
pub use simulate::{ExplainError, NOT_STEPPED_AGAIN, explain};
