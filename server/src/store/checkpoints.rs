//! Checkpoints as files: what had been covered, then the snapshot, each after its digest and length.
//!
//! Written beside and renamed into place, so a crash leaves the old one or the new one.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::formats::{Blobs, Damage, findings_v0};
use super::{Findings, StoreError};
use crate::break_points::{Place, reach};

const MAGIC: [u8; 8] = *b"EVSWCP04";
/// Of programs that stored findings without envelopes, in one part before the snapshot.
const MAGIC_V3: [u8; 8] = *b"EVSWCP03";
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
    #[error("the checkpoint cannot be used for run {run}: {why}")]
    Damaged {
        /// The run.
        run: String,
        /// What is wrong with it.
        why: Damage,
    },
    /// The simulation has changed since: going on from it would mix two.
    #[error("the checkpoint is of results version {0}, this program has another")]
    OtherResults(u32),
    /// The file could not be read.
    #[error("the checkpoint cannot be read: {0}")]
    Io(#[from] std::io::Error),
}

/// The first part of a checkpoint.
#[derive(Serialize, Deserialize)]
struct HeadV4 {
    results_version: u32,
    run: String,
    has_metrics: bool,
    has_objects: bool,
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
        super::private::make_directory(dir)?;
        Ok(Self {
            dir: dir.to_owned(),
        })
    }

    /// Replaces the run's checkpoint, durably.
    ///
    /// # Errors
    /// `Io` or `Full` when it cannot be written; the old one is then still there.
    pub fn write(&self, run: &str, checkpoint: &Checkpoint) -> Result<(), StoreError> {
        let blobs = Blobs::of(&checkpoint.findings);
        self.put(run, &blobs, &checkpoint.snapshot, true)
    }

    /// Replaces the run's checkpoint; it survives a crash of the machine only where that is waited
    /// for.
    pub(super) fn put(
        &self,
        run: &str,
        blobs: &Blobs,
        snapshot: &[u8],
        is_durable: bool,
    ) -> Result<(), StoreError> {
        let path = self.path(run);
        let head = HeadV4 {
            results_version: swarm::RESULTS_VERSION,
            run: run.to_owned(),
            has_metrics: blobs.metrics.is_some(),
            has_objects: blobs.objects.is_some(),
        };
        let head = postcard::to_stdvec(&head)
            .map_err(|error| StoreError::unreadable("checkpoint", error))?;
        let write = || {
            let mut file = tempfile::NamedTempFile::new_in(&self.dir)?;
            file.write_all(&MAGIC)?;
            write_part(&mut file, &head)?;
            write_part(&mut file, &blobs.coverage)?;
            for blob in [&blobs.metrics, &blobs.objects].into_iter().flatten() {
                write_part(&mut file, blob)?;
            }
            write_part(&mut file, snapshot)?;
            if !is_durable {
                file.persist(&path)?;
                return Ok(());
            }
            file.as_file().sync_all()?;
            reach(Place::CheckpointRename);
            file.persist(&path)?;
            File::open(&self.dir)?.sync_all()
        };
        write().map_err(StoreError::io(&path))
    }

    /// The run's checkpoint, when there is one.
    ///
    /// # Errors
    /// `Damaged` when a digest does not fit, `OtherResults` when the simulation has changed since,
    /// `Io` when it cannot be read.
    pub fn read(&self, run: &str) -> Result<Option<Checkpoint>, CheckpointError> {
        let Some(mut file) = self.open_file(run)? else {
            return Ok(None);
        };
        read(run, &mut file).map(Some)
    }

    /// What the run's checkpoint had covered, without reading the snapshot.
    ///
    /// # Errors
    /// As for [`Self::read`].
    pub fn findings(&self, run: &str) -> Result<Option<Findings>, CheckpointError> {
        let Some(mut file) = self.open_file(run)? else {
            return Ok(None);
        };
        let findings = read_findings(run, &mut file)?;
        // The digest of the snapshot's part, then its length.
        let _: [u8; 32] = read_array(run, &mut file)?;
        let left = u64::from_le_bytes(read_array(run, &mut file)?);
        let end = file.stream_position()?.saturating_add(left);
        if file.metadata()?.len() != end {
            return Err(damaged(run, Damage::Digest));
        }
        Ok(Some(findings))
    }

    /// Copies the run's checkpoint, as it is, into another directory; nothing where there is none.
    ///
    /// # Errors
    /// `Io` or `Full` when it cannot be copied.
    pub fn copy(&self, run: &str, to: &Self) -> Result<(), StoreError> {
        let (from, to) = (self.path(run), to.path(run));
        let mut source = match File::open(&from) {
            Ok(source) => source,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(StoreError::io(&from)(error)),
        };
        let mut copy = super::private::open_file(&to)?;
        std::io::copy(&mut source, &mut copy)
            .and_then(|_| copy.sync_all())
            .map_err(StoreError::io(&to))
    }

    /// The runs that have checkpoints.
    ///
    /// # Errors
    /// `Io` when the directory cannot be listed.
    pub fn runs(&self) -> Result<BTreeSet<String>, StoreError> {
        let mut runs = BTreeSet::new();
        for entry in std::fs::read_dir(&self.dir).map_err(StoreError::io(&self.dir))? {
            let name = entry.map_err(StoreError::io(&self.dir))?.file_name();
            let run = name.to_str().and_then(|name| name.strip_suffix(SUFFIX));
            runs.extend(run.map(str::to_owned));
        }
        Ok(runs)
    }

    /// Bytes of the run's file, and when it was last changed.
    pub(super) fn size(&self, run: &str) -> Option<(u64, std::time::SystemTime)> {
        let meta = std::fs::metadata(self.path(run)).ok()?;
        Some((meta.len(), meta.modified().ok()?))
    }

    /// A checkpoint that was sent, as it would be read from its file.
    ///
    /// # Errors
    /// `Damaged` when it is no checkpoint of this run, `OtherResults` when it is one of another
    /// version of results.
    pub fn parse(run: &str, mut bytes: &[u8]) -> Result<Checkpoint, CheckpointError> {
        read(run, &mut bytes)
    }

    /// The run's file, when there is one.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn file(&self, run: &str) -> Result<Option<File>, CheckpointError> {
        self.open_file(run)
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

