//! One worker with one run: from its checkpoint or its beginning, to its end or until it is asked to
//! let go.

use std::sync::Arc;
use std::time::Instant;

use api::FieldError;
use swarm::crew::Crew;
use swarm::run::{Progress, Run};

use super::SchedulerConfig;
use super::counters::{CountedSteps, Counters};
use super::live::{LiveRun, Views, findings_of};
use super::onlookers::Onlookers;
use super::spread::Spread;
use crate::artifacts::{run_result, thread_cpu_s};
use crate::channels::{AskError, ChannelSet, Desk, Extent, External, Fate, RunChannels};
use crate::documents::{ResolvedRun, Stretch, resolve_stored};
use crate::recording::{
    Begun, Keeper, SharedRecorder, Tail, begin, begin_at_origin, finish, first_whole_epoch, header,
};
use crate::runner::{
    self, Attendant, Checkpoints, MemoryBound, PauseAt, Pilot, Stop, Threads, Waits,
};
use crate::store::{Checkpoint, ClaimedRun, Finished, Position, Store, StoreError};
use crate::watching::Watched;

/// How an attempt ended.
pub enum Ended {
    /// The run is done; with its last state, where that is to be kept.
    Finished(Box<Finished>, Vec<u8>),
    /// The worker was asked to let go, or the run's controllers do not answer.
    Stopped(Box<Run>, SharedRecorder, Option<Waits>),
    /// The run cannot go on.
    Failed(String),
}

/// Steps a run until it ends or is asked to stop. May panic where the simulation does.
pub fn attempt(
    store: &Arc<Store>,
    config: &SchedulerConfig,
    counters: &Counters,
    claimed: &ClaimedRun,
    live: &LiveRun,
    spread: &Spread,
    desk: Arc<Desk>,
) -> Ended {
    let start = Instant::now();
    let cpu_s = thread_cpu_s();
    let resolved = match stored_spec(store, &claimed.spec) {
        Ok(resolved) => resolved,
        Err(errors) => return Ended::Failed(spec_failure(errors)),
    };
    let opened = open(store, claimed, &resolved);
    let begun = opened.and_then(|run| recorded(store, config, claimed, &resolved, run));
    let (mut run, recorder) = match begun {
        Ok(Begun { run, recorder }) => (run, recorder),
        Err(reason) => return Ended::Failed(reason),
    };
    let external = match External::open(&config.channels.root, &claimed.id, run.spec()) {
        Ok(external) => external,
        Err(error) => {
            desk.say("external", Some(Fate::Closed(error.to_string())));
            return Ended::Stopped(Box::new(run), recorder, Some(waits(&error)));
        }
    };
    if external.is_some() {
        desk.say("external", Some(Fate::Open));
    }
    let done_before = run.progress().robot_steps_done;
    let recorded = recorder.clone();
    let take = move |run: &Run| (checkpoint_of(run), recorded.tail());
    let checkpoints = Checkpoints::new(take, {
        let (store, id) = (Arc::clone(store), claimed.id.clone());
        let saves = Arc::clone(live.saves());
        let counters = counters.clone();
        move |(checkpoint, tail)| {
            let mut outcome = Ok(());
            counters.time_checkpoint(|| {
                outcome = write(&store, &id, &checkpoint, tail);
                outcome.is_ok()
            });
            saves.is_written(outcome);
        }
    })
    .also_when({
        let saves = Arc::clone(live.saves());
        move || saves.is_asked()
    });
    let onlookers = Onlookers::new(
        live,
        vec![
            Box::new(Views::new(live, done_before)),
            Box::new(Watched::new(&live.window, run.robots().len())),
            Box::new(checkpoints),
        ],
    );
    let mut channels = RunChannels::new(
        &config.channels,
        &claimed.id,
        Extent::of(&resolved.run_spec()),
        ChannelSet::of_spec(resolved.channels()),
        Arc::clone(&desk),
        Arc::clone(live.stop_flag()),
        &onlookers,
    );
    let mut steered = external.map(|external| Steered {
        external,
        attendant: &onlookers,
    });
    let pilot = steered.as_mut().map(|steered| steered as &mut dyn Pilot);
    let mut recording = recorder.clone();
    let mut keeper = config.keep_every_epochs.map(|every| {
        let directory = store.recordings().of(&claimed.id);
        Keeper::new(directory, every, run.spec().steps_per_epoch)
    });
    let mut memory = MemoryBound::new(config.run_memory_bytes);
    let mut steps = CountedSteps::new(counters, done_before);
    let mut pause = claimed.pause_at_step.map(PauseAt);
    let is_large = Crew::useful_threads(run.spec().robots as usize) > 1;
    let large = is_large.then(|| spread.large_run());
    let mut threads = large.as_ref().map(|large| Threads::new(|| large.threads()));
    let ended = runner::step_by(
        &mut run,
        pilot,
        &|| live.is_stopping(),
        &mut [
            &mut threads,
            &mut memory,
            &mut steps,
            &mut channels,
            &mut &onlookers,
            &mut pause,
            &mut recording,
            &mut keeper,
        ],
    );
    let cpu_s = thread_cpu_s() - cpu_s + threads.as_ref().map_or(0.0, Threads::cpu_s);
    let steps = run.progress().robot_steps_done - done_before;
    if steps > 0 {
        live.set_pace(steps as f64 / start.elapsed().as_secs_f64().max(1e-9));
    }
    let waits = match ended {
        runner::Ended::Failed(reason) => return Ended::Failed(reason),
        runner::Ended::Waiting(waits) => Some(waits),
        runner::Ended::Done | runner::Ended::Stopped => None,
    };
    match run.end() {
        Some((outcome, last)) => {
            if let Err(why) = finish(&recorder) {
                tracing::warn!(run = claimed.id, why, "the recording is not whole");
            }
            let result = run_result(&outcome);
            let keeps = store.finals().most_bytes() > 0;
            let last = if keeps { last } else { Vec::new() };
            let finished = Finished {
                result,
                findings: findings_of(&run),
                cpu_ns_per_robot_step: (steps > 0).then(|| cpu_s * 1e9 / steps as f64),
            };
            Ended::Finished(Box::new(finished), last)
        }
        None => Ended::Stopped(Box::new(run), recorder, waits),
    }
}

