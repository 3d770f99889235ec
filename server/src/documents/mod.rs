//! From JSON to a run: every default filled in, every wrong field found, a stable key given.
//!
//! Names, ranges and units of parameters come from the tables in `swarm`; nothing is listed twice.

mod arena;
mod channels;
mod controller;
mod design;
mod domains;
mod expand;
mod extend;
mod fields;
mod fork;
mod labels;
mod learning;
mod limits;
mod listing;
mod matrix;
mod method_parameters;
mod one_number;
mod parse;
mod parts;
mod placement;
mod record;
mod record_bytes;
mod resolve;
mod resolved;
pub mod schemas;
mod start;
mod stored;
mod template_list;
mod templates;
mod weight;

pub use arena::{ArenaSource, BuiltinArenas, arena_error, read_arena};
pub use channels::asked_channels;
pub use design::{Design, DesignAxis};
pub use expand::{ExpandedJob, MAX_RUNS, expand, run_count};
pub use extend::with_more_seeds;
pub use fields::field_error;
pub use fork::fork;
pub use limits::{MAX_EPOCHS, MAX_ROBOTS, MAX_SEED, MAX_STEPS_PER_EPOCH};
pub use listing::controllers;
pub(crate) use matrix::indices_at;
pub use one_number::one_number;
pub use parse::parse;
pub use record::{RecordRequest, RobotChoice, Stretch, asked as asked_recording, names_of};
pub use record_bytes::{MOST_RECORDING_BYTES, check_job_recordings};
pub use resolve::resolve;
pub use resolved::ResolvedRun;
pub use stored::{complete, resolve_stored};
pub use template_list::templates;
pub use templates::{
    CHAPTER_5, CHAPTER_5_METHODS, ENGINE_METHODS, SHORT_PHASE_ARENA, SHORT_PHASE_METHOD,
    SHORT_PHASES, chapter_5,
};
pub use weight::is_heavy;

#[cfg(test)]
mod expand_bounds_tests;
#[cfg(test)]
mod expand_tests;
#[cfg(test)]
mod experiments_tests;
#[cfg(test)]
mod input_tests;
#[cfg(test)]
mod resolve_tests;
#[cfg(test)]
pub(crate) mod testing;
