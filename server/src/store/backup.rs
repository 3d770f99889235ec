//! A copy of a data directory, also while a server uses it.

use std::fs::File;
use std::path::Path;

use rusqlite::{Connection, OpenFlags};

use super::{Checkpoints, StoreError, private};

/// Copies a data directory to one that must not exist yet, whole or not at all.
///
/// Checkpoints are copied before the database: one of a run that ends in between is then a stray
/// file, and never one that a run lacks.
///
/// # Errors
/// When there is no data directory, or the copy cannot be made.
pub fn backup(dir: &Path, to: &Path) -> Result<(), StoreError> {
    let path = dir.join(super::DATABASE);
    std::fs::metadata(&path).map_err(StoreError::io(&path))?;
    let parent = match to.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    private::make_directory(parent)?;
    // A directory of this name must not be there, not even an empty one.
    let partial = tempfile::Builder::new()
        .prefix(".evswarm-backup")
        .tempdir_in(parent)
        .map_err(StoreError::io(parent))?;
    copy_checkpoints(dir, partial.path())?;
    let copy = partial.path().join(super::DATABASE);
    private::open_file(&copy)?;
    let connection = Connection::open_with_flags(&path, OpenFlags::SQLITE_OPEN_READ_ONLY)?;
    let name = copy.to_str().ok_or_else(|| {
        StoreError::unreadable("path", format!("{} is not UTF-8", copy.display()))
    })?;
    connection.execute("VACUUM INTO ?1", [name])?;
    for path in [&copy, partial.path()] {
        File::open(path)
            .and_then(|file| file.sync_all())
            .map_err(StoreError::io(path))?;
    }
    if to.exists() {
        let source = std::io::Error::from(std::io::ErrorKind::AlreadyExists);
        return Err(StoreError::io(to)(source));
    }
    std::fs::rename(partial.keep(), to).map_err(StoreError::io(to))?;
    File::open(parent)
        .and_then(|parent| parent.sync_all())
        .map_err(StoreError::io(parent))
}

fn copy_checkpoints(from: &Path, to: &Path) -> Result<(), StoreError> {
    for folder in [super::CHECKPOINTS, super::ORIGINS] {
        let checkpoints = Checkpoints::open(&from.join(folder))?;
        let copies = Checkpoints::open(&to.join(folder))?;
        for run in checkpoints.runs()? {
            checkpoints.copy(&run, &copies)?;
        }
    }
    Ok(())
}
