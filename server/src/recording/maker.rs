//! Recordings that are asked for afterwards: the run is stepped again in the background, one at a
//! time, from the nearest checkpoint that was kept or from its beginning. The same thread sees to it
//! that recordings do not take too much room, and that none outlives its run.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use api::explanation::Explanation;
use api::recording::{RecordingState, RecordingSummary};
use swarm::run::{Progress, Run};

use super::explained::{keep_explanation, known_explanation};
use super::kept::nearest;
use super::origin::{begin_at_origin, first_whole_epoch};
use super::paths::Stage;
use super::recorder::{Recorder, SharedRecorder};
use super::room::{keep_within, sweep};
use super::subject::header;
use super::wish::{Wish, all};
use crate::documents::{
    MOST_RECORDING_BYTES, RecordRequest, ResolvedRun, Stretch, asked_recording,
};
use crate::explain::{ExplainError, explain};
use crate::runner::{self, MemoryBound, Observer, PauseAt, Stop};
use crate::store::{RunView, Store};

/// Most recordings that wait.
pub const MOST_WAITING: usize = 64;
/// Most recordings of one run.
pub const MOST_OF_A_RUN: usize = 100;
/// How often room is looked after.
const TIDY: Duration = Duration::from_secs(20);

/// Resolves the stored spec of a run.
pub type SpecOf = Box<dyn Fn(&RunView) -> Result<ResolvedRun, String> + Send + Sync>;

/// Makes recordings.
pub struct Maker {
    shared: Arc<Shared>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

struct Shared {
    store: Arc<Store>,
    spec_of: SpecOf,
    settings: Settings,
    state: Mutex<State>,
    changed: Condvar,
}

/// What recordings may take.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Bytes of all recordings together.
    pub most_bytes: u64,
    /// Bytes that a run may hold while it is stepped again.
    pub run_memory_bytes: u64,
}

#[derive(Default)]
struct State {
    waiting: VecDeque<(String, Task)>,
    active: Option<Active>,
    stopping: bool,
}

#[derive(Clone)]
struct Active {
    run: String,
    task: Task,
    stop: Arc<AtomicBool>,
    /// Steps done and in all.
    steps: Arc<[AtomicU64; 2]>,
}

/// What is to be done with a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    /// Make the recording of this number.
    Record(u64),
    /// Explain it.
    Explain,
}

/// How far the explanation of a run is.
#[derive(Clone, Debug)]
pub enum Explained {
    /// It is known.
    Known(Box<Explanation>),
    /// It could not be found.
    Failed(String),
    /// It is being found, this share of it done, or waits.
    Pending(f64),
}

