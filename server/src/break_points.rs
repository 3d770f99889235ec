//! Places where tests end the real program as a crash does: `EVSWARM_BREAK=NAME:N` kills it when it
//! comes to place NAME for the Nth time. Unset, a place costs one relaxed load.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

/// A place. Each has a test in `tests/tests/crashes.rs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Before the database is brought up to date, within each migration, before its transaction
    /// ends, and after it.
    Migration,
    /// A worker has claimed a run.
    Claimed,
    /// A checkpoint is written, but not yet in its place.
    CheckpointRename,
    /// A run's result is stored, its checkpoint still there.
    ResultStored,
    /// A part of a posted job is stored.
    JobPart,
    /// A posted job is stored, but not yet acknowledged.
    JobStored,
    /// A part of the runs of a job that was paused, cancelled or deleted is changed.
    JobChanged,
}

const PLACES: [(&str, Place); 7] = [
    ("migration", Place::Migration),
    ("claimed", Place::Claimed),
    ("checkpoint-rename", Place::CheckpointRename),
    ("result-stored", Place::ResultStored),
    ("job-part", Place::JobPart),
    ("job-stored", Place::JobStored),
    ("job-changed", Place::JobChanged),
];

static IS_SET: AtomicBool = AtomicBool::new(false);
static BREAK: OnceLock<(Place, AtomicU64)> = OnceLock::new();

/// Sets what `EVSWARM_BREAK` asks for.
///
/// # Errors
/// What is allowed, when it asks for anything else.
pub fn set_from_environment() -> Result<(), String> {
    let Ok(asked) = std::env::var("EVSWARM_BREAK") else {
        return Ok(());
    };
    let Some((place, count)) = parse(&asked) else {
        let names = PLACES.map(|(name, _)| name).join(", ");
        return Err(format!(
            "EVSWARM_BREAK is {asked:?}; it is NAME:N with N from 1, NAME one of {names}"
        ));
    };
    BREAK.get_or_init(|| (place, AtomicU64::new(count)));
    IS_SET.store(true, Relaxed);
    Ok(())
}

fn parse(asked: &str) -> Option<(Place, u64)> {
    let (name, count) = asked.split_once(':')?;
    let count = count.parse().ok().filter(|&count| count > 0)?;
    let (_, place) = PLACES.into_iter().find(|(known, _)| *known == name)?;
    Some((place, count))
}

/// Comes to a place; returns unless the process was to be killed here.
pub fn reach(place: Place) {
    if IS_SET.load(Relaxed) {
        count_down(place);
    }
}

#[cold]
fn count_down(place: Place) {
    let asked = BREAK.get().filter(|(asked, _)| *asked == place);
    if asked.is_some_and(|(_, left)| left.fetch_sub(1, Relaxed) == 1) {
        let process = rustix::process::getpid();
        let killed = rustix::process::kill_process(process, rustix::process::Signal::KILL);
        tracing::error!(?killed, "the process lives on at a break point");
        std::process::abort();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_asked_for_by_name_and_number() {
        assert_eq!(parse("claimed:3"), Some((Place::Claimed, 3)));
        for wrong in ["claimed", "claimed:0", "claimed:-1", "nowhere:1", ":1", ""] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
