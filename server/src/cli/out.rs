//! Where `evswarm run` writes, looked at before the first step: whatever would keep the result from
//! being written at the end is said at the beginning.

use std::ffi::OsString;
use std::fmt;
use std::fs;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, bail};

use crate::artifacts::{RUN_FILES, STAGED};

/// The workspace where none can be made beside the directory.
const INSIDE: &str = ".partial";

/// A directory that is to be written.
pub struct Out {
    /// As it was asked for.
    shown: PathBuf,
    /// Without symbolic links, where it exists.
    place: PathBuf,
}

impl fmt::Display for Out {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.shown.display().fmt(f)
    }
}

impl Out {
    /// The directory at a path, or one that can be made there.
    ///
    /// # Errors
    /// Something else is there, or a link to nothing.
    pub fn at(path: &Path) -> anyhow::Result<Self> {
        let place = match fs::canonicalize(path) {
            Ok(place) if place.is_dir() => place,
            Ok(_) => bail!("{} is no directory", path.display()),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                if fs::symlink_metadata(path).is_ok() {
                    bail!("{} is a symbolic link to nothing", path.display());
                }
                path.to_owned()
            }
            Err(error) => {
                return Err(error)
                    .with_context(|| format!("cannot use {} as a directory", path.display()));
            }
        };
        Ok(Self {
            shown: path.to_owned(),
            place,
        })
    }

    /// Where the files belong.
    pub fn place(&self) -> &Path {
        &self.place
    }

    /// Whether nothing of anybody else's is there: at most what an earlier process left that was
    /// killed while it put files into place.
    ///
    /// # Errors
    /// It cannot be listed.
    pub fn is_free(&self) -> anyhow::Result<bool> {
        let entries = match fs::read_dir(&self.place) {
            Ok(entries) => entries,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(true),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot list {self}"));
            }
        };
        let begun = self.begun();
        for entry in entries {
            let name = entry
                .with_context(|| format!("cannot list {self}"))?
                .file_name();
            let ours = name == INSIDE
                // The root of an ext file system has it from the beginning.
                || name == "lost+found"
                || begun && name.to_str().is_some_and(is_a_result);
            if !ours {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether a process has begun to put files here, one by one.
    fn begun(&self) -> bool {
        let workspaces = [self.beside(), Some(self.place.join(INSIDE))];
        let mut workspaces = workspaces.into_iter().flatten();
        workspaces.any(|workspace| workspace.join(STAGED).is_dir())
    }

    /// Makes the directory for what is not finished: beside the place, or in it where that cannot
    /// be.
    ///
    /// # Errors
    /// It cannot be made, or nothing can be written to the place.
    pub fn make_workspace(&self) -> anyhow::Result<PathBuf> {
        let exists = self.place.is_dir();
        if exists {
            tempfile::tempfile_in(&self.place)
                .with_context(|| format!("cannot write to {self}"))?;
        }
        let inside = self.place.join(INSIDE);
        if exists && inside.is_dir() {
            return Ok(inside);
        }
        let made = match self.beside() {
            Some(beside) => fs::create_dir_all(&beside)
                .map(|()| beside.clone())
                .with_context(|| format!("cannot make {}", beside.display())),
            None => Err(anyhow::anyhow!(
                "{self} has no name of its own to write beside"
            )),
        };
        match made {
            Err(_) if exists => fs::create_dir(&inside)
                .map(|()| inside.clone())
                .with_context(|| format!("cannot make {}", inside.display())),
            made => made,
        }
    }

    /// `DIR.partial` for `DIR`. None for a path such as `.`: whoever stands in a directory should
    /// not find it replaced by another.
    fn beside(&self) -> Option<PathBuf> {
        let named = matches!(
            self.shown.components().next_back(),
            Some(Component::Normal(_))
        );
        let mut name = OsString::from(self.place.file_name().filter(|_| named)?);
        name.push(".partial");
        Some(self.place.with_file_name(name))
    }
}

/// Whether a file of this name may be one of a finished run, whole or under way.
fn is_a_result(name: &str) -> bool {
    let name = name.strip_prefix(".partial-").unwrap_or(name);
    RUN_FILES.iter().any(|file| file.name == Some(name))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn workspace(path: &Path) -> PathBuf {
        Out::at(path).unwrap().make_workspace().unwrap()
    }

    #[test]
    fn the_workspace_is_beside_the_output() {
        let home = tempfile::tempdir().unwrap();
        let home = fs::canonicalize(home.path()).unwrap();
        let beside = home.join("a/out.partial");
        assert_eq!(workspace(&home.join("a/out/")), beside);
        fs::create_dir(home.join("a/out")).unwrap();
        assert_eq!(workspace(&home.join("a/out")), beside);
    }

    #[test]
    fn a_link_to_a_directory_stands_for_it() {
        let home = tempfile::tempdir().unwrap();
        let home = fs::canonicalize(home.path()).unwrap();
        fs::create_dir_all(home.join("there/real")).unwrap();
        std::os::unix::fs::symlink(home.join("there/real"), home.join("link")).unwrap();
        assert_eq!(
            workspace(&home.join("link")),
            home.join("there/real.partial")
        );
        std::os::unix::fs::symlink(home.join("nowhere"), home.join("broken")).unwrap();
        assert!(Out::at(&home.join("broken")).is_err());
    }

    #[test]
    fn a_directory_without_a_place_beside_it_is_its_own_workspace() {
        let home = tempfile::tempdir().unwrap();
        let out = fs::canonicalize(home.path()).unwrap();
        let mut beside = out.clone().into_os_string();
        beside.push(".partial");
        // Not even root can make a directory where a file is.
        fs::write(&beside, "").unwrap();
        let inside = workspace(&out);
        fs::remove_file(&beside).unwrap();
        assert_eq!(inside, out.join(INSIDE));
        assert_eq!(workspace(&out), inside, "and stays so");
        assert!(Out::at(&out).unwrap().is_free().unwrap());
        assert_eq!(
            workspace(&out.join("..").join(out.file_name().unwrap())),
            inside
        );
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let home = tempfile::tempdir().unwrap();
        let file = home.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(Out::at(&file).is_err());
        assert!(Out::at(&file.join("out")).is_err());
        // A file system that nobody can make a directory in.
        let out = Out::at(Path::new("/proc/evswarm/out")).unwrap();
        assert!(out.make_workspace().is_err());
        let out = Out::at(Path::new("/proc/self/task")).unwrap();
        assert!(out.make_workspace().is_err());
    }

    #[test]
    fn only_results_that_were_being_put_there_may_be_written_over() {
        let home = tempfile::tempdir().unwrap();
        let place = home.path().join("out");
        fs::create_dir(&place).unwrap();
        let out = Out::at(&place).unwrap();
        let free = || out.is_free().unwrap();
        assert!(free());
        fs::write(place.join("spec.json"), "").unwrap();
        assert!(!free());
        let workspace = out.make_workspace().unwrap();
        fs::create_dir(workspace.join(STAGED)).unwrap();
        assert!(free());
        fs::write(place.join(".partial-visits.npy"), "").unwrap();
        assert!(free());
        fs::write(place.join("notes.txt"), "").unwrap();
        assert!(!free());
    }
}
