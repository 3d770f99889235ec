//! Checkpoints as files: what had been covered, then the snapshot, each after its digest and length.
//!
//! Written beside and renamed into place, so a crash leaves the old one or the new one.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::{Findings, StoreError};

const MAGIC: [u8; 8] = *b"EVSWCP03";
const SUFFIX: &str = ".checkpoint";

/// A run stopped on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// What it had covered, for whoever asks before it goes on.
    pub findings: Findings,
    /// What `swarm::run::Run::restore` takes.
    pub snapshot: Vec<u8>,
}

/// Why a checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// It was cut short, changed, or written by another version.
    #[error("the checkpoint is damaged or of another version")]
    Damaged,
    /// The file could not be read.
    #[error("the checkpoint cannot be read: {0}")]
    Io(#[from] std::io::Error),
}

/// A directory of checkpoints, one a run at most.
pub struct Checkpoints {
    dir: PathBuf,
}

impl Checkpoints {
    /// Opens the directory, makes it when it is missing.
    ///
    /// # Errors
    /// `Io` when it cannot be made.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        std::fs::create_dir_all(dir).map_err(StoreError::io(dir))?;
        Ok(Self {
            dir: dir.to_owned(),
        })
    }

    /// Replaces the run's checkpoint, durably.
    ///
    /// # Errors
    /// `Io` when it cannot be written; the old one is then still there.
    pub fn write(&self, run: &str, checkpoint: &Checkpoint) -> Result<(), StoreError> {
        let path = self.path(run);
        let findings = postcard::to_allocvec(&checkpoint.findings)
            .map_err(|error| StoreError::unreadable("findings", error))?;
        let write = || {
            let mut file = tempfile::NamedTempFile::new_in(&self.dir)?;
            file.write_all(&MAGIC)?;
            write_part(&mut file, &findings)?;
            write_part(&mut file, &checkpoint.snapshot)?;
            file.as_file().sync_all()?;
            file.persist(&path)?;
            File::open(&self.dir)?.sync_all()
        };
        write().map_err(StoreError::io(&path))
    }

    /// The run's checkpoint, when there is one.
    ///
    /// # Errors
    /// `Damaged` when a digest does not fit, `Io` when it cannot be read.
    pub fn read(&self, run: &str) -> Result<Option<Checkpoint>, CheckpointError> {
        let Some(mut file) = self.open_file(run)? else {
            return Ok(None);
        };
        let findings = read_findings(&mut file)?;
        let snapshot = read_part(&mut file)?;
        Ok(Some(Checkpoint { findings, snapshot }))
    }

    /// What the run's checkpoint had covered, without reading the snapshot.
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn findings(&self, run: &str) -> Result<Option<Findings>, CheckpointError> {
        let file = self.open_file(run)?;
        file.map(|mut file| read_findings(&mut file)).transpose()
    }

    fn open_file(&self, run: &str) -> Result<Option<File>, CheckpointError> {
        match File::open(self.path(run)) {
            Ok(file) => Ok(Some(file)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Removes the run's checkpoint. A file that cannot be removed costs space alone, so it is
    /// logged and left for the sweep at the next start.
    pub fn remove(&self, run: &str) {
        let path = self.path(run);
        if let Err(error) = std::fs::remove_file(&path)
            && error.kind() != ErrorKind::NotFound
        {
            tracing::warn!(path = %path.display(), %error, "a checkpoint cannot be removed");
        }
    }

    /// Removes every file that is not the checkpoint of one of these runs.
    ///
    /// # Errors
    /// `Io` when the directory cannot be listed.
    pub fn sweep(&self, keep: &BTreeSet<String>) -> Result<(), StoreError> {
        for entry in std::fs::read_dir(&self.dir).map_err(StoreError::io(&self.dir))? {
            let entry = entry.map_err(StoreError::io(&self.dir))?;
            let name = entry.file_name();
            let wanted = name
                .to_str()
                .and_then(|name| name.strip_suffix(SUFFIX))
                .is_some_and(|run| keep.contains(run));
            if !wanted && let Err(error) = std::fs::remove_file(entry.path()) {
                tracing::warn!(path = %entry.path().display(), %error, "a stray file cannot be removed");
            }
        }
        Ok(())
    }

    fn path(&self, run: &str) -> PathBuf {
        self.dir.join(format!("{run}{SUFFIX}"))
    }
}

fn write_part(file: &mut impl Write, part: &[u8]) -> std::io::Result<()> {
    file.write_all(&Sha256::digest(part))?;
    file.write_all(&(part.len() as u64).to_le_bytes())?;
    file.write_all(part)
}

fn read_findings(file: &mut File) -> Result<Findings, CheckpointError> {
    if read_array(file)? != MAGIC {
        return Err(CheckpointError::Damaged);
    }
    postcard::from_bytes(&read_part(file)?).map_err(|_| CheckpointError::Damaged)
}

fn read_part(file: &mut File) -> Result<Vec<u8>, CheckpointError> {
    let digest: [u8; 32] = read_array(file)?;
    let length = u64::from_le_bytes(read_array(file)?);
    // A damaged length must not make us ask for more memory than the file could fill.
    let mut part = Vec::new();
    file.take(length).read_to_end(&mut part)?;
    if part.len() as u64 == length && Sha256::digest(&part).as_slice() == digest {
        Ok(part)
    } else {
        Err(CheckpointError::Damaged)
    }
}

fn read_array<const N: usize>(file: &mut File) -> Result<[u8; N], CheckpointError> {
    let mut array = [0; N];
    match file.read_exact(&mut array) {
        Ok(()) => Ok(array),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Err(CheckpointError::Damaged),
        Err(error) => Err(error.into()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn checkpoint() -> Checkpoint {
        let findings = Findings {
            curve: Vec::new(),
            visits: vec![1, 0, 3],
            dwell: vec![2, 0, 5],
            metrics: Default::default(),
            tracks: Default::default(),
        };
        Checkpoint {
            findings,
            snapshot: vec![7; 1000],
        }
    }

    #[test]
    fn what_is_written_is_read_until_removed() {
        let dir = tempfile::tempdir().unwrap();
        let checkpoints = Checkpoints::open(dir.path()).unwrap();
        assert!(checkpoints.read("a").unwrap().is_none());
        checkpoints.write("a", &checkpoint()).unwrap();
        assert_eq!(checkpoints.read("a").unwrap(), Some(checkpoint()));
        assert_eq!(
            checkpoints.findings("a").unwrap(),
            Some(checkpoint().findings)
        );
        checkpoints.remove("a");
        assert!(checkpoints.read("a").unwrap().is_none());
    }

    #[test]
    fn any_cut_or_changed_byte_is_noticed() {
        let dir = tempfile::tempdir().unwrap();
        let checkpoints = Checkpoints::open(dir.path()).unwrap();
        checkpoints.write("a", &checkpoint()).unwrap();
        let path = dir.path().join("a.checkpoint");
        let whole = std::fs::read(&path).unwrap();
        for cut in [0, 5, 8, 20, 40, 60, whole.len() - 1] {
            std::fs::write(&path, &whole[..cut]).unwrap();
            assert!(
                matches!(checkpoints.read("a"), Err(CheckpointError::Damaged)),
                "cut at {cut}"
            );
        }
        for at in (0..whole.len()).step_by(37) {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            std::fs::write(&path, &changed).unwrap();
            assert!(
                matches!(checkpoints.read("a"), Err(CheckpointError::Damaged)),
                "byte {at}"
            );
        }
    }

    #[test]
    fn the_sweep_leaves_what_is_kept() {
        let dir = tempfile::tempdir().unwrap();
        let checkpoints = Checkpoints::open(dir.path()).unwrap();
        checkpoints.write("a", &checkpoint()).unwrap();
        checkpoints.write("b", &checkpoint()).unwrap();
        std::fs::write(dir.path().join("a.tmp"), b"half").unwrap();
        checkpoints
            .sweep(&BTreeSet::from(["a".to_owned()]))
            .unwrap();
        let left: Vec<_> = std::fs::read_dir(dir.path())
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .collect();
        assert_eq!(left, ["a.checkpoint"]);
    }
}