/// Programs that steer a run, and who attends to it while it waits for them.
struct Steered<'a> {
    external: External,
    attendant: &'a dyn Attendant,
}

impl Pilot for Steered<'_> {
    fn steer(&mut self, run: &mut Run) -> Result<(), Stop> {
        let steered = self.external.steer(run, self.attendant);
        steered.map_err(|error| match error {
            AskError::LetGo => Stop::LetGo,
            error => Stop::Wait(waits(&error)),
        })
    }
}

/// What a run waits for that could not be steered.
fn waits(error: &AskError) -> Waits {
    Waits {
        why: format!("waits: {error}"),
        for_controllers: error.may_pass(),
    }
}

/// Stores the position and the checkpoint of a run that is let go, unless it is not wanted any more.
pub fn park(
    store: &Store,
    claimed: &ClaimedRun,
    run: &Run,
    recorder: &SharedRecorder,
    waits: Option<&Waits>,
) {
    let pause = claimed.pause_at_step.map(PauseAt);
    let held = match waits {
        Some(waits) => store.hold_waiting(claimed.seq, &waits.why, waits.for_controllers),
        None if pause.is_some_and(|pause| pause.is_reached(run)) => {
            store.hold(claimed.seq, "paused after the steps asked for")
        }
        None => Ok(None),
    };
    if let Err(error) = held {
        tracing::error!(run = claimed.id, %error, "the run cannot be held; it goes on");
    }
    let Progress {
        phase,
        epochs_done,
        robot_steps_done,
        robot_steps_total,
        ..
    } = run.progress();
    let position = Position {
        phase: phase.name().to_owned(),
        epochs_done,
        robot_steps_done,
    };
    match store.park(claimed.seq, &position, robot_steps_total) {
        Ok(true) => save(store, &claimed.id, run, recorder),
        Ok(false) => {
            store.checkpoints().remove(&claimed.id);
            drop(recorder.take());
            store.recordings().live(&claimed.id).remove();
        }
        Err(error) => {
            tracing::error!(run = claimed.id, %error, "the run's position cannot be stored");
            save(store, &claimed.id, run, recorder);
        }
    }
}