/// Why a recording is not made.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// What is asked for cannot be.
    #[error("the recording cannot be made")]
    Invalid(Vec<api::FieldError>),
    /// The state that the run goes on from cannot be used.
    #[error("{0}")]
    Origin(String),
    /// Too many wait.
    #[error("{MOST_WAITING} recordings wait to be made; try again later")]
    TooManyWait,
    /// The run has too many.
    #[error("the run has {MOST_OF_A_RUN} recordings; delete one first")]
    TooMany,
    /// It cannot be stored.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl Maker {
    /// Takes up what an earlier process left and starts.
    pub fn start(store: Arc<Store>, spec_of: SpecOf, settings: Settings) -> Self {
        let waiting = left_over(&store);
        let shared = Arc::new(Shared {
            store,
            spec_of,
            settings,
            state: Mutex::new(State {
                waiting,
                ..State::default()
            }),
            changed: Condvar::new(),
        });
        let thread = std::thread::Builder::new().name("recordings".to_owned());
        let worker = Arc::clone(&shared);
        let spawned = thread.spawn(move || worker.work());
        if let Err(error) = &spawned {
            tracing::error!(%error, "no thread makes recordings");
        }
        Self {
            shared,
            thread: Mutex::new(spawned.ok()),
        }
    }

    /// Asks for a recording of a run; one that is there, or asked for already, is given back.
    ///
    /// # Errors
    /// When it cannot be made, or too many are asked for.
    pub fn ask(
        &self,
        run: &RunView,
        spec: &ResolvedRun,
        document: &serde_json::Value,
    ) -> Result<(Wish, bool), AskError> {
        let first = self.shared.first_epoch(&run.id, spec);
        let first = first.map_err(AskError::Origin)?;
        let asked = asked_recording(document, &spec.run_spec(), first);
        let (request, stretch) = asked.map_err(AskError::Invalid)?;
        let mut state = self.shared.state();
        let directory = self.shared.store.recordings().of(&run.id);
        let there = all(&directory);
        let number = there.last().map_or(1, |last| last.number + 1);
        let wish = Wish::new(number, &request, stretch);
        if let Some(like) = there.iter().find(|other| other.is_like(&wish)) {
            return Ok((like.clone(), false));
        }
        if there.len() >= MOST_OF_A_RUN {
            return Err(AskError::TooMany);
        }
        if state.waiting.len() >= MOST_WAITING {
            return Err(AskError::TooManyWait);
        }
        std::fs::create_dir_all(&directory)?;
        wish.write(&directory)?;
        state
            .waiting
            .push_back((run.id.clone(), Task::Record(number)));
        drop(state);
        self.shared.changed.notify_all();
        Ok((wish, true))
    }

    /// The recordings of a run.
    pub fn list(&self, run: &RunView, spec: &ResolvedRun) -> Vec<RecordingSummary> {
        let directory = self.shared.store.recordings().of(&run.id);
        let live = spec.record().and_then(|request| {
            let first = self.shared.first_epoch(&run.id, spec).unwrap_or(0);
            let stretch = Stretch::whole(&spec.run_spec()).starting_at(first);
            let wish = Wish::new(0, request, stretch);
            let paths = self.shared.store.recordings().live(&run.id);
            let (_, stage) = paths.open().ok()??;
            Some(RecordingSummary {
                name: "live".to_owned(),
                ..summary(&wish, stage.into(), None, paths.bytes())
            })
        });
        let wishes = all(&directory).into_iter();
        live.into_iter()
            .chain(wishes.map(|wish| self.summary(&run.id, &wish)))
            .collect()
    }

    /// A recording that was asked for.
    pub fn wish(&self, run: &str, number: u64) -> Option<Wish> {
        let directory = self.shared.store.recordings().of(run);
        all(&directory)
            .into_iter()
            .find(|wish| wish.number == number)
    }

    /// As it is shown.
    pub fn summary(&self, run: &str, wish: &Wish) -> RecordingSummary {
        let paths = wish.paths(&self.shared.store.recordings().of(run));
        let active = self.shared.state().active.clone();
        let active = active.filter(|active| active.is(run, Task::Record(wish.number)));
        let stage = paths.open().ok().flatten().map(|(_, stage)| stage);
        let (state, progress) = match (active, stage) {
            (Some(active), _) => (RecordingState::Recording, Some(active.progress())),
            (None, Some(Stage::Whole)) => (RecordingState::Done, None),
            (None, Some(Stage::Cut)) => (RecordingState::Cut, None),
            (None, _) if wish.reason.is_some() => (RecordingState::Cut, None),
            (None, _) => (RecordingState::Queued, None),
        };
        summary(wish, state, progress, paths.bytes())
    }

    /// Removes a recording; one that is being made is given up first.
    pub fn delete(&self, run: &str, wish: &Wish) {
        let mut state = self.shared.state();
        state
            .waiting
            .retain(|(other, task)| (other.as_str(), *task) != (run, Task::Record(wish.number)));
        let is_active = |state: &State| {
            let active = state.active.as_ref();
            active.is_some_and(|active| active.is(run, Task::Record(wish.number)))
        };
        if let Some(active) = &state.active
            && is_active(&state)
        {
            active.stop.store(true, Ordering::Relaxed);
        }
        while is_active(&state) {
            let waited = self.shared.changed.wait(state);
            state = waited.unwrap_or_else(PoisonError::into_inner);
        }
        wish.remove(&self.shared.store.recordings().of(run));
    }

    /// Why a run did what it did; asks for it where that is not known.
    ///
    /// # Errors
    /// When too much waits.
    pub fn explained(&self, run: &str) -> Result<Explained, AskError> {
        let directory = self.shared.store.recordings().of(run);
        if let Some(known) = known_explanation(&directory) {
            return Ok(match known {
                Ok(explanation) => Explained::Known(Box::new(explanation)),
                Err(reason) => Explained::Failed(reason),
            });
        }
        let mut state = self.shared.state();
        if let Some(active) = &state.active
            && active.is(run, Task::Explain)
        {
            return Ok(Explained::Pending(active.progress()));
        }
        let task = (run.to_owned(), Task::Explain);
        if !state.waiting.contains(&task) {
            if state.waiting.len() >= MOST_WAITING {
                return Err(AskError::TooManyWait);
            }
            // Before recordings: it is what somebody waits for.
            state.waiting.push_front(task);
            drop(state);
            self.shared.changed.notify_all();
        }
        Ok(Explained::Pending(0.0))
    }

    /// Ends the thread; what it was at is made anew by the next process.
    pub fn shut_down(&self) {
        {
            let mut state = self.shared.state();
            state.stopping = true;
            if let Some(active) = &state.active {
                active.stop.store(true, Ordering::Relaxed);
            }
        }
        self.shared.changed.notify_all();
        let thread = self
            .thread
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if thread.is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the thread that makes recordings panicked");
        }
    }
}

