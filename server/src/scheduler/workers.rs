//! The worker threads, the queue that they take runs from, and whoever changes what is wanted.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use api::WaitsFor;
use swarm::run::Run;
use tokio::sync::oneshot;

use super::attempt::{self, Ended};
use super::changing::Changing;
use super::config::SchedulerConfig;
use super::controllers;
use super::counters::Counters;
use super::live::{LiveRun, View};
use super::queue::FairQueue;
use super::spread::Spread;
use crate::break_points::{Place, reach};
use crate::channels::{ChannelSettings, Desks};
use crate::store::{
    ClaimedRun, CreateJobError, Created, Intent, JobKey, JobRequest, Last, NewJob, RunKey,
    StoppedRun, Store, StoreError,
};
use crate::watching::Viewer;

/// Time between two tries to store what must be stored, when the database fails.
const RETRY: Duration = Duration::from_secs(2);

/// The workers and what waits for them.
pub struct Scheduler {
    pub(super) shared: Arc<Shared>,
    pub(super) workers: Mutex<Vec<JoinHandle<()>>>,
    pub(super) changing: Changing,
}

pub(super) struct Shared {
    pub(super) store: Arc<Store>,
    pub(super) config: SchedulerConfig,
    pub(super) counters: Counters,
    pub(super) state: Mutex<State>,
    pub(super) changed: Condvar,
    pub(super) spread: Spread,
    pub(super) desks: Desks,
}

#[derive(Default)]
pub(super) struct State {
    pub(super) queue: FairQueue,
    pub(super) live: BTreeMap<RunKey, Arc<LiveRun>>,
    /// Robot-steps a second of the run that was let go of last.
    pub(super) pace: Option<f64>,
    pub(super) stopping: bool,
}

impl Scheduler {
    /// Takes up what an earlier process left and starts the workers.
    ///
    /// # Errors
    /// When the store fails or a thread cannot be started.
    pub fn start(store: Arc<Store>, config: SchedulerConfig) -> Result<Self, StoreError> {
        let mut state = State::default();
        for (job, priority) in store.priorities()? {
            state.queue.set_priority(job, priority);
        }
        for (job, run) in store.recover()? {
            state.queue.push(job, run);
        }
        let workers = config.workers.get();
        let shared = Arc::new(Shared {
            store,
            config,
            counters: Counters::default(),
            state: Mutex::new(state),
            changed: Condvar::new(),
            spread: Spread::new(workers),
            desks: Desks::default(),
        });
        let scheduler = Self {
            shared,
            workers: Mutex::default(),
            changing: Changing::default(),
        };
        for number in 0..workers {
            let shared = Arc::clone(&scheduler.shared);
            let worker = std::thread::Builder::new()
                .name(format!("worker-{number}"))
                .spawn(move || shared.work())
                .map_err(|source| StoreError::Thread { source })?;
            scheduler.workers().push(worker);
        }
        let shared = Arc::clone(&scheduler.shared);
        let lookout = std::thread::Builder::new()
            .name("controllers".to_owned())
            .spawn(move || controllers::look_out(&*shared))
            .map_err(|source| StoreError::Thread { source })?;
        scheduler.workers().push(lookout);
        Ok(scheduler)
    }

    /// Whether a job of so many runs would be taken; see [`Store::admit`].
    ///
    /// # Errors
    /// As there.
    pub fn admit(&self, request: &JobRequest, runs: u64) -> Result<Option<JobKey>, CreateJobError> {
        let limit = self.shared.config.unfinished_limit;
        self.shared.store.admit(request, runs, limit)
    }

    /// Stores a job and queues its runs; see [`Store::create_job`].
    ///
    /// # Errors
    /// As there; the queue holds as many runs as the scheduler was configured for.
    pub fn submit(&self, job: &NewJob) -> Result<Created, CreateJobError> {
        let created = self
            .shared
            .store
            .create_job(job, self.shared.config.unfinished_limit)?;
        if let Created::New(seq, waiting) = &created {
            self.shared.state().queue.set(*seq, waiting.clone());
            self.shared.changed.notify_all();
        }
        Ok(created)
    }

    /// Changes what is wanted of a job and tells the workers.
    ///
    /// # Errors
    /// When the store fails.
    pub fn set_intent(&self, job: JobKey, intent: Intent) -> Result<(), StoreError> {
        let _changing = self.changing.begin(job);
        let store = &self.shared.store;
        let changed = store.set_intent(job, intent)?;
        if intent == Intent::Active {
            let waiting = store.waiting(job)?;
            self.shared.state().queue.set(job, waiting);
            self.shared.changed.notify_all();
        } else {
            self.shared.state().queue.remove(job);
            self.shared.let_go(&changed, intent == Intent::Cancelled);
        }
        Ok(())
    }

    /// Makes the failed and cancelled runs of a job wait again; see [`Store::retry`].
    ///
    /// # Errors
    /// When the store fails.
    pub fn retry(&self, job: JobKey) -> Result<(), StoreError> {
        let _changing = self.changing.begin(job);
        self.shared.store.retry(job)?;
        let waiting = self.shared.store.waiting(job)?;
        self.shared.state().queue.set(job, waiting);
        self.shared.changed.notify_all();
        Ok(())
    }

