//! Why the store could not be opened or did not answer.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use rusqlite::ErrorCode;

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
    /// The file system or the quota of the data directory is full.
    #[error("there is no room left for the data directory: {0}")]
    Full(String),
    /// The database is not what this program left there.
    #[error("{} is not the database that belongs here: {why}; nothing was changed", .path.display())]
    Suspicious {
        /// Its file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// The database is of a later version or its migration failed.
    #[error("the database cannot be brought up to date: {0}")]
    Migration(rusqlite_migration::Error),
    /// SQLite failed.
    #[error("the database failed: {0}")]
    Sqlite(rusqlite::Error),
    /// A worker thread could not be started.
    #[error("a worker thread cannot be started: {source}")]
    Thread {
        /// What the system said.
        source: std::io::Error,
    },
    /// What is stored of a run was changed or cut outside of this program.
    #[error("the stored {what} of run {run} cannot be used, it is damaged: {why}")]
    Damaged {
        /// Kind of data.
        what: &'static str,
        /// The run's id or key.
        run: String,
        /// What is wrong with it.
        why: String,
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

impl From<rusqlite::Error> for StoreError {
    fn from(error: rusqlite::Error) -> Self {
        match error.sqlite_error_code() {
            Some(ErrorCode::DiskFull) => Self::Full(error.to_string()),
            _ => Self::Sqlite(error),
        }
    }
}

impl From<rusqlite_migration::Error> for StoreError {
    fn from(error: rusqlite_migration::Error) -> Self {
        match error {
            rusqlite_migration::Error::RusqliteError { err, .. }
                if err.sqlite_error_code() == Some(ErrorCode::DiskFull) =>
            {
                Self::Full(err.to_string())
            }
            error => Self::Migration(error),
        }
    }
}

impl StoreError {
    pub(super) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| match source.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
                Self::Full(format!("{}: {source}", path.display()))
            }
            _ => Self::Io { path, source },
        }
    }

    pub(super) fn unreadable(what: &'static str, detail: impl ToString) -> Self {
        Self::Unreadable {
            what,
            detail: detail.to_string(),
        }
    }

    pub(super) fn damaged(what: &'static str, run: impl ToString, why: impl ToString) -> Self {
        Self::Damaged {
            what,
            run: run.to_string(),
            why: why.to_string(),
        }
    }
}
