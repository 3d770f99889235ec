//! Where recordings are: a folder a run, which goes with the run.

use std::path::{Path, PathBuf};

use super::StoreError;
use crate::recording::Paths;

/// Name of the recording that a run's own spec asks for.
const LIVE: &str = "live";

/// The folder of recordings.
#[derive(Clone, Debug)]
pub struct Recordings {
    dir: PathBuf,
}

impl Recordings {
    /// Opens the folder, makes it when it is missing.
    ///
    /// # Errors
    /// `Io` when it cannot be made.
    pub fn open(dir: &Path) -> Result<Self, StoreError> {
        super::private::make_directory(dir)?;
        Ok(Self {
            dir: dir.to_owned(),
        })
    }

    /// The folder of a run's recordings, which may not be there.
    pub fn of(&self, run: &str) -> PathBuf {
        self.dir.join(run)
    }

    /// Makes the folder of a run.
    ///
    /// # Errors
    /// `Io` when it cannot be made.
    pub fn make(&self, run: &str) -> Result<(), StoreError> {
        super::private::make_directory(&self.of(run))
    }

    /// The recording that a run's own spec asks for.
    pub fn live(&self, run: &str) -> Paths {
        Paths::new(&self.of(run), LIVE)
    }

    /// The runs that have folders.
    pub fn runs(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.dir).into_iter().flatten().flatten();
        let mut runs: Vec<String> = entries
            .filter(|entry| entry.path().is_dir())
            .filter_map(|entry| entry.file_name().into_string().ok())
            .collect();
        runs.sort_unstable();
        runs
    }

    /// The folder of all.
    pub fn dir(&self) -> &Path {
        &self.dir
    }
}