    /// Deletes a job with what only it has, and tells the workers.
    ///
    /// # Errors
    /// When the store fails.
    pub fn delete(&self, job: JobKey) -> Result<(), StoreError> {
        let _changing = self.changing.begin(job);
        self.delete_changing(job)
    }

    /// Deletes a job that nobody else changes meanwhile.
    pub(super) fn delete_changing(&self, job: JobKey) -> Result<(), StoreError> {
        let gone = self.shared.store.delete_job(job)?;
        {
            let queue = &mut self.shared.state().queue;
            queue.remove(job);
            queue.set_priority(job, 0);
        }
        self.shared.let_go(&gone, true);
        Ok(())
    }

    /// Cancels one run. Returns whether it was unfinished.
    ///
    /// # Errors
    /// When the store fails.
    pub fn cancel_run(&self, run: RunKey) -> Result<bool, StoreError> {
        let cancelled = self.shared.store.cancel_run(run)?;
        self.shared.let_go(cancelled.as_slice(), true);
        Ok(cancelled.is_some())
    }

    /// The latest view of a run that a worker holds.
    pub fn view(&self, run: RunKey) -> Option<Arc<View>> {
        self.shared.state().live.get(&run)?.view()
    }

    /// Whom a run that a worker holds waits for, and since when.
    pub fn waiting(&self, run: RunKey) -> Option<(WaitsFor, Instant)> {
        self.shared.state().live.get(&run)?.waiting()
    }

    /// Somebody who looks at a run from now on, where a worker holds it.
    pub fn look(&self, run: RunKey) -> Option<Viewer> {
        Some(self.shared.state().live.get(&run)?.window.look())
    }

    /// Asks what a look at a run says, where a worker holds the run; `None` too where too many ask.
    pub fn ask<T: Send + 'static>(
        &self,
        run: RunKey,
        look: impl FnOnce(&Run) -> T + Send + 'static,
    ) -> Option<oneshot::Receiver<T>> {
        let live = self.shared.state().live.get(&run).cloned()?;
        live.window.ask(look)
    }

    /// Whether the workers are to end.
    pub fn is_stopping(&self) -> bool {
        self.shared.state().stopping
    }

    /// Runs that are stepped at a time.
    pub fn worker_count(&self) -> usize {
        self.shared.config.workers.get()
    }

    /// What workers have done since the process started.
    pub fn counters(&self) -> &Counters {
        &self.shared.counters
    }

    /// Runs that wait in the queue of this process.
    pub fn queued(&self) -> usize {
        self.shared.state().queue.len()
    }

    /// Threads that have a run right now.
    pub fn busy(&self) -> Vec<Busy> {
        let state = self.shared.state();
        let busy = |(run, live): (&RunKey, &Arc<LiveRun>)| Busy {
            run: *run,
            seconds: live.begun().elapsed().as_secs_f64(),
            view: live.view(),
            waits_for: live.waiting().map(|(waits_for, _)| waits_for),
        };
        state.live.iter().map(busy).collect()
    }

    /// How it works.
    pub fn config(&self) -> &SchedulerConfig {
        &self.shared.config
    }

    /// The channels' settings.
    pub fn channels(&self) -> &ChannelSettings {
        &self.shared.config.channels
    }

    /// What is asked of channels over HTTP.
    pub fn desks(&self) -> &Desks {
        &self.shared.desks
    }

    /// Lets go of every run, with a checkpoint, and ends the workers. Blocks until they have ended.
    pub fn shut_down(&self) {
        {
            let mut state = self.shared.state();
            state.stopping = true;
            state.live.values().for_each(|live| live.stop());
        }
        self.shared.changed.notify_all();
        let workers = std::mem::take(&mut *self.workers());
        for worker in workers {
            if worker.join().is_err() {
                tracing::error!("a worker had panicked");
            }
        }
    }

    pub(super) fn workers(&self) -> MutexGuard<'_, Vec<JoinHandle<()>>> {
        self.workers.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A thread that has a run.
#[derive(Clone, Debug)]
pub struct Busy {
    /// The run.
    pub run: RunKey,
    /// Time since it took it.
    pub seconds: f64,
    /// How far the run is; `None` while it is set up.
    pub view: Option<Arc<View>>,
    /// Whom the run waits for, where that lasts.
    pub waits_for: Option<WaitsFor>,
}

impl Drop for Scheduler {
    fn drop(&mut self) {
        self.shut_down();
    }
}

impl Shared {
    pub(super) fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells workers to look at what became of these runs. Checkpoints of runs that are dropped and
    /// that no worker holds are removed here; the others by their workers.
    pub(super) fn let_go(&self, runs: &[StoppedRun], dropped: bool) {
        for run in runs {
            let live = self.state().live.get(&run.seq).cloned();
            match live {
                Some(live) => live.stop(),
                None if dropped && !self.is_wanted(run.seq) => {
                    self.store.checkpoints().remove(&run.id);
                    self.store.recordings().live(&run.id).remove();
                }
                None => {}
            }
            if dropped && matches!(self.store.run_by_key(run.seq), Ok(None)) {
                self.store.finals().remove(&run.id);
                self.store.origins().remove(&run.id);
            }
        }
    }

