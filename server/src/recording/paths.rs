//! Where a recording is, and what stands beside it while it is made.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The files of one recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Paths {
    /// The whole recording.
    pub whole: PathBuf,
    /// What there is of it so far.
    pub part: PathBuf,
    /// The block that was begun when the run's last checkpoint was taken.
    pub tail: PathBuf,
    /// What there is of one that was given up.
    pub cut: PathBuf,
    /// There where it was given up, also when what there was of it has made room.
    pub given_up: PathBuf,
}

/// How far a recording has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// All of it is there.
    Whole,
    /// More is to come, or would have.
    Part,
    /// No more will come.
    Cut,
}

impl Paths {
    /// Of a recording of this name in a directory.
    pub fn new(directory: &Path, name: &str) -> Self {
        let path = |suffix| directory.join(format!("{name}.evrec{suffix}"));
        Self {
            whole: path(""),
            part: path(".part"),
            tail: path(".tail"),
            cut: path(".cut"),
            given_up: path(".given-up"),
        }
    }

    /// Removes what there is.
    pub fn remove(&self) {
        self.remove_bytes();
        remove(&self.given_up);
    }

    /// Removes what can be read, and what would be gone on with. One that was given up stays so: a
    /// run that is under way does not begin again for it.
    pub fn remove_bytes(&self) {
        for path in [&self.whole, &self.part, &self.tail, &self.cut] {
            remove(path);
        }
    }

    /// The file that can be read now, and what it is; `None` where there is none.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn open(&self) -> io::Result<Option<(File, Stage)>> {
        let all = [
            (&self.whole, Stage::Whole),
            (&self.part, Stage::Part),
            // Renamed meanwhile.
            (&self.whole, Stage::Whole),
            (&self.cut, Stage::Cut),
        ];
        for (path, stage) in all {
            match File::open(path) {
                Ok(file) => return Ok(Some((file, stage))),
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Ok(None)
    }

    /// Bytes of what can be read now.
    pub fn bytes(&self) -> u64 {
        let all = [&self.whole, &self.part, &self.cut];
        let sizes = all.into_iter().filter_map(|path| fs::metadata(path).ok());
        sizes.map(|of| of.len()).next().unwrap_or(0)
    }
}

/// Removes a file that may not be there; one that cannot be removed costs space alone.
pub fn remove(path: &Path) {
    if let Err(error) = fs::remove_file(path)
        && error.kind() != ErrorKind::NotFound
    {
        tracing::warn!(path = %path.display(), %error, "a file cannot be removed");
    }
}
