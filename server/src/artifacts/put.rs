//! Putting a directory of files where it belongs: renamed as one; file by file, the result last,
//! where a directory stands that cannot be replaced, such as a mount point.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The file that says that the others are there.
const LAST: &str = "result.json";

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file or directory.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

pub(super) fn at(path: &Path) -> impl FnOnce(io::Error) -> WriteError {
    let path = path.to_owned();
    move |source| WriteError { path, source }
}

/// Puts the files of the directory `staged` at `directory`, which must not exist or be empty but for
/// `staged` itself, in whatever depth.
///
/// # Errors
/// What cannot be put into place. Before `result.json` is, the directory is not complete.
pub fn put(staged: &Path, directory: &Path) -> Result<(), WriteError> {
    if staged.starts_with(directory) {
        return file_by_file(staged, directory);
    }
    match fs::rename(staged, directory) {
        Ok(()) => match directory.parent() {
            Some(parent) if parent != Path::new("") => sync(parent).map_err(at(parent)),
            _ => sync(Path::new(".")).map_err(at(Path::new("."))),
        },
        Err(error) if directory.is_dir() && stays(&error) => file_by_file(staged, directory),
        Err(error) => Err(at(directory)(error)),
    }
}

/// Whether it is the place itself that must stay, not what it holds.
fn stays(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::ResourceBusy
            | ErrorKind::CrossesDevices
            | ErrorKind::PermissionDenied
            | ErrorKind::ReadOnlyFilesystem
    )
}

fn file_by_file(staged: &Path, directory: &Path) -> Result<(), WriteError> {
    let names = |directory: &Path| -> io::Result<Vec<OsString>> {
        fs::read_dir(directory)?
            .map(|entry| Ok(entry?.file_name()))
            .collect()
    };
    let mut names = names(staged).map_err(at(staged))?;
    names.sort_by_key(|name| (name == LAST, name.clone()));
    for name in &names {
        let (from, to) = (staged.join(name), directory.join(name));
        if name == LAST {
            sync(directory).map_err(at(directory))?;
        }
        move_file(&from, &to, directory, name).map_err(at(&to))?;
    }
    sync(directory).map_err(at(directory))
}

/// Renames a file, or copies it where it comes from another file system.
fn move_file(from: &Path, to: &Path, directory: &Path, name: &OsStr) -> io::Result<()> {
    match fs::rename(from, to) {
        Err(error) if error.kind() == ErrorKind::CrossesDevices => {
            let mut partial = OsString::from(".partial-");
            partial.push(name);
            let partial = directory.join(partial);
            write_synced(&partial, &fs::read(from)?)?;
            fs::rename(&partial, to)
        }
        renamed => renamed,
    }
}

pub(super) fn write_synced(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

pub(super) fn sync(directory: &Path) -> io::Result<()> {
    File::open(directory)?.sync_all()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn staged(home: &Path) -> PathBuf {
        let staged = home.join("staged");
        fs::create_dir_all(&staged).unwrap();
        for name in ["a.csv", LAST, "z.csv"] {
            fs::write(staged.join(name), name).unwrap();
        }
        staged
    }

    fn check(directory: &Path) {
        for name in ["a.csv", LAST, "z.csv"] {
            assert_eq!(fs::read(directory.join(name)).unwrap(), name.as_bytes());
        }
    }

    #[test]
    fn a_place_that_is_free_is_taken_as_one() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        put(&staged(home.path()), &out).unwrap();
        check(&out);
        assert!(!home.path().join("staged").exists());
    }

    #[test]
    fn a_directory_that_is_busy_gets_the_files_one_by_one() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        fs::create_dir(&out).unwrap();
        let staged = staged(home.path());
        // The system refuses to rename over `.` as it does over a mount point.
        let busy = out.join(".");
        let refused = fs::rename(&staged, &busy).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::ResourceBusy);
        put(&staged, &busy).unwrap();
        check(&out);
    }

    #[test]
    fn files_are_moved_out_of_a_directory_inside() {
        let home = tempfile::tempdir().unwrap();
        let inside = home.path().join(".partial");
        let staged = staged(&inside);
        put(&staged, home.path()).unwrap();
        check(home.path());
    }

    #[test]
    fn what_somebody_put_there_meanwhile_stays() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        fs::create_dir(&out).unwrap();
        fs::write(out.join("mine"), "mine").unwrap();
        assert!(put(&staged(home.path()), &out).is_err());
        assert_eq!(fs::read_dir(&out).unwrap().count(), 1);
    }
}