impl Active {
    fn is(&self, run: &str, task: Task) -> bool {
        self.run == run && self.task == task
    }

    /// Share of the steps that are done.
    fn progress(&self) -> f64 {
        let [done, all] = [0, 1].map(|which: usize| self.steps[which].load(Ordering::Relaxed));
        done as f64 / (all as f64).max(1.0)
    }
}

impl Drop for Maker {
    fn drop(&mut self) {
        self.shut_down();
    }
}

impl From<Stage> for RecordingState {
    fn from(stage: Stage) -> Self {
        match stage {
            Stage::Whole => RecordingState::Done,
            Stage::Part => RecordingState::Recording,
            Stage::Cut => RecordingState::Cut,
        }
    }
}

fn summary(
    wish: &Wish,
    state: RecordingState,
    progress: Option<f64>,
    bytes: u64,
) -> RecordingSummary {
    RecordingSummary {
        name: wish.number.to_string(),
        state,
        progress,
        reason: wish.reason.clone(),
        from_epoch: wish.from_epoch,
        epochs: wish.epochs,
        every_steps: wish.every_steps,
        robots: wish.robots.clone(),
        fields: wish.fields.clone(),
        bytes,
    }
}

/// What an earlier process has not made, in the order in which it was asked for.
fn left_over(store: &Store) -> VecDeque<(String, Task)> {
    let mut left = Vec::new();
    for run in store.recordings().runs() {
        let directory = store.recordings().of(&run);
        for wish in all(&directory) {
            let paths = wish.paths(&directory);
            if wish.reason.is_none() && !paths.whole.exists() && !paths.cut.exists() {
                left.push((wish.asked_ms, run.clone(), wish.number));
            }
        }
    }
    left.sort();
    left.into_iter()
        .map(|(_, run, number)| (run, Task::Record(number)))
        .collect()
}

/// Tells how many steps are done.
struct Meter(Arc<[AtomicU64; 2]>, u64);

