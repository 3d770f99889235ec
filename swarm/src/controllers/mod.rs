//! What a robot can be doing, one file each, in the order of Ev-ITER's phases.

mod babbler;
mod brownian;
mod codebook;
mod command_levels;
mod controller;
mod crawler;
mod decider;
mod explorer;
mod reference;
mod replayer;
mod scaling;
mod shared_table;
mod watch;

pub use babbler::Babbler;
pub use brownian::Brownian;
pub use codebook::Codebook;
pub use controller::{Controller, Controllers};
pub use crawler::Crawler;
pub use decider::Decider;
pub use explorer::Explorer;
pub use reference::Reference;
pub use replayer::Replayer;
pub use scaling::{Scaling, sensori_motor};
pub use shared_table::SharedTableExplorers;
pub use watch::Watch;
