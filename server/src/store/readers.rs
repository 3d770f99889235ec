//! Connections that only read: they never wait for the one that writes, since the log keeps what
//! was there before (WAL).

use std::collections::VecDeque;
use std::ops::Deref;
use std::path::Path;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rusqlite::config::DbConfig;
use rusqlite::{Connection, OpenFlags};

/// Requests that read at a time, more than tables are made; others wait for these, each a few
/// milliseconds.
const READERS: usize = 6;

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

/// A few connections, lent one at a time, in the order in which they were asked for: what reads a
/// thousand times in a row does not come before who reads once.
pub struct Readers(Mutex<Lending>);

struct Lending {
    idle: Vec<Connection>,
    waiting: VecDeque<SyncSender<Connection>>,
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
        Ok(Self(Mutex::new(Lending {
            idle: (0..READERS).map(open).collect::<rusqlite::Result<_>>()?,
            waiting: VecDeque::new(),
        })))
    }

    /// Waits for one that nobody uses.
    pub fn get(&self) -> Reader<'_> {
        let reader = |connection| Reader {
            readers: self,
            connection: Some(connection),
        };
        let mut lending = self.lending();
        // While somebody waits, none is idle.
        if let Some(connection) = lending.idle.pop() {
            return reader(connection);
        }
        let (sender, receiver) = sync_channel(1);
        lending.waiting.push_back(sender);
        drop(lending);
        #[allow(
            clippy::expect_used,
            reason = "who waits is in the list until a connection is sent"
        )]
        reader(receiver.recv().expect("a connection comes back"))
    }

    fn lending(&self) -> MutexGuard<'_, Lending> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
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
        let Some(connection) = self.connection.take() else {
            return;
        };
        let mut lending = self.readers.lending();
        match lending.waiting.pop_front() {
            #[allow(
                clippy::let_underscore_must_use,
                reason = "who waits does so until it has one, and there is room for it"
            )]
            Some(first) => {
                let _ = first.send(connection);
            }
            None => lending.idle.push(connection),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::time::Instant;

    use super::*;

    /// A thread that took a connection again as soon as it had given it back used to come before
    /// those that waited, for seconds.
    #[test]
    fn a_connection_goes_to_who_waits_not_to_who_comes_next() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("x.db");
        drop(Connection::open(&path).unwrap());
        let readers = Readers::open(&path).unwrap();
        let mut all: Vec<_> = (0..READERS).map(|_| readers.get()).collect();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| drop(readers.get()));
            let start = Instant::now();
            while readers.lending().waiting.is_empty() {
                assert!(start.elapsed() < Duration::from_secs(30));
                std::thread::yield_now();
            }
            drop(all.pop());
            // It is on its way, or was used and is back.
            let lending = readers.lending();
            assert!(lending.waiting.is_empty());
            drop(lending);
            waiting.join().unwrap();
        });
        drop(all);
        assert_eq!(readers.lending().idle.len(), READERS);
    }
}
