//! A quick look at the database's file before anything is changed: what was cut short, emptied or
//! is another file is refused, so that it is never taken for a new one.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use rusqlite::Connection;

use super::names::{CHECKPOINTS, DATABASE, FINALS, ORIGINS, RECORDINGS};
use super::{Checkpoints, Recordings, StoreError};

/// Largest database that is looked through from beginning to end, bytes.
const MOST_READ_BYTES: u64 = 64 << 20;

/// Looks at the database's file in a data directory; it may be missing where nothing else of a
/// store is there.
///
/// # Errors
/// `Suspicious` when it is not what this program left.
pub fn at_file(dir: &Path) -> Result<(), StoreError> {
    let path = &dir.join(DATABASE);
    let suspicious = |why: String| StoreError::Suspicious {
        path: path.to_owned(),
        why,
    };
    let log = path.with_extension("sqlite3-wal");
    let has_log = std::fs::metadata(log).is_ok_and(|log| log.len() > 0);
    let mut head = Vec::new();
    let length = match File::open(path) {
        Ok(file) => {
            let length = file.metadata().map_err(StoreError::io(path))?.len();
            file.take(100)
                .read_to_end(&mut head)
                .map_err(StoreError::io(path))?;
            length
        }
        Err(error) if error.kind() == ErrorKind::NotFound => 0,
        Err(error) => return Err(StoreError::io(path)(error)),
    };
    if length == 0 {
        return match left_beside(dir)? {
            Some(left) if !has_log => Err(suspicious(format!(
                "it is empty or missing, while {left} beside it"
            ))),
            _ => Ok(()),
        };
    }
    if !head.starts_with(b"SQLite format 3\0") || head.len() < 100 {
        return Err(suspicious("it is no SQLite database".to_owned()));
    }
    // Pages that are not in the file may stand in the log.
    let page_bytes = match u16::from_be_bytes([head[16], head[17]]) {
        1 => 65_536,
        bytes => u64::from(bytes),
    };
    let pages = u64::from(u32::from_be_bytes([head[28], head[29], head[30], head[31]]));
    if !has_log && length < pages * page_bytes {
        let (whole, cut) = (pages * page_bytes, length);
        return Err(suspicious(format!("it has {cut} of its {whole} bytes")));
    }
    Ok(())
}

/// What else of a store there is, in words; `None` where there is nothing.
fn left_beside(dir: &Path) -> Result<Option<String>, StoreError> {
    for (folder, what) in [
        (CHECKPOINTS, "checkpoints"),
        (ORIGINS, "states to begin with"),
        (FINALS, "last states"),
    ] {
        let folder = dir.join(folder);
        let runs = match folder.is_dir() {
            true => Checkpoints::open(&folder)?.runs()?.len(),
            false => 0,
        };
        if runs > 0 {
            return Ok(Some(format!("{runs} runs have {what}")));
        }
    }
    let recordings = dir.join(RECORDINGS);
    let runs = match recordings.is_dir() {
        true => Recordings::open(&recordings)?.runs().len(),
        false => 0,
    };
    Ok((runs > 0).then(|| format!("{runs} runs have recordings")))
}

/// Looks through an open database, unless it is large.
///
/// # Errors
/// `Suspicious` when it is damaged.
pub fn through(path: &Path, connection: &Connection) -> Result<(), StoreError> {
    let length = std::fs::metadata(path).map_err(StoreError::io(path))?.len();
    if length > MOST_READ_BYTES {
        return Ok(());
    }
    let found: rusqlite::Result<String> =
        connection.query_row("PRAGMA quick_check(1)", [], |row| row.get(0));
    match found {
        Ok(found) if found == "ok" => Ok(()),
        Ok(why) => Err(StoreError::Suspicious {
            path: path.to_owned(),
            why,
        }),
        Err(error) => Err(StoreError::Suspicious {
            path: path.to_owned(),
            why: error.to_string(),
        }),
    }
}
