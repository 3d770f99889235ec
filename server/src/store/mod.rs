//! What must outlive the process: jobs, runs, results, uploaded arenas and checkpoints.
//!
//! One SQLite connection behind a mutex (every call blocks: never on an async thread), with WAL and
//! `synchronous = FULL`, so that what was acknowledged survives a crash of process or machine.

mod arenas;
mod checkpoints;
mod jobs;
mod keys;
mod lists;
mod lock;
mod results;
mod runs;
mod state;

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rusqlite::Connection;

pub use arenas::{ArenaDeletion, SaveArenaError, StoredArena};
pub use checkpoints::{Checkpoint, CheckpointError, Checkpoints};
pub use jobs::{CreateJobError, Created, JobRequest, JobView, NewJob, NewRun, RunningRun};
pub use keys::{JobKey, RunKey};
pub use lists::{JobFilter, RunFilter};
pub use results::{Findings, Finished};
pub use runs::{ClaimedRun, RunView, StoppedRun};
pub use state::{Intent, Position, RunState};

mod migrations {
    refinery::embed_migrations!("src/store/migrations");
}

/// Why the store could not be opened or did not answer.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// Another process uses the data directory.
    #[error("the data directory {} is in use by another evswarm{}", .dir.display(), .pid.map(|p| format!(" (process {p})")).unwrap_or_default())]
    InUse {
        /// The directory.
        dir: PathBuf,
        /// The other process, when it said who it is.
        pid: Option<u32>,
    },
    /// A file or directory could not be read or written.
    #[error("cannot use {}: {source}", .path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The database is of a later version or its migration failed.
    #[error("the database cannot be brought up to date: {0}")]
    Migration(#[from] refinery::Error),
    /// SQLite failed.
    #[error("the database failed: {0}")]
    Sqlite(#[from] rusqlite::Error),
    /// A worker thread could not be started.
    #[error("a worker thread cannot be started: {source}")]
    Thread {
        /// What the system said.
        source: std::io::Error,
    },
    /// A row holds what this version cannot read.
    #[error("the database holds an unreadable {what}: {detail}")]
    Unreadable {
        /// Kind of value.
        what: &'static str,
        /// Why it cannot be read.
        detail: String,
    },
}

impl StoreError {
    fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }

    fn unreadable(what: &'static str, detail: impl ToString) -> Self {
        Self::Unreadable {
            what,
            detail: detail.to_string(),
        }
    }
}

/// Most memory for pages of the database, KiB: the largest job's index of runs fits.
const CACHE_KIB: i64 = 64 << 10;

/// The open data directory; at most one process at a time holds it.
pub struct Store {
    connection: Mutex<Connection>,
    checkpoints: Checkpoints,
    _lock: std::fs::File,
}

impl Store {
    /// Opens the data directory, makes it when it is missing, and migrates its database.
    ///
    /// # Errors
    /// `InUse` when another process holds it, `Io`, `Migration` or `Sqlite` when it cannot be used.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        std::fs::create_dir_all(dir).map_err(StoreError::io(dir))?;
        let lock = lock::acquire(dir)?;
        let checkpoints = Checkpoints::open(&dir.join("checkpoints"))?;
        let mut connection = Connection::open(dir.join("evswarm.sqlite3"))?;
        connection.pragma_update(None, "journal_mode", "WAL")?;
        connection.pragma_update(None, "synchronous", "FULL")?;
        connection.pragma_update(None, "foreign_keys", "ON")?;
        connection.pragma_update(None, "cache_size", -CACHE_KIB)?;
        connection.busy_timeout(Duration::from_secs(10))?;
        connection.set_prepared_statement_cache_capacity(64);
        migrations::migrations::runner().run(&mut connection)?;
        Ok(Self {
            connection: Mutex::new(connection),
            checkpoints,
            _lock: lock,
        })
    }

    /// The checkpoints of runs that are not finished.
    pub fn checkpoints(&self) -> &Checkpoints {
        &self.checkpoints
    }

    /// Whether the database answers.
    ///
    /// # Errors
    /// When it does not.
    pub fn ping(&self) -> Result<(), StoreError> {
        Ok(self.connection().query_row("SELECT 1", [], |_| Ok(()))?)
    }

    // A panic while the mutex was held left at worst an open transaction, which its guard rolled back.
    fn connection(&self) -> MutexGuard<'_, Connection> {
        self.connection
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// SQLite integers are signed; counts here stay far below 2^63.
fn to_sql(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// The inverse of [`to_sql`].
fn from_sql(count: i64) -> u64 {
    u64::try_from(count).unwrap_or(0)
}

#[cfg(test)]
mod tests;