fn save(store: &Store, id: &str, run: &Run, recorder: &SharedRecorder) {
    // What could not be written is in the log; the run starts from what there is.
    drop(write(store, id, &checkpoint_of(run), recorder.tail()));
}

pub fn checkpoint_of(run: &Run) -> Checkpoint {
    Checkpoint {
        findings: findings_of(run),
        snapshot: run.snapshot(),
    }
}

/// A run without a checkpoint starts again after a crash, with the same result: a warning will do.
/// The recording comes first: a checkpoint that it does not reach to would be worth nothing.
fn write(
    store: &Store,
    id: &str,
    checkpoint: &Checkpoint,
    tail: Option<Tail>,
) -> Result<(), StoreError> {
    if tail.is_some_and(|tail| !tail.keep()) {
        tracing::warn!(run = id, "the recording cannot be kept");
    }
    let written = store.checkpoints().write(id, checkpoint);
    if let Err(error) = &written {
        tracing::warn!(run = id, %error, "the checkpoint cannot be written");
    }
    written
}

pub fn stored_spec(store: &Store, spec: &str) -> Result<ResolvedRun, Vec<FieldError>> {
    resolve_stored(spec, &super::StoredArenas::new(store))
}

/// The run at its checkpoint; at its beginning when there is none that can be used, which for some
/// is the state of another run.
fn open(store: &Store, claimed: &ClaimedRun, resolved: &ResolvedRun) -> Result<Run, String> {
    let id = claimed.id.as_str();
    let restored = match store.checkpoints().read(id) {
        Ok(None) => None,
        Ok(Some(checkpoint)) => Run::restore(resolved.run_spec(), &checkpoint.snapshot)
            .map_err(|error| warn_discarded(id, &error))
            .ok(),
        Err(error) => {
            warn_discarded(id, &error);
            None
        }
    };
    if let Some(run) = restored {
        return Ok(run);
    }
    anew(store, claimed, resolved)
}

/// The run at its beginning.
fn anew(store: &Store, claimed: &ClaimedRun, resolved: &ResolvedRun) -> Result<Run, String> {
    let id = claimed.id.as_str();
    store.checkpoints().remove(id);
    if claimed.has_origin {
        return begin_at_origin(store, id, resolved)?
            .ok_or_else(|| "the state that it goes on from is gone".to_owned());
    }
    Run::new(resolved.run_spec()).map_err(|errors| {
        let errors = errors.into_iter();
        let told = errors.map(|e| FieldError::new(e.pointer, e.message, e.allowed));
        spec_failure(told.collect())
    })
}

/// The run with whoever records it, if its spec asks for that.
fn recorded(
    store: &Store,
    config: &SchedulerConfig,
    claimed: &ClaimedRun,
    resolved: &ResolvedRun,
    run: Run,
) -> Result<Begun, String> {
    let id = claimed.id.as_str();
    let nobody = SharedRecorder::new(None);
    let Some(request) = resolved.record() else {
        return Ok(Begun {
            run,
            recorder: nobody,
        });
    };
    let mut stretch = Stretch::whole(&resolved.run_spec());
    if claimed.has_origin {
        let origin = begin_at_origin(store, id, resolved)?;
        let first = origin.map_or(0, |origin| first_whole_epoch(&origin));
        stretch = stretch.starting_at(first);
    }
    if let Err(error) = store.recordings().make(id) {
        tracing::warn!(run = id, %error, "the run goes on without a recording");
    }
    let (paths, header) = (
        store.recordings().live(id),
        header(resolved, request, stretch),
    );
    let most_bytes = config.recordings.of_one();
    begin(run, header, &paths, most_bytes, || {
        anew(store, claimed, resolved)
    })
}

fn warn_discarded(id: &str, error: &dyn std::fmt::Display) {
    tracing::warn!(run = id, %error, "the checkpoint is discarded; the run starts again");
}

fn spec_failure(errors: Vec<FieldError>) -> String {
    let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
    format!("the spec cannot be run: {}", errors.join("; "))
}
