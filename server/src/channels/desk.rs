//! What is asked of a run's channels over HTTP, and what became of it: between requests and the run's
//! thread, which looks between two blocks of steps. Nothing of it is stored, and no result depends
//! on it.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::set::ChannelSet;

/// Most runs with channels that were asked for over HTTP. Only those that a worker has take room:
/// some forty descriptors each.
pub const MAX_ASKED_RUNS: usize = 256;

/// What became of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It is open.
    Open,
    /// It is closed, for this reason.
    Closed(String),
}

/// The desk of one run.
#[derive(Debug, Default)]
pub struct Desk {
    asked: Mutex<ChannelSet>,
    changes: AtomicU64,
    fates: Mutex<BTreeMap<&'static str, Fate>>,
    /// A worker looks at it, and at no other of the run.
    is_held: AtomicBool,
}

impl Desk {
    /// What is asked for.
    pub fn asked(&self) -> ChannelSet {
        *lock(&self.asked)
    }

    /// Changes with each request.
    pub fn changes(&self) -> u64 {
        self.changes.load(Ordering::Acquire)
    }

    /// What became of the channels, by name.
    pub fn fates(&self) -> BTreeMap<&'static str, Fate> {
        lock(&self.fates).clone()
    }

    /// Says what became of a channel; nothing of one that nobody wants.
    pub fn say(&self, name: &'static str, fate: Option<Fate>) {
        let mut fates = lock(&self.fates);
        match fate {
            Some(fate) => drop(fates.insert(name, fate)),
            None => drop(fates.remove(name)),
        }
    }

    /// No worker has the run: nothing is open.
    pub fn close_all(&self) {
        lock(&self.fates).retain(|_, fate| *fate != Fate::Open);
    }

    fn ask(&self, set: ChannelSet) {
        *lock(&self.asked) = set;
        self.changes.fetch_add(1, Ordering::Release);
    }
}

/// The desks of all runs that have one, by the run's id.
#[derive(Debug, Default)]
pub struct Desks(Mutex<BTreeMap<String, Arc<Desk>>>);

/// Too many runs have channels that were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMany;

impl Desks {
    /// The desk of a run that a worker takes up.
    pub fn open(&self, run_id: &str) -> Arc<Desk> {
        let mut desks = lock(&self.0);
        let desk = desks.entry(run_id.to_owned()).or_default();
        desk.is_held.store(true, Ordering::Relaxed);
        Arc::clone(desk)
    }

    /// The desk of a run, where it has one.
    pub fn find(&self, run_id: &str) -> Option<Arc<Desk>> {
        lock(&self.0).get(run_id).cloned()
    }

    /// A worker lets go of a run. What was asked for is kept if the run goes on later.
    pub fn leave(&self, run_id: &str, goes_on: bool) {
        let mut desks = lock(&self.0);
        if let Some(desk) = desks.get(run_id) {
            desk.close_all();
            desk.is_held.store(false, Ordering::Relaxed);
            if !goes_on || desk.asked().is_empty() {
                desks.remove(run_id);
            }
        }
    }

    /// Asks for channels of a run, in place of what was asked for before.
    ///
    /// # Errors
    /// [`TooMany`] where too many runs have such channels already.
    pub fn ask(&self, run_id: &str, set: ChannelSet) -> Result<Arc<Desk>, TooMany> {
        let mut desks = lock(&self.0);
        let others = desks.iter().filter(|(id, _)| *id != run_id);
        let asked = others.filter(|(_, desk)| !desk.asked().is_empty()).count();
        if !set.is_empty() && asked >= MAX_ASKED_RUNS {
            return Err(TooMany);
        }
        let desk = Arc::clone(desks.entry(run_id.to_owned()).or_default());
        desk.ask(set);
        if set.is_empty() && !desk.is_held.load(Ordering::Relaxed) {
            desks.remove(run_id);
        }
        Ok(desk)
    }

    /// Ids of runs that channels were asked for.
    pub fn asked(&self) -> Vec<String> {
        let desks = lock(&self.0);
        let asked = desks.iter().filter(|(_, desk)| !desk.asked().is_empty());
        asked.map(|(id, _)| id.clone()).collect()
    }

    /// Forgets a run.
    pub fn forget(&self, run_id: &str) {
        lock(&self.0).remove(run_id);
    }
}

/// Each change is a single assignment: a panic leaves nothing half done.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    const COVERAGE: ChannelSet = ChannelSet {
        frames: false,
        coverage: true,
        metrics: false,
        status: false,
        lossless: None,
    };

    #[test]
    fn what_is_asked_for_waits_for_a_worker_and_ends_with_the_run() {
        let desks = Desks::default();
        let asked = desks.ask("a", COVERAGE).unwrap();
        let desk = desks.open("a");
        assert!(Arc::ptr_eq(&asked, &desk));
        assert_eq!((desk.asked(), desk.changes()), (COVERAGE, 1));
        desk.say("coverage", Some(Fate::Open));
        desks.leave("a", true);
        assert!(desks.find("a").unwrap().fates().is_empty());
        desks.leave("a", false);
        assert!(desks.find("a").is_none());
        desks.open("b");
        desks.leave("b", true);
        assert!(desks.find("b").is_none(), "nothing was asked of it");
    }

    #[test]
    fn a_desk_that_a_worker_looks_at_stays_when_nothing_is_asked_for() {
        let desks = Desks::default();
        let desk = desks.open("a");
        desks.ask("a", COVERAGE).unwrap();
        for _ in 0..2 {
            desks.ask("a", ChannelSet::default()).unwrap();
        }
        desks.ask("a", COVERAGE).unwrap();
        assert_eq!(desk.asked(), COVERAGE);
        desks.ask("a", ChannelSet::default()).unwrap();
        desks.leave("a", true);
        assert!(desks.find("a").is_none());
    }

    #[test]
    fn so_many_runs_have_channels_and_no_more() {
        let desks = Desks::default();
        for run in 0..MAX_ASKED_RUNS {
            desks.ask(&run.to_string(), COVERAGE).unwrap();
        }
        assert!(desks.ask("more", COVERAGE).is_err());
        assert!(desks.ask("3", COVERAGE).is_ok(), "it has some already");
        assert!(desks.ask("more", ChannelSet::default()).is_ok());
        desks.ask("3", ChannelSet::default()).unwrap();
        assert!(desks.ask("more", COVERAGE).is_ok());
    }
}
