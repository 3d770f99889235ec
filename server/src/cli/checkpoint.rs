//! What `evswarm run` keeps while it runs, beside its output directory or in it: a snapshot to go on
//! from.

use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use serde::{Deserialize, Serialize};

use super::out::Out;
use crate::recording::Paths;

/// `DIR.partial`, held by one process at a time.
pub struct Checkpoint {
    directory: PathBuf,
    key: String,
    /// Locked for as long as it is open.
    _lock: File,
}

/// A run stopped in the middle.
pub struct Saved {
    /// The run's snapshot.
    pub snapshot: Vec<u8>,
    /// What it has cost so far.
    pub spent: Spent,
}

/// Time spent on a run before now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spent {
    /// Seconds by the clock on the wall.
    pub wall_s: f64,
    /// Seconds of processor time.
    pub cpu_s: f64,
}

#[derive(Serialize, Deserialize)]
struct Note {
    key: String,
    spent: Spent,
}

impl Checkpoint {
    /// Opens or makes the directory for the run of this key.
    ///
    /// # Errors
    /// It cannot be made, or another process holds it.
    pub fn open(out: &Out, key: String) -> anyhow::Result<Self> {
        let directory = out.make_workspace()?;
        let shown = directory.display();
        let path = directory.join("lock");
        let lock =
            File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
        match lock.try_lock() {
            Ok(()) => Ok(Self {
                directory,
                key,
                _lock: lock,
            }),
            Err(TryLockError::WouldBlock) => {
                bail!("another process is at work on {out} (it holds {shown})")
            }
            Err(TryLockError::Error(error)) => {
                Err(error).with_context(|| format!("cannot lock {}", path.display()))
            }
        }
    }

    /// What was saved for this very run; what was saved for another is left to be overwritten.
    pub fn load(&self) -> Option<Saved> {
        let note = fs::read(self.directory.join("note.json")).ok()?;
        let note: Note = serde_json::from_slice(&note).ok()?;
        if note.key != self.key {
            tracing::warn!(
                "{} belongs to another spec or version: starting anew",
                self.directory.display()
            );
            return None;
        }
        let snapshot = fs::read(self.directory.join("snapshot.bin")).ok()?;
        Some(Saved {
            snapshot,
            spent: note.spent,
        })
    }

    /// Saves, each file as a whole or not at all.
    ///
    /// # Errors
    /// A file cannot be written; the one before stays.
    pub fn save(&self, snapshot: &[u8], spent: Spent) -> anyhow::Result<()> {
        // A snapshot knows its own spec, so that a note of another run's beside it does no harm.
        self.replace("snapshot.bin", snapshot)?;
        let note = Note {
            key: self.key.clone(),
            spent,
        };
        self.replace("note.json", &serde_json::to_vec(&note)?)
    }

    /// The directory.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Where the run's recording is made.
    pub fn recording(&self) -> Paths {
        Paths::new(&self.directory, "recording")
    }

    /// Removes the directory: the run is done.
    pub fn remove(self: Arc<Self>) {
        if let Err(error) = fs::remove_dir_all(&self.directory) {
            tracing::warn!("cannot remove {}: {error}", self.directory.display());
        }
    }

    fn replace(&self, name: &str, bytes: &[u8]) -> anyhow::Result<()> {
        let path = self.directory.join(name);
        let write = || -> std::io::Result<()> {
            let mut file = tempfile::NamedTempFile::new_in(&self.directory)?;
            file.write_all(bytes)?;
            file.as_file().sync_all()?;
            file.persist(&path)?;
            Ok(())
        };
        write().with_context(|| format!("cannot write {}", path.display()))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn what_was_saved_comes_back_for_the_same_run_alone() {
        let home = tempfile::tempdir().unwrap();
        let out = Out::at(&home.path().join("out")).unwrap();
        let spent = Spent {
            wall_s: 1.5,
            cpu_s: 2.5,
        };
        let checkpoint = Checkpoint::open(&out, "a".to_owned()).unwrap();
        assert!(checkpoint.load().is_none());
        checkpoint.save(b"old", Spent::default()).unwrap();
        checkpoint.save(b"snapshot", spent).unwrap();
        assert!(
            Checkpoint::open(&out, "a".to_owned()).is_err(),
            "it is locked"
        );
        drop(checkpoint);

        let again = Checkpoint::open(&out, "a".to_owned()).unwrap();
        let saved = again.load().unwrap();
        assert_eq!(
            (saved.snapshot.as_slice(), saved.spent),
            (b"snapshot".as_slice(), spent)
        );
        drop(again);
        let other = Checkpoint::open(&out, "b".to_owned()).unwrap();
        assert!(other.load().is_none());
        Arc::new(other).remove();
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 0);
    }
}
