//! Where listeners come from: how many there may be, and the thread that looks for changes while
//! there are any.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError, TryLockError, Weak};
use std::time::{Duration, Instant};

use api::Job;
use api::events::Event;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};

use super::board::{Board, Jobs};
use crate::findings::views;
use crate::scheduler::Scheduler;
use crate::store::{JobKey, JobMark, Store, StoreError, Subject};

/// Most listeners at once.
pub const MAX_LISTENERS: usize = 512;
/// Time between two looks for changes.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// How long a job as it was serves all its listeners.
const JOB_KEPT: Duration = Duration::from_millis(400);
/// Most jobs that are kept; beyond that all are forgotten.
const MAX_JOBS_KEPT: usize = 1_024;

/// All listeners that there may be are there.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("{MAX_LISTENERS} listeners to events are there already, and no more may be")]
pub struct TooManyListeners;

/// What the last look for changes found.
#[derive(Clone, Debug, Default)]
pub(super) struct Latest {
    /// Number of the newest change ...
    pub newest: u64,
    /// ... and of the newest of the look before.
    before: u64,
    /// Whom those between the two concern; `None` for everyone.
    concerned: Option<Arc<BTreeSet<Subject>>>,
}

impl Latest {
    /// Whether someone who has heard of all changes up to this one has missed none.
    pub fn is_nothing_to(&self, subject: Subject, heard: u64) -> bool {
        let concerns = |concerned: &Arc<BTreeSet<Subject>>| match subject {
            Subject::All => true,
            Subject::Job(_) | Subject::Run(_) => concerned.contains(&subject),
        };
        heard >= self.newest
            || heard >= self.before
                && self
                    .concerned
                    .as_ref()
                    .is_some_and(|concerned| !concerns(concerned))
    }
}

/// A listener's place; free again when it is dropped.
pub(super) struct Place {
    /// What the last look for changes found.
    pub latest: watch::Receiver<Latest>,
    _held: OwnedSemaphorePermit,
}

/// What listeners have in common.
pub struct Hub {
    pub(super) store: Arc<Store>,
    pub(super) scheduler: Arc<Scheduler>,
    places: Arc<Semaphore>,
    latest: watch::Sender<Latest>,
    jobs: Mutex<BTreeMap<JobKey, (Instant, Job)>>,
    board: Mutex<Board>,
}

impl Hub {
    /// Listeners of this store, and the thread that looks for changes until the hub is dropped.
    pub fn start(store: Arc<Store>, scheduler: Arc<Scheduler>) -> Arc<Self> {
        let hub = Arc::new(Self {
            store,
            scheduler,
            places: Arc::new(Semaphore::new(MAX_LISTENERS)),
            latest: watch::Sender::default(),
            jobs: Mutex::default(),
            board: Mutex::default(),
        });
        let watched = Arc::downgrade(&hub);
        let thread = std::thread::Builder::new()
            .name("events".to_owned())
            .spawn(move || look_for_changes(&watched));
        if let Err(error) = thread {
            tracing::warn!(%error, "no thread looks for changes: listeners hear of them late");
        }
        hub
    }

    /// A place for a listener, who hears of changes from now on.
    ///
    /// # Errors
    /// When there are too many.
    pub(super) fn place(&self) -> Result<Place, TooManyListeners> {
        let held = Arc::clone(&self.places)
            .try_acquire_owned()
            .map_err(|_| TooManyListeners)?;
        let latest = self.latest.subscribe();
        Ok(Place {
            latest,
            _held: held,
        })
    }

    /// The job as it was a moment ago, if somebody looked at it then, without waiting for anybody.
    pub(super) fn kept_job(&self, key: JobKey) -> Option<Job> {
        let jobs = match self.jobs.try_lock() {
            Ok(jobs) => jobs,
            Err(TryLockError::Poisoned(jobs)) => jobs.into_inner(),
            Err(TryLockError::WouldBlock) => return None,
        };
        let (at, job) = jobs.get(&key)?;
        (at.elapsed() < JOB_KEPT).then(|| job.clone())
    }

    /// The job as it is, or was a moment ago; `None` when it is gone.
    pub(super) fn job(&self, key: JobKey) -> Result<Option<Job>, StoreError> {
        let mut jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((at, job)) = jobs.get(&key)
            && at.elapsed() < JOB_KEPT
        {
            return Ok(Some(job.clone()));
        }
        let Some(job) = Jobs::job(self, key)? else {
            return Ok(None);
        };
        if jobs.len() >= MAX_JOBS_KEPT {
            jobs.clear();
        }
        jobs.insert(key, (Instant::now(), job.clone()));
        Ok(Some(job))
    }

    /// Number of the newest change that what is told of all jobs has taken in.
    pub(super) fn newest_of_all(&self) -> Result<u64, StoreError> {
        let mut board = self.board.lock().unwrap_or_else(PoisonError::into_inner);
        board.newest(self)
    }

    /// What has changed of all jobs since the look of this number, all of them, as they were after a
    /// change, for none; and the number of the last look. `None` for whoever has missed too much.
    pub(super) fn all_since(
        &self,
        heard: Option<u64>,
        change: u64,
    ) -> Result<Option<(Vec<Event>, u64)>, StoreError> {
        let mut board = self.board.lock().unwrap_or_else(PoisonError::into_inner);
        board.since(self, heard, change)
    }

    /// Looks for changes, and says so where there are any.
    fn look(&self) -> Result<(), StoreError> {
        let before = self.latest.borrow().newest;
        let newest = self.store.newest_change()?;
        if newest != before {
            let concerned = self.store.concerned(before, newest)?;
            self.latest.send_replace(Latest {
                newest,
                before,
                concerned: concerned.map(Arc::new),
            });
        }
        Ok(())
    }
}

impl Jobs for Hub {
    fn newest_change(&self) -> Result<u64, StoreError> {
        self.store.newest_change()
    }

    fn marks(&self) -> Result<Vec<JobMark>, StoreError> {
        self.store.job_marks()
    }

    fn job(&self, key: JobKey) -> Result<Option<Job>, StoreError> {
        let view = self.store.job(key)?;
        Ok(view.map(|view| views::job(&view, &self.scheduler)))
    }
}

fn look_for_changes(hub: &Weak<Hub>) {
    let mut complained = false;
    loop {
        std::thread::sleep(LOOK_EVERY);
        let Some(hub) = hub.upgrade() else { return };
        if hub.latest.receiver_count() == 0 {
            continue;
        }
        match hub.look() {
            Ok(()) => complained = false,
            Err(error) if complained => tracing::debug!(%error, "no look for changes"),
            Err(error) => {
                complained = true;
                tracing::warn!(%error, "changes cannot be looked for; listeners wait");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_missed_no_change_of_theirs_need_not_look() {
        let [mine, other] = [1, 2].map(|key| Subject::Job(JobKey(key)));
        let latest = Latest {
            newest: 20,
            before: 10,
            concerned: Some(Arc::new([mine].into())),
        };
        assert!(!latest.is_nothing_to(mine, 10) && latest.is_nothing_to(mine, 20));
        // Before the look before, there may have been something.
        assert!(latest.is_nothing_to(other, 10) && !latest.is_nothing_to(other, 9));
        assert!(!latest.is_nothing_to(Subject::All, 10));
        let of_many = Latest {
            concerned: None,
            ..latest
        };
        assert!(!of_many.is_nothing_to(other, 10));
    }
}