impl Observer for Meter {
    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        self.0[0].store(run.step().saturating_sub(self.1), Ordering::Relaxed);
        Ok(())
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self) {
        let mut tidied: Option<Instant> = None;
        loop {
            if tidied.is_none_or(|last| last.elapsed() >= TIDY) {
                self.tidy();
                tidied = Some(Instant::now());
            }
            let mut state = self.state();
            if state.stopping {
                return;
            }
            let Some((run, task)) = state.waiting.pop_front() else {
                drop(self.changed.wait_timeout(state, TIDY));
                continue;
            };
            let active = Active {
                run,
                task,
                stop: Arc::default(),
                steps: Arc::default(),
            };
            state.active = Some(active.clone());
            drop(state);
            let made =
                std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| self.make(&active)));
            let made = made.unwrap_or_else(|_| Err("the simulation panicked".to_owned()));
            if let Err(why) = made {
                self.give_up(&active, why);
            }
            self.state().active = None;
            self.changed.notify_all();
            tidied = None;
        }
    }

    /// The first whole epoch of a run, where it goes on from the state of another.
    fn first_epoch(&self, run: &str, spec: &ResolvedRun) -> Result<u64, String> {
        let origin = begin_at_origin(&self.store, run, spec)?;
        Ok(origin.as_ref().map_or(0, first_whole_epoch))
    }

    /// The run at the latest moment at or before a step that it can be taken up from.
    fn run_before(
        &self,
        id: &str,
        spec: &ResolvedRun,
        directory: &Path,
        step: u64,
    ) -> Result<Run, String> {
        if let Some(snapshot) = nearest(directory, step)
            && let Ok(run) = Run::restore(spec.run_spec(), &snapshot)
        {
            return Ok(run);
        }
        self.at_beginning(id, spec)
    }

    /// The run where it begins.
    fn at_beginning(&self, id: &str, spec: &ResolvedRun) -> Result<Run, String> {
        if let Some(run) = begin_at_origin(&self.store, id, spec)? {
            return Ok(run);
        }
        Run::new(spec.run_spec()).map_err(|errors| {
            let errors: Vec<String> = errors.iter().map(|error| error.message.clone()).collect();
            errors.join("; ")
        })
    }

    fn tidy(&self) {
        let recordings = self.store.recordings();
        sweep(recordings, |run| !matches!(self.store.run(run), Ok(None)));
        keep_within(recordings, self.settings.most_bytes);
    }

    fn give_up(&self, active: &Active, why: String) {
        tracing::warn!(run = active.run, why, "no recording or explanation");
        let directory = self.store.recordings().of(&active.run);
        let Task::Record(number) = active.task else {
            keep_explanation(&directory, &Err(why));
            return;
        };
        let wish = all(&directory);
        if let Some(mut wish) = wish.into_iter().find(|wish| wish.number == number) {
            wish.reason = Some(why);
            if let Err(error) = wish.write(&directory) {
                tracing::warn!(%error, "the reason cannot be kept");
            }
        }
    }

    /// Makes one recording.
    fn make(&self, active: &Active) -> Result<(), String> {
        let view = self.store.run(&active.run).map_err(|e| e.to_string())?;
        let Some(view) = view else { return Ok(()) };
        let directory = self.store.recordings().of(&active.run);
        let spec = (self.spec_of)(&view)?;
        if view.results_version != swarm::RESULTS_VERSION {
            return Err("the run is of another version of results".to_owned());
        }
        let Task::Record(number) = active.task else {
            return self.explain(active, &directory, &spec);
        };
        let wishes = all(&directory);
        let Some(wish) = wishes.iter().find(|wish| wish.number == number) else {
            return Ok(());
        };
        let asked = asked_recording(&wish.document(), &spec.run_spec(), 0);
        let (request, stretch) = asked.map_err(|errors| format!("{errors:?}"))?;
        self.simulate(active, &directory, wish, &spec, (&request, stretch))
    }

    /// Explains a run.
    fn explain(&self, active: &Active, directory: &Path, spec: &ResolvedRun) -> Result<(), String> {
        let robots = u64::from(spec.run_spec().robots).max(1);
        active.steps[1].store(spec.robot_steps() / robots, Ordering::Relaxed);
        let stop = || active.stop.load(Ordering::Relaxed);
        let mut meter = Meter(Arc::clone(&active.steps), 0);
        let run = self.at_beginning(&active.run, spec)?;
        match explain(run, &stop, &mut meter) {
            Ok(explanation) => {
                keep_explanation(directory, &Ok(explanation));
                Ok(())
            }
            Err(ExplainError::Stopped) => Ok(()),
            Err(ExplainError::Failed(reason)) => Err(reason),
        }
    }

    fn simulate(
        &self,
        active: &Active,
        directory: &Path,
        wish: &Wish,
        spec: &ResolvedRun,
        (request, stretch): (&RecordRequest, Stretch),
    ) -> Result<(), String> {
        let steps = u64::from(spec.run_spec().steps_per_epoch);
        let [from, to] = [0, stretch.epochs].map(|e| (stretch.from_epoch + e) * steps);
        let mut run = self.run_before(&active.run, spec, directory, from)?;
        if run.step() > from {
            return Err("the run goes on from the state of another, later than that".to_owned());
        }
        let begun = run.step();
        active.steps[1].store(to - begun, Ordering::Relaxed);
        let stop = || active.stop.load(Ordering::Relaxed);
        let mut memory = MemoryBound::new(self.settings.run_memory_bytes);
        let mut meter = Meter(Arc::clone(&active.steps), begun);
        let ended = runner::step(
            &mut run,
            &stop,
            &mut [&mut memory, &mut meter, &mut PauseAt(from)],
        );
        if let runner::Ended::Failed(reason) = ended {
            return Err(reason);
        }
        if stop() {
            return Ok(());
        }
        let paths = wish.paths(directory);
        let header = header(spec, request, stretch);
        let recorder = Recorder::open(header, &paths, &run, MOST_RECORDING_BYTES);
        let mut recorder = SharedRecorder::new(Some(recorder.map_err(|e| e.to_string())?));
        let ended = runner::step(
            &mut run,
            &stop,
            &mut [&mut memory, &mut meter, &mut PauseAt(to), &mut recorder],
        );
        if let runner::Ended::Failed(reason) = ended {
            return Err(reason);
        }
        if stop() {
            drop(recorder.take());
            paths.remove();
            return Ok(());
        }
        super::start::finish(&recorder)
    }
}
