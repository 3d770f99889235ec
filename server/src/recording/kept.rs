//! Checkpoints that are kept while a run is stepped, so that a stretch of it can be recorded later
//! without stepping it from its beginning. They are few: when there are too many, every second goes.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

use swarm::run::{Progress, Run};

use super::paths::remove;
use crate::runner::{Ended, Observer, Stop};

/// Most checkpoints that are kept of a run.
const MOST: usize = 16;
const PREFIX: &str = "kept-";
const SUFFIX: &str = ".snapshot";
/// Level of their compression.
const LEVEL: i32 = 1;

/// Keeps a checkpoint every so many epochs.
pub struct Keeper {
    directory: PathBuf,
    every_steps: u64,
    writing: Option<JoinHandle<()>>,
}

impl Keeper {
    /// In the folder of a run's recordings.
    pub fn new(directory: PathBuf, every_epochs: NonZeroU32, steps_per_epoch: u32) -> Self {
        Self {
            directory,
            every_steps: u64::from(every_epochs.get()) * u64::from(steps_per_epoch),
            writing: None,
        }
    }

    fn wait(&mut self) {
        if let Some(thread) = self.writing.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread that keeps a checkpoint panicked");
        }
    }

    fn keep(&mut self, run: &Run) {
        self.wait();
        let (directory, step) = (self.directory.clone(), run.step());
        let snapshot = run.snapshot();
        let thread = std::thread::Builder::new().name("kept".to_owned());
        let spawned = thread.spawn(move || {
            if let Err(error) = write(&directory, step, &snapshot) {
                tracing::warn!(%error, "a checkpoint is not kept");
            }
            thin(&directory);
        });
        self.writing = spawned.ok();
    }
}

impl Observer for Keeper {
    fn next_step_wanted(&self, step: u64) -> Option<u64> {
        Some((step / self.every_steps + 1) * self.every_steps)
    }

    fn after_block(&mut self, run: &Run, progress: &Progress) -> Result<(), Stop> {
        let is_due = run.step().is_multiple_of(self.every_steps);
        if is_due && progress.phase != swarm::run::Phase::Done {
            self.keep(run);
        }
        Ok(())
    }

    fn end(&mut self, _: &Run, _: &Ended) {
        self.wait();
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.wait();
    }
}

fn write(directory: &Path, step: u64, snapshot: &[u8]) -> std::io::Result<()> {
    fs::create_dir_all(directory)?;
    let packed = zstd::bulk::compress(snapshot, LEVEL)?;
    let mut file = tempfile::NamedTempFile::new_in(directory)?;
    file.write_all(&packed)?;
    file.persist(directory.join(format!("{PREFIX}{step}{SUFFIX}")))?;
    Ok(())
}

/// The kept checkpoints of a run by their steps.
fn all(directory: &Path) -> BTreeMap<u64, PathBuf> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let step = |name: &str| {
        let step = name.strip_prefix(PREFIX)?.strip_suffix(SUFFIX)?;
        step.parse().ok()
    };
    entries
        .filter_map(|entry| Some((step(entry.file_name().to_str()?)?, entry.path())))
        .collect()
}

/// Removes every second where there are too many: the later one of each pair but the last.
fn thin(directory: &Path) {
    let kept = all(directory);
    if kept.len() <= MOST {
        return;
    }
    for path in kept.values().skip(1).step_by(2).take(MOST / 2) {
        remove(path);
    }
}

/// The latest kept checkpoint of a run at or before a step. One that cannot be read is left out.
pub fn nearest(directory: &Path, step: u64) -> Option<Vec<u8>> {
    let kept = all(directory);
    let mut before = kept.range(..=step).rev();
    before.find_map(|(_, path)| {
        let packed = fs::read(path).ok()?;
        zstd::stream::decode_all(&packed[..]).ok()
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn few_are_kept_and_the_nearest_is_found() {
        let home = tempfile::tempdir().unwrap();
        for step in 1..=1_000_u64 {
            write(home.path(), 10 * step, &step.to_le_bytes()).unwrap();
            thin(home.path());
            assert!(all(home.path()).len() <= MOST);
        }
        let steps: Vec<u64> = all(home.path()).into_keys().collect();
        assert!(steps.len() > MOST / 3, "{steps:?}");
        assert!(steps[0] <= 10_000 / 2, "{steps:?}");
        let found = nearest(home.path(), steps[3] + 1).unwrap();
        assert_eq!(found, (steps[3] / 10).to_le_bytes());
        assert!(nearest(home.path(), 9).is_none());
    }
}
