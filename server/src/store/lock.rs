//! One process a data directory: an advisory lock that the system drops with the process.

use std::fs::{File, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;

use super::StoreError;

/// Takes the lock and writes this process's id into it, for the message that the next one shows.
///
/// # Errors
/// `InUse` when another process holds it, `Io` when the file cannot be opened.
pub fn acquire(dir: &Path) -> Result<File, StoreError> {
    let path = dir.join("lock");
    let mut file = super::private::open_file(&path)?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            let mut holder = String::new();
            #[allow(
                clippy::let_underscore_must_use,
                reason = "the id is a help only: a lock file without one still means that the directory is held"
            )]
            let _ = file.read_to_string(&mut holder);
            return Err(StoreError::InUse {
                dir: dir.to_owned(),
                pid: holder.trim().parse().ok(),
            });
        }
        Err(TryLockError::Error(source)) => return Err(StoreError::io(&path)(source)),
    }
    file.set_len(0)
        .and_then(|()| file.rewind())
        .and_then(|()| writeln!(file, "{}", std::process::id()))
        .map_err(StoreError::io(&path))?;
    Ok(file)
}