    pub(super) fn is_wanted(&self, run: RunKey) -> bool {
        self.store.is_unfinished(run).unwrap_or(true)
    }

    pub(super) fn work(&self) {
        while let Some((claimed, live)) = self.next() {
            self.step(&claimed, &live);
            self.release(claimed.seq);
        }
    }

    /// Waits for a run and claims it; `None` at the end.
    pub(super) fn next(&self) -> Option<(ClaimedRun, Arc<LiveRun>)> {
        loop {
            let (job, run, live) = self.take()?;
            match self.store.claim(run) {
                Ok(Some(claimed)) => {
                    reach(Place::Claimed);
                    return Some((claimed, live));
                }
                Ok(None) => self.release(run),
                Err(error) => {
                    tracing::error!(%error, "a run cannot be claimed; trying again");
                    self.state().queue.push_front(job, run);
                    self.release(run);
                    self.pause(RETRY);
                }
            }
        }
    }

    /// Waits for a run in the queue and reserves it, so that whoever changes it finds who to tell.
    pub(super) fn take(&self) -> Option<(JobKey, RunKey, Arc<LiveRun>)> {
        let mut guard = self.state();
        loop {
            let state = &mut *guard;
            if state.stopping {
                return None;
            }
            if let Some((job, run)) = state.queue.pop(|run| !state.live.contains_key(&run)) {
                let live = Arc::new(LiveRun::new(state.pace));
                state.live.insert(run, Arc::clone(&live));
                self.spread.set_busy(state.live.len());
                return Some((job, run, live));
            }
            guard = self
                .changed
                .wait(guard)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    pub(super) fn release(&self, run: RunKey) {
        {
            let mut state = self.state();
            if let Some(live) = state.live.remove(&run) {
                state.pace = live.pace();
            }
            self.spread.set_busy(state.live.len());
        }
        self.changed.notify_all();
    }

    /// Steps a claimed run and stores what became of it.
    pub(super) fn step(&self, claimed: &ClaimedRun, live: &LiveRun) {
        let _span = tracing::info_span!("run", id = claimed.id).entered();
        let stepping = AssertUnwindSafe(|| {
            let (store, config, counters) = (&self.store, &self.config, &self.counters);
            let desk = self.desks.open(&claimed.id);
            attempt::attempt(store, config, counters, claimed, live, &self.spread, desk)
        });
        let ended = catch_unwind(stepping).unwrap_or_else(|panic| Ended::Failed(said(&*panic)));
        let goes_on = matches!(ended, Ended::Stopped(..));
        self.desks.leave(&claimed.id, goes_on);
        match ended {
            Ended::Finished(finished, last) => {
                let last = (!last.is_empty()).then_some(Last {
                    id: &claimed.id,
                    snapshot: &last,
                });
                self.persist(&claimed.id, live, || {
                    self.store.finish(claimed.seq, &finished, last).map(drop)
                });
            }
            Ended::Failed(reason) => {
                tracing::error!(run = claimed.id, reason, "the run failed");
                self.persist(&claimed.id, live, || self.store.fail(claimed.seq, &reason));
            }
            Ended::Stopped(run, recorder, waits) => {
                let parking = AssertUnwindSafe(|| {
                    attempt::park(&self.store, claimed, &run, &recorder, waits.as_ref());
                });
                if let Err(panic) = catch_unwind(parking) {
                    let reason = said(&*panic);
                    self.persist(&claimed.id, live, || self.store.fail(claimed.seq, &reason));
                }
            }
        }
    }

    /// Stores the end of a run, and tries again until the database takes it or the process ends: the
    /// run then starts again from its checkpoint.
    pub(super) fn persist(
        &self,
        id: &str,
        live: &LiveRun,
        store: impl Fn() -> Result<(), StoreError>,
    ) {
        let since = Instant::now();
        while let Err(error) = store() {
            live.waits(WaitsFor::Store, since);
            tracing::error!(run = id, %error, "the end of the run cannot be stored; trying again");
            if self.pause(RETRY) {
                return;
            }
        }
        reach(Place::ResultStored);
        self.store.checkpoints().remove(id);
    }

    /// Waits, and returns whether the workers are to end.
    pub(super) fn pause(&self, time: Duration) -> bool {
        let running = |state: &mut State| !state.stopping;
        let (state, _) = self
            .changed
            .wait_timeout_while(self.state(), time, running)
            .unwrap_or_else(PoisonError::into_inner);
        state.stopping
    }
}

impl controllers::Workers for Shared {
    fn store(&self) -> &Store {
        &self.store
    }

    fn config(&self) -> &SchedulerConfig {
        &self.config
    }

    fn rest(&self, time: Duration) -> bool {
        self.pause(time)
    }

    fn queue(&self, job: JobKey, run: RunKey) {
        self.state().queue.push(job, run);
        self.changed.notify_all();
    }
}

/// What a panic said.
fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned());
    format!(
        "the simulation panicked: {}",
        text.as_deref().unwrap_or("without a message")
    )
}
