//! A copy of a data directory, also while a server uses it.

use std::fs::{self, File, Permissions};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use rusqlite::{Connection, OpenFlags};

use super::names::{CHECKPOINTS, FINALS, ORIGINS, RECORDINGS};
use super::{Checkpoints, Recordings, StoreError, private};

/// Looks at the files of a run's recordings: one that is renamed during the first is found by the
/// next.
const LOOKS: u32 = 2;

/// Copies a data directory to one that must not exist yet, whole or not at all.
///
/// Checkpoints are copied before the database: one of a run that ends in between is then a stray
/// file, and never one that a run lacks. Recordings are copied after it, so that a run which it says
/// is done has all of its recording.
///
/// # Errors
/// When there is no data directory, the copy would be inside it, or it cannot be made.
pub fn backup(dir: &Path, to: &Path) -> Result<(), StoreError> {
    let path = dir.join(super::DATABASE);
    std::fs::metadata(&path).map_err(StoreError::io(&path))?;
    let parent = match to.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    refuse_inside(dir, to)?;
    private::make_directory(parent)?;
    // Now that the parts of the path are there that were not.
    refuse_inside(dir, parent)?;
    // A directory of this name must not be there, not even an empty one.
    let partial = tempfile::Builder::new()
        .prefix(".evswarm-backup")
        .permissions(Permissions::from_mode(0o700))
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
    copy_recordings(dir, partial.path())?;
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
    for folder in [CHECKPOINTS, ORIGINS, FINALS] {
        if !from.join(folder).is_dir() {
            continue;
        }
        let checkpoints = Checkpoints::open(&from.join(folder))?;
        let copies = Checkpoints::open(&to.join(folder))?;
        for run in checkpoints.runs()? {
            checkpoints.copy(&run, &copies)?;
        }
    }
    Ok(())
}

/// What a recording needs that is there or being made; what goes meanwhile is left out.
fn copy_recordings(from: &Path, to: &Path) -> Result<(), StoreError> {
    let from = from.join(RECORDINGS);
    if !from.is_dir() {
        return Ok(());
    }
    let recordings = Recordings::open(&from)?;
    let copies = Recordings::open(&to.join(RECORDINGS))?;
    for run in recordings.runs() {
        copies.make(&run)?;
        for _ in 0..LOOKS {
            copy_new_files(&recordings.of(&run), &copies.of(&run))?;
        }
    }
    Ok(())
}

/// Copies the files of a folder that the other one lacks, but for those that are being written.
fn copy_new_files(from: &Path, to: &Path) -> Result<(), StoreError> {
    let entries = match fs::read_dir(from) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(StoreError::io(from)(error)),
    };
    for entry in entries {
        let entry = entry.map_err(StoreError::io(from))?;
        let name = entry.file_name();
        let (source, copy) = (entry.path(), to.join(&name));
        let is_temporary = name.as_encoded_bytes().starts_with(b".");
        if is_temporary || copy.exists() || !source.is_file() {
            continue;
        }
        let file = match File::open(&source) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            Err(error) => return Err(StoreError::io(&source)(error)),
        };
        // One that grows is copied as far as it was.
        let bytes = file.metadata().map_err(StoreError::io(&source))?.len();
        let mut made = private::open_file(&copy)?;
        io::copy(&mut file.take(bytes), &mut made)
            .and_then(|_| made.sync_all())
            .map_err(StoreError::io(&copy))?;
    }
    Ok(())
}

/// A copy inside the directory would be taken for a part of it.
fn refuse_inside(dir: &Path, to: &Path) -> Result<(), StoreError> {
    let dir = dir.canonicalize().map_err(StoreError::io(dir))?;
    let absolute = std::path::absolute(to).map_err(StoreError::io(to))?;
    let nearest = absolute
        .ancestors()
        .find_map(|path| path.canonicalize().ok());
    if nearest.is_some_and(|nearest| nearest.starts_with(&dir)) {
        let why = "it lies inside the data directory that is to be copied";
        return Err(StoreError::io(to)(io::Error::new(
            ErrorKind::InvalidInput,
            why,
        )));
    }
    Ok(())
}
