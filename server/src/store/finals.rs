//! The last states of runs that are done, so that a longer run can go on from there: as many as fit
//! into a number of bytes, the oldest go. Losing one costs time alone, so none is waited for on disk.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::StoreError;
use super::checkpoints::{Checkpoint, CheckpointError, Checkpoints};
use super::formats::Blobs;

/// Most bytes unless told otherwise.
pub const DEFAULT_BYTES: u64 = 256 << 20;

/// States by run.
pub struct Finals {
    files: Checkpoints,
    kept: Mutex<Kept>,
}

struct Kept {
    most_bytes: u64,
    bytes: u64,
    /// Runs with the bytes of their files, the oldest first.
    runs: VecDeque<(String, u64)>,
}

impl Finals {
    /// Those in a directory, which is made when it is missing.
    ///
    /// # Errors
    /// `Io` when it cannot be used.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        let files = Checkpoints::open(dir)?;
        files.sweep(&files.runs()?)?;
        let mut found = Vec::new();
        for run in files.runs()? {
            if let Some((bytes, changed)) = files.size(&run) {
                found.push((changed, run, bytes));
            }
        }
        found.sort();
        let kept = Kept {
            most_bytes: DEFAULT_BYTES,
            bytes: found.iter().map(|(_, _, bytes)| bytes).sum(),
            runs: found
                .into_iter()
                .map(|(_, run, bytes)| (run, bytes))
                .collect(),
        };
        Ok(Self {
            files,
            kept: Mutex::new(kept),
        })
    }

    /// Keeps so many bytes from now on.
    pub fn set_most_bytes(&self, most_bytes: u64) {
        let mut kept = self.kept();
        kept.most_bytes = most_bytes;
        self.make_room(&mut kept);
    }

    /// Most bytes that are kept.
    pub fn most_bytes(&self) -> u64 {
        self.kept().most_bytes
    }

    /// Bytes that are kept.
    pub fn bytes(&self) -> u64 {
        self.kept().bytes
    }

    /// Keeps the last state of a run, if it fits.
    pub(super) fn keep(&self, run: &str, findings: &Blobs, snapshot: &[u8]) {
        if snapshot.len() as u64 > self.most_bytes() {
            return;
        }
        if let Err(error) = self.files.put(run, findings, snapshot, false) {
            tracing::debug!(run, %error, "the last state of a run is not kept");
            return;
        }
        let Some((bytes, _)) = self.files.size(run) else {
            return;
        };
        let mut kept = self.kept();
        kept.forget(run);
        kept.bytes += bytes;
        kept.runs.push_back((run.to_owned(), bytes));
        self.make_room(&mut kept);
    }

    /// The last state of a run, if it is kept.
    ///
    /// # Errors
    /// As for [`Checkpoints::read`].
    pub fn read(&self, run: &str) -> Result<Option<Checkpoint>, CheckpointError> {
        self.files.read(run)
    }

    /// The file of it.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn file(&self, run: &str) -> Result<Option<std::fs::File>, CheckpointError> {
        self.files.file(run)
    }

    /// Forgets the last state of a run.
    pub fn remove(&self, run: &str) {
        self.kept().forget(run);
        self.files.remove(run);
    }

    fn make_room(&self, kept: &mut Kept) {
        while kept.bytes > kept.most_bytes {
            let Some((run, bytes)) = kept.runs.pop_front() else {
                return;
            };
            kept.bytes -= bytes;
            self.files.remove(&run);
        }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Kept {
    fn forget(&mut self, run: &str) {
        if let Some(place) = self.runs.iter().position(|(known, _)| known == run)
            && let Some((_, bytes)) = self.runs.remove(place)
        {
            self.bytes -= bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn the_oldest_go_when_there_is_no_room() {
        let dir = tempfile::tempdir().unwrap();
        let finals = Finals::open(dir.path()).unwrap();
        let findings = Blobs::of(&crate::store::Findings::default());
        for run in ["a", "b", "c"] {
            finals.keep(run, &findings, &[7; 1_000]);
        }
        let each = finals.bytes() / 3;
        assert!(each > 1_000 && finals.read("a").unwrap().is_some());
        finals.set_most_bytes(2 * each);
        assert!(finals.read("a").unwrap().is_none());
        finals.keep("b", &findings, &[8; 1_000]);
        finals.keep("d", &findings, &[9; 1_000]);
        let is_kept =
            |finals: &Finals| ["a", "b", "c", "d"].map(|run| finals.read(run).unwrap().is_some());
        assert_eq!(is_kept(&finals), [false, true, false, true]);
        assert_eq!(finals.bytes(), 2 * each);
        drop(finals);
        let finals = Finals::open(dir.path()).unwrap();
        assert_eq!(
            (finals.bytes(), is_kept(&finals)),
            (2 * each, [false, true, false, true])
        );
        finals.remove("b");
        finals.set_most_bytes(0);
        finals.keep("e", &findings, &[1; 10]);
        assert_eq!((finals.bytes(), is_kept(&finals)), (0, [false; 4]));
    }
}
