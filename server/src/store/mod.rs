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
mod error;
mod formats;
mod jobs;
mod keys;
mod lists;
mod lock;
mod look;
mod migrations;
mod private;
mod readers;
mod results;
mod runs;
mod state;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use readers::{Reader, Readers};
use rusqlite::Connection;

pub use arenas::{ArenaDeletion, SaveArenaError, StoredArena};
pub use backup::backup;
pub use check::{Checked, check};
pub use checkpoints::{Checkpoint, CheckpointError, Checkpoints};
pub use control::LogEntry;
pub use creation::{CreateJobError, Created, JobRequest, NewJob, NewRun};
pub use error::StoreError;
pub use jobs::{JobView, RunningRun};
pub use keys::{JobKey, RunKey};
pub use lists::{JobFilter, RunFilter};
pub use results::{Findings, Finished};
pub use runs::{ClaimedRun, RunView, StoppedRun};
pub use state::{Intent, Position, RunState};

/// The database's file in a data directory.
const DATABASE: &str = "evswarm.sqlite3";
/// The folder of checkpoints.
const CHECKPOINTS: &str = "checkpoints";

/// Room below which the store is not ready for more, bytes.
const LEAST_ROOM_BYTES: u64 = 16 << 20;

/// Most memory for pages of the database, KiB: the largest job's index of runs fits.
const CACHE_KIB: i64 = 64 << 10;

/// The open data directory; at most one process at a time holds it.
pub struct Store {
    dir: PathBuf,
    readers: Readers,
    connection: Mutex<Connection>,
    /// Threads that wait for it.
    waiting_writers: AtomicU64,
    /// Runs of jobs that are being stored which have no row yet.
    reserved_runs: AtomicU64,
    checkpoints: Checkpoints,
    _lock: std::fs::File,
}

impl Store {
    /// Opens the data directory, makes it when it is missing, and migrates its database.
    ///
    /// # Errors
    /// `InUse` when another process holds it, `Suspicious` when its database is not what was left
    /// there, `Io`, `Full`, `Migration` or `Sqlite` when it cannot be used.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        private::make_directory(dir)?;
        let lock = lock::acquire(dir)?;
        let checkpoints = Checkpoints::open(&dir.join(CHECKPOINTS))?;
        let path = dir.join(DATABASE);
        look::at_file(&path, &checkpoints)?;
        private::open_file(&path)?;
        let mut connection = Connection::open(&path)?;
        connection.pragma_update(None, "journal_mode", "WAL")?;
        connection.pragma_update(None, "synchronous", "FULL")?;
        connection.pragma_update(None, "foreign_keys", "ON")?;
        connection.pragma_update(None, "cache_size", -CACHE_KIB)?;
        connection.busy_timeout(Duration::from_secs(10))?;
        connection.set_prepared_statement_cache_capacity(64);
        look::through(&path, &connection)?;
        migrations::run(&mut connection)?;
        Ok(Self {
            dir: dir.to_owned(),
            readers: Readers::open(&path)?,
            connection: Mutex::new(connection),
            waiting_writers: AtomicU64::new(0),
            reserved_runs: AtomicU64::new(0),
            checkpoints,
            _lock: lock,
        })
    }

    /// The checkpoints of runs that are not finished.
    pub fn checkpoints(&self) -> &Checkpoints {
        &self.checkpoints
    }

    /// Whether the database answers, and there is room to store what comes.
    ///
    /// # Errors
    /// When it does not; `Full` when there is no room.
    pub fn ping(&self) -> Result<(), StoreError> {
        let stat = rustix::fs::statvfs(&self.dir)
            .map_err(|error| StoreError::io(&self.dir)(error.into()))?;
        let room_bytes = stat.f_bavail.saturating_mul(stat.f_frsize);
        if room_bytes < LEAST_ROOM_BYTES {
            let dir = self.dir.display();
            return Err(StoreError::Full(format!(
                "{room_bytes} bytes are left in {dir}"
            )));
        }
        Ok(self.reader().query_row("SELECT 1", [], |_| Ok(()))?)
    }

    /// A connection that reads, and never waits for the one that writes.
    fn reader(&self) -> Reader<'_> {
        self.readers.get()
    }

    // A panic while the mutex was held left at worst an open transaction, which its guard rolled back.
    fn connection(&self) -> MutexGuard<'_, Connection> {
        self.waiting_writers.fetch_add(1, Relaxed);
        let connection = self.connection.lock();
        self.waiting_writers.fetch_sub(1, Relaxed);
        connection.unwrap_or_else(PoisonError::into_inner)
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
