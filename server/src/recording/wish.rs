//! What was asked to be recorded afterwards, as it is kept beside the recording: whoever starts
//! after a crash finds what is still to be made.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::paths::Paths;
use crate::documents::{RecordRequest, Stretch};

/// A recording that was asked for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wish {
    /// Its number among those of its run.
    pub number: u64,
    /// When it was asked for, milliseconds since 1970.
    pub asked_ms: u64,
    /// First epoch, counted from 0 over all phases.
    pub from_epoch: u64,
    /// Epochs.
    pub epochs: u64,
    /// Every so many steps.
    pub every_steps: u32,
    /// As in a spec.
    pub robots: Value,
    /// As in a spec.
    pub fields: Vec<String>,
    /// About how many bytes it takes.
    #[serde(default)]
    pub about_bytes: u64,
    /// Why it was given up.
    pub reason: Option<String>,
}

impl Wish {
    /// Of what is asked for of a run.
    pub fn new(number: u64, request: &RecordRequest, stretch: Stretch, about_bytes: u64) -> Self {
        let shown = RecordRequest::shown(Some(request));
        let since = std::time::UNIX_EPOCH.elapsed();
        Self {
            number,
            asked_ms: since.map_or(0, |time| time.as_millis() as u64),
            from_epoch: stretch.from_epoch,
            epochs: stretch.epochs,
            every_steps: request.every_steps,
            robots: shown.robots.unwrap_or_default(),
            fields: shown.fields.unwrap_or_default(),
            about_bytes,
            reason: None,
        }
    }

    /// Whether it asks for the same.
    pub fn is_like(&self, other: &Self) -> bool {
        let asked = |wish: &Self| {
            let Self {
                from_epoch,
                epochs,
                every_steps,
                ..
            } = *wish;
            (from_epoch, epochs, every_steps)
        };
        asked(self) == asked(other) && self.robots == other.robots && self.fields == other.fields
    }

    /// Whether nothing more is to be made of it.
    pub fn has_ended(&self, directory: &Path) -> bool {
        let paths = self.paths(directory);
        self.reason.is_some() || paths.whole.exists() || paths.cut.exists()
    }

    /// As it was posted.
    pub fn document(&self) -> Value {
        json!({
            "from_epoch": self.from_epoch,
            "epochs": self.epochs,
            "every_steps": self.every_steps,
            "robots": self.robots,
            "fields": self.fields,
        })
    }

    /// Keeps it in the folder of its run, durably.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, directory: &Path) -> io::Result<()> {
        let mut file = tempfile::NamedTempFile::new_in(directory)?;
        file.write_all(&serde_json::to_vec(self)?)?;
        file.as_file().sync_all()?;
        file.persist(path(directory, self.number))?;
        fs::File::open(directory)?.sync_all()
    }

    /// The files of the recording.
    pub fn paths(&self, directory: &Path) -> Paths {
        Paths::new(directory, &self.number.to_string())
    }

    /// Removes it and its recording.
    pub fn remove(&self, directory: &Path) {
        super::paths::remove(&path(directory, self.number));
        self.paths(directory).remove();
    }
}

fn path(directory: &Path, number: u64) -> PathBuf {
    directory.join(format!("{number}.json"))
}

/// What was asked for of a run, in order; what cannot be read is left out.
pub fn all(directory: &Path) -> Vec<Wish> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let read = |entry: fs::DirEntry| {
        let name = entry.file_name();
        name.to_str()?.strip_suffix(".json")?;
        serde_json::from_slice(&fs::read(entry.path()).ok()?).ok()
    };
    let mut all: Vec<Wish> = entries.filter_map(read).collect();
    all.sort_by_key(|wish| wish.number);
    all
}