fn damaged(run: &str, why: Damage) -> CheckpointError {
    CheckpointError::Damaged {
        run: run.to_owned(),
        why,
    }
}

fn write_part(file: &mut impl Write, part: &[u8]) -> std::io::Result<()> {
    file.write_all(&Sha256::digest(part))?;
    file.write_all(&(part.len() as u64).to_le_bytes())?;
    file.write_all(part)
}

fn read(run: &str, file: &mut impl Read) -> Result<Checkpoint, CheckpointError> {
    let findings = read_findings(run, file)?;
    let snapshot = read_part(run, file)?;
    match file.read(&mut [0])? {
        0 => Ok(Checkpoint { findings, snapshot }),
        _ => Err(damaged(run, Damage::Content("bytes are left over".into()))),
    }
}

fn read_findings(run: &str, file: &mut impl Read) -> Result<Findings, CheckpointError> {
    match read_array(run, file)? {
        MAGIC => {}
        MAGIC_V3 => {
            let part = read_part(run, file)?;
            return findings_v0(&part).map_err(|why| damaged(run, why));
        }
        _ => return Err(damaged(run, Damage::Foreign)),
    }
    let head: HeadV4 = postcard::from_bytes(&read_part(run, file)?)
        .map_err(|error| damaged(run, Damage::Content(error.to_string())))?;
    if head.run != run {
        let why = Damage::Content(format!("it is of run {}", head.run));
        return Err(damaged(run, why));
    }
    if head.results_version != swarm::RESULTS_VERSION {
        return Err(CheckpointError::OtherResults(head.results_version));
    }
    let mut part = |has: bool| has.then(|| read_part(run, file)).transpose();
    let blobs = Blobs {
        coverage: part(true)?.unwrap_or_default(),
        metrics: part(head.has_metrics)?,
        objects: part(head.has_objects)?,
    };
    blobs.read().map_err(|(_, why)| damaged(run, why))
}

fn read_part(run: &str, file: &mut impl Read) -> Result<Vec<u8>, CheckpointError> {
    let digest: [u8; 32] = read_array(run, file)?;
    let length = u64::from_le_bytes(read_array(run, file)?);
    // A damaged length must not make us ask for more memory than the file could fill.
    let mut part = Vec::new();
    file.take(length).read_to_end(&mut part)?;
    if part.len() as u64 == length && Sha256::digest(&part).as_slice() == digest {
        Ok(part)
    } else {
        Err(damaged(run, Damage::Digest))
    }
}

fn read_array<const N: usize>(run: &str, file: &mut impl Read) -> Result<[u8; N], CheckpointError> {
    let mut array = [0; N];
    match file.read_exact(&mut array) {
        Ok(()) => Ok(array),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Err(damaged(run, Damage::Digest)),
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
        assert_eq!(checkpoints.runs().unwrap(), BTreeSet::from(["a".into()]));
        checkpoints.remove("a");
        assert!(checkpoints.read("a").unwrap().is_none());
    }

    #[test]
    fn any_cut_changed_or_added_byte_is_noticed() {
        let dir = tempfile::tempdir().unwrap();
        let checkpoints = Checkpoints::open(dir.path()).unwrap();
        checkpoints.write("a", &checkpoint()).unwrap();
        let path = dir.path().join("a.checkpoint");
        let whole = std::fs::read(&path).unwrap();
        let is_noticed = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            matches!(checkpoints.read("a"), Err(CheckpointError::Damaged { .. }))
        };
        for cut in 0..whole.len() {
            assert!(is_noticed(&whole[..cut]), "cut at {cut}");
            assert!(checkpoints.findings("a").is_err(), "cut at {cut}");
        }
        assert!(is_noticed(&[&whole[..], b"\0"].concat()));
        assert!(checkpoints.findings("a").is_err());
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            assert!(is_noticed(&changed), "byte {at}");
        }
        assert!(!is_noticed(&whole));
    }

    #[test]
    fn a_checkpoint_of_another_run_is_not_taken() {
        let dir = tempfile::tempdir().unwrap();
        let checkpoints = Checkpoints::open(dir.path()).unwrap();
        checkpoints.write("a", &checkpoint()).unwrap();
        let (a, b) = (checkpoints.path("a"), checkpoints.path("b"));
        std::fs::rename(a, b).unwrap();
        assert!(checkpoints.read("b").is_err());
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
