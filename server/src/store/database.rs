//! The open data directory: its database, its checkpoints and its lock.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use parking_lot::{Mutex, MutexGuard};
use rusqlite::Connection;

use super::checkpoints::Checkpoints;
use super::error::StoreError;
use super::finals::Finals;
use super::names::{CHECKPOINTS, DATABASE, FINALS, ORIGINS, RECORDINGS};
use super::readers::{Reader, Readers, set_up};
use super::recordings::Recordings;
use super::{lock, look, migrations, private};

/// Room below which the store is not ready for more, bytes.
const LEAST_ROOM_BYTES: u64 = 16 << 20;

/// Most memory for pages of the database, KiB: the largest job's index of runs fits.
const CACHE_KIB: i64 = 64 << 10;

/// The open data directory; at most one process at a time holds it.
pub struct Store {
    pub(super) dir: PathBuf,
    pub(super) readers: Readers,
    /// Whoever has waited for long has it next.
    pub(super) connection: Mutex<Connection>,
    /// Threads that wait for it.
    pub(super) waiting_writers: AtomicU64,
    /// Runs of jobs that are being stored which have no row yet.
    pub(super) reserved_runs: AtomicU64,
    /// Uploaded arenas of jobs that are being made, each as often as it is lent.
    pub(super) lent_arenas: Mutex<BTreeMap<String, u32>>,
    pub(super) checkpoints: Checkpoints,
    pub(super) origins: Checkpoints,
    pub(super) finals: Finals,
    recordings: Recordings,
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
        let path = dir.join(DATABASE);
        look::at_file(dir)?;
        private::open_file(&path)?;
        let mut connection = Connection::open(&path)?;
        connection.pragma_update(None, "journal_mode", "WAL")?;
        connection.pragma_update(None, "synchronous", "FULL")?;
        connection.pragma_update(None, "foreign_keys", "ON")?;
        set_up(&connection, CACHE_KIB)?;
        look::through(&path, &connection)?;
        migrations::run(&mut connection)?;
        Ok(Self {
            dir: dir.to_owned(),
            readers: Readers::open(&path)?,
            connection: Mutex::new(connection),
            waiting_writers: AtomicU64::new(0),
            reserved_runs: AtomicU64::new(0),
            lent_arenas: Mutex::default(),
            checkpoints: Checkpoints::open(&dir.join(CHECKPOINTS))?,
            origins: Checkpoints::open(&dir.join(ORIGINS))?,
            finals: Finals::open(&dir.join(FINALS))?,
            recordings: Recordings::open(&dir.join(RECORDINGS))?,
            _lock: lock,
        })
    }

    /// The checkpoints of runs that are not finished.
    pub fn checkpoints(&self) -> &Checkpoints {
        &self.checkpoints
    }

    /// The states that runs go on from which do not start at their beginning.
    pub fn origins(&self) -> &Checkpoints {
        &self.origins
    }

    /// The last states of runs that are done.
    pub fn finals(&self) -> &Finals {
        &self.finals
    }

    /// The recordings of runs.
    pub fn recordings(&self) -> &Recordings {
        &self.recordings
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
    pub(super) fn reader(&self) -> Reader<'_> {
        self.readers.get()
    }

    // A panic while the mutex was held left at worst an open transaction, which its guard rolled back.
    pub(super) fn connection(&self) -> MutexGuard<'_, Connection> {
        self.waiting_writers.fetch_add(1, Relaxed);
        let connection = self.connection.lock();
        self.waiting_writers.fetch_sub(1, Relaxed);
        connection
    }

    /// The connection for changes that are not waited for on disk: a crash of the machine may undo
    /// the latest of them, one of the process does not.
    pub(super) fn unsynced_connection(&self) -> Unsynced<'_> {
        let connection = self.connection();
        set_synchronous(&connection, "NORMAL");
        Unsynced(connection)
    }
}

/// See [`Store::unsynced_connection`].
pub(super) struct Unsynced<'a>(MutexGuard<'a, Connection>);

impl Deref for Unsynced<'_> {
    type Target = Connection;

    fn deref(&self) -> &Connection {
        &self.0
    }
}

impl DerefMut for Unsynced<'_> {
    fn deref_mut(&mut self) -> &mut Connection {
        &mut self.0
    }
}

impl Drop for Unsynced<'_> {
    fn drop(&mut self) {
        set_synchronous(&self.0, "FULL");
    }
}

/// It touches no file, so it fails for lack of memory alone.
fn set_synchronous(connection: &Connection, how: &str) {
    if let Err(error) = connection.pragma_update(None, "synchronous", how) {
        tracing::error!(%error, how, "how the database waits for the disk cannot be set");
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn only_changes_that_say_so_are_not_waited_for() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path()).unwrap();
        let how = |connection: &Connection| -> i64 {
            connection
                .pragma_query_value(None, "synchronous", |row| row.get(0))
                .unwrap()
        };
        assert_eq!(how(&store.unsynced_connection()), 1);
        assert_eq!(how(&store.connection()), 2);
    }
}
