//! Looks whether the programs are there that runs wait for, and lets such runs go on.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::attempt::stored_spec;
use super::config::SchedulerConfig;
use crate::channels::Lookout;
use crate::store::{JobKey, RunKey, StoppedRun, Store, StoreError};

/// Time between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(300);
/// Most runs that are looked after at once; the others wait for their turn.
const MOST: u32 = 256;
/// A controller that is there and does not answer is tried again after this time, and then after
/// twice as long each time, up to [`LONGEST`].
const FIRST: Duration = Duration::from_millis(300);
/// Longest time between two tries.
const LONGEST: Duration = Duration::from_secs(10);
/// A run that is not held again for so long has got its controllers back for good.
const FORGET: Duration = Duration::from_secs(120);

/// A run that was let go on.
struct Tried {
    at: Instant,
    next_after: Duration,
}

/// What it does for the scheduler, which ends it.
pub trait Workers {
    /// The runs.
    fn store(&self) -> &Store;
    /// Where they meet their controllers.
    fn config(&self) -> &SchedulerConfig;
    /// Waits, and returns whether the workers are to end.
    fn rest(&self, time: Duration) -> bool;
    /// A run of a job waits for a worker.
    fn queue(&self, job: JobKey, run: RunKey);
}

/// Until the scheduler ends.
pub fn look_out(workers: &impl Workers) {
    let mut lookout = None;
    let mut tried: BTreeMap<RunKey, Tried> = BTreeMap::new();
    while !workers.rest(LOOK_EVERY) {
        let waiting = match workers.store().await_controllers(MOST) {
            Ok(waiting) => waiting,
            Err(error) => {
                tracing::debug!(%error, "no look for controllers");
                continue;
            }
        };
        tried.retain(|_, tried| tried.at.elapsed() < FORGET);
        if waiting.is_empty() {
            lookout = None;
            continue;
        }
        let root = &workers.config().channels.root;
        let lookout = match &mut lookout {
            Some(lookout) => lookout,
            none => match Lookout::open(root) {
                Ok(opened) => none.insert(opened),
                Err(error) => {
                    tracing::debug!(%error, "no look for controllers");
                    continue;
                }
            },
        };
        for run in waiting {
            let next_after = tried.get(&run.seq).map_or(FIRST, |tried| tried.next_after);
            let is_early = (tried.get(&run.seq)).is_some_and(|it| it.at.elapsed() < it.next_after);
            if is_early || !are_there(workers.store(), lookout, &run) {
                continue;
            }
            let now = Tried {
                at: Instant::now(),
                next_after: (next_after * 2).min(LONGEST),
            };
            tried.insert(run.seq, now);
            if let Err(error) = go_on(workers, run.seq) {
                tracing::warn!(run = run.id, %error, "the run cannot go on yet");
            }
        }
    }
}

fn go_on(workers: &impl Workers, run: RunKey) -> Result<(), StoreError> {
    let store = workers.store();
    if store.release(run, None, "its controllers are there")? == Some(true) {
        for job in store.jobs_of(run)? {
            workers.queue(job, run);
        }
    }
    Ok(())
}

fn are_there(store: &Store, lookout: &Lookout, run: &StoppedRun) -> bool {
    let spec = store.spec(run.seq).ok().flatten();
    let resolved = spec.and_then(|text| stored_spec(store, &text).ok());
    resolved.is_some_and(|spec| {
        let parameters = swarm::methods::ExternalParameters::of(&spec.run_spec());
        lookout
            .all_there(&run.id, parameters.controllers as usize)
            .unwrap_or(false)
    })
}
