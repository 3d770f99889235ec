//! Connections that only read: they never wait for the one that writes, since the log keeps what
//! was there before (WAL).

use std::ops::Deref;
use std::path::Path;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use rusqlite::config::DbConfig;
use rusqlite::{Connection, OpenFlags};

/// Requests that read at a time; more wait for these, each a few milliseconds.
const READERS: usize = 4;

/// Most memory for pages of each, KiB.
const CACHE_KIB: i64 = 16 << 10;

/// What every connection has.
pub(super) fn set_up(connection: &Connection, cache_kib: i64) -> rusqlite::Result<()> {
    connection.pragma_update(None, "cache_size", -cache_kib)?;
    connection.busy_timeout(Duration::from_secs(10))?;
    connection.set_prepared_statement_cache_capacity(64);
    // Otherwise statements are prepared again whenever a parameter that statistics could be asked
    // about is bound; there are no statistics.
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_ENABLE_QPSG, true)?;
    Ok(())
}

/// A few connections, lent one at a time.
pub struct Readers {
    idle: Mutex<Vec<Connection>>,
    returned: Condvar,
}

/// A connection that goes back when it is dropped.
pub struct Reader<'a> {
    readers: &'a Readers,
    /// `None` only while it is dropped.
    connection: Option<Connection>,
}

impl Readers {
    /// Of the database in this file, which is open for writing already.
    pub fn open(path: &Path) -> rusqlite::Result<Self> {
        let open = |_| {
            let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
            let connection = Connection::open_with_flags(path, flags)?;
            set_up(&connection, CACHE_KIB)?;
            Ok(connection)
        };
        Ok(Self {
            idle: Mutex::new((0..READERS).map(open).collect::<rusqlite::Result<_>>()?),
            returned: Condvar::new(),
        })
    }

    /// Waits for one that nobody uses.
    pub fn get(&self) -> Reader<'_> {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(connection) = idle.pop() {
                return Reader {
                    readers: self,
                    connection: Some(connection),
                };
            }
            idle = self
                .returned
                .wait(idle)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Deref for Reader<'_> {
    type Target = Connection;

    #[allow(clippy::expect_used, reason = "only drop takes it")]
    fn deref(&self) -> &Connection {
        self.connection.as_ref().expect("only drop takes it")
    }
}

impl Drop for Reader<'_> {
    fn drop(&mut self) {
        let mut idle = self
            .readers
            .idle
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        idle.extend(self.connection.take());
        drop(idle);
        self.readers.returned.notify_one();
    }
}
