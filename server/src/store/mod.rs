//! What must outlive the process: jobs, runs, results, uploaded arenas and checkpoints.
//!
//! SQLite with WAL and `synchronous = FULL`, so that what was acknowledged survives a crash of
//! process or machine. One connection writes, behind a mutex; a few read and never wait for it. Every
//! call blocks: never on an async thread.

mod arenas;
mod backup;
mod changes;
mod check;
mod checkpoints;
mod control;
mod creation;
mod database;
mod error;
mod finals;
mod findings;
mod formats;
mod history;
mod jobs;
mod keys;
mod lists;
mod lock;
mod log;
mod look;
mod migrations;
mod names;
mod private;
mod readers;
mod recordings;
mod results;
mod retention;
mod runs;
mod sql;
mod state;

pub use arenas::{ArenaDeletion, LentArena, SaveArenaError, StoredArena};
pub use backup::backup;
pub use check::{Checked, check};
pub use checkpoints::{Checkpoint, CheckpointError, Checkpoints};
pub use control::LogEntry;
pub use creation::{CreateJobError, Created, JobRequest, NewJob, NewRun};
pub use database::Store;
pub use error::StoreError;
pub use finals::DEFAULT_BYTES as DEFAULT_FINAL_BYTES;
pub use findings::Findings;
pub use history::{Change, Changed, Changes, Subject};
pub use jobs::{JobView, RunningRun};
pub use keys::{JobKey, RunKey};
pub use lists::{JobFilter, JobMark, RunFilter};
use names::{CHECKPOINTS, DATABASE, ORIGINS};
pub use recordings::Recordings;
pub use results::{Finished, Last};
pub use retention::EndedJob;
pub use runs::{ClaimedRun, RunView, StoppedRun};
use sql::{from_sql, nearest_i32, shown_text, to_sql};
pub use state::{Intent, Position, RunState};

#[cfg(test)]
mod tests;
