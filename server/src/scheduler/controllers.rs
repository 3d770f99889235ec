//! Looks whether the programs are there that runs wait for, and lets such runs go on.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::Shared;
use super::attempt::stored_spec;
use crate::channels::Lookout;
use crate::store::{RunKey, StoppedRun, StoreError};

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

/// Until the scheduler ends.
pub fn look_out(shared: &Shared) {
    let mut lookout = None;
    let mut tried: BTreeMap<RunKey, Tried> = BTreeMap::new();
    while !shared.pause(LOOK_EVERY) {
        let waiting = match shared.store.await_controllers(MOST) {
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
        let root = &shared.config.channels.root;
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
            if is_early || !are_there(shared, lookout, &run) {
                continue;
            }
            let now = Tried {
                at: Instant::now(),
                next_after: (next_after * 2).min(LONGEST),
            };
            tried.insert(run.seq, now);
            if let Err(error) = go_on(shared, run.seq) {
                tracing::warn!(run = run.id, %error, "the run cannot go on yet");
            }
        }
    }
}

fn go_on(shared: &Shared, run: RunKey) -> Result<(), StoreError> {
    if !shared
        .store
        .release(run, None, "its controllers are there")?
    {
        return Ok(());
    }
    for job in shared.store.jobs_of(run)? {
        shared.state().queue.push(job, run);
    }
    shared.changed.notify_all();
    Ok(())
}

fn are_there(shared: &Shared, lookout: &Lookout, run: &StoppedRun) -> bool {
    let controllers = shared
        .store
        .spec(run.seq)
        .ok()
        .flatten()
        .and_then(|text| stored_spec(&shared.store, &text).ok())
        .map(|spec| swarm::methods::ExternalParameters::of(&spec.run_spec()).controllers);
    controllers.is_some_and(|controllers| {
        lookout
            .all_there(&run.id, controllers as usize)
            .unwrap_or(false)
    })
}
