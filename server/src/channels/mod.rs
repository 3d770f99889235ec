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
mod patience;
mod port;
mod ports;
mod publisher;
mod reports;
mod room;
mod set;
mod settings;
mod slot;
#[cfg(test)]
mod tests;

pub use cleaning::Cleaner;
pub use describe::describe;
pub use desk::{Desk, Desks, Fate, MAX_ASKED_RUNS, TooMany};
pub use extent::Extent;
pub use external::{AskError, External, Lookout};
pub use observer::RunChannels;
pub use port::ChannelError;
pub use set::{ChannelSet, LosslessSettings};
pub use settings::ChannelSettings;
