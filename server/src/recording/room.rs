//! Room for recordings: the oldest go when they take too much together, and all go with their run.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::paths::remove;
use super::wish::all;
use crate::store::Recordings;

/// Removes the folders of runs that are gone.
pub fn sweep(recordings: &Recordings, is_there: impl Fn(&str) -> bool) {
    for run in recordings.runs() {
        if !is_there(&run)
            && let Err(error) = fs::remove_dir_all(recordings.of(&run))
        {
            tracing::warn!(run, %error, "recordings of a run that is gone cannot be removed");
        }
    }
}

/// Bytes of what there is in the folder of a run, and about of what was asked for and is still to be
/// made.
pub fn bytes_of(directory: &Path) -> u64 {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let sizes = entries.filter_map(|entry| entry.metadata().ok());
    let there: u64 = sizes.map(|of| of.len()).sum();
    let wishes = all(directory).into_iter();
    let to_come = wishes
        .filter(|wish| !wish.has_ended(directory))
        .map(|wish| {
            let bytes = wish.paths(directory).bytes();
            wish.about_bytes.saturating_sub(bytes)
        });
    there + to_come.sum::<u64>()
}

/// Removes whole recordings, those that are given up and kept checkpoints, oldest first, until those
/// of some runs take no more than so many bytes together. What is being made stays.
pub fn keep_within(recordings: &Recordings, runs: &[String], most_bytes: u64) {
    let mut files: Vec<(SystemTime, PathBuf, u64)> = Vec::new();
    let mut bytes: u64 = 0;
    for run in runs {
        let entries = fs::read_dir(recordings.of(run));
        for entry in entries.into_iter().flatten().flatten() {
            let Ok(of) = entry.metadata() else { continue };
            bytes += of.len();
            let path = entry.path();
            let may_go = path.extension().is_some_and(|end| {
                ["evrec", "cut", "snapshot"]
                    .iter()
                    .any(|known| end == *known)
            });
            if may_go {
                files.push((of.modified().unwrap_or(SystemTime::now()), path, of.len()));
            }
        }
    }
    files.sort();
    for (_, path, length) in files {
        if bytes <= most_bytes {
            return;
        }
        tracing::info!(path = %path.display(), "an old recording makes room");
        // What was asked for goes first, or it would be made again.
        remove(&path.with_extension("json"));
        remove(&path);
        bytes = bytes.saturating_sub(length);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_oldest_make_room_and_what_is_being_made_stays() {
        let home = tempfile::tempdir().unwrap();
        let recordings = Recordings::open(&home.path().join("recordings")).unwrap();
        let now = SystemTime::now();
        for (run, name, age_s) in [
            ("a", "live.evrec", 30),
            ("a", "1.evrec", 20),
            ("a", "1.json", 20),
            ("b", "2.evrec.part", 40),
            ("b", "3.evrec", 10),
        ] {
            recordings.make(run).unwrap();
            let path = recordings.of(run).join(name);
            fs::write(&path, [0; 100]).unwrap();
            let file = fs::File::options().write(true).open(&path).unwrap();
            file.set_modified(now - Duration::from_secs(age_s)).unwrap();
        }
        let is_there = |run: &str, name: &str| recordings.of(run).join(name).exists();
        keep_within(&recordings, &recordings.runs(), 500);
        assert!(is_there("a", "live.evrec"));
        keep_within(&recordings, &recordings.runs(), 399);
        assert!(!is_there("a", "live.evrec") && !is_there("a", "1.evrec"));
        assert!(!is_there("a", "1.json"));
        keep_within(&recordings, &recordings.runs(), 0);
        assert!(!is_there("b", "3.evrec") && is_there("b", "2.evrec.part"));
        sweep(&recordings, |run| run != "b");
        assert_eq!(recordings.runs(), ["a"]);
    }
}
