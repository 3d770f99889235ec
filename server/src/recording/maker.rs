//! Recordings that are asked for afterwards: the run is stepped again in the background, one at a
//! time, from the nearest checkpoint that was kept or from its beginning. The same thread sees to it
//! that recordings do not take too much room, and that none outlives its run.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use api::State;
use api::explanation::Explanation;
use api::recording::{RecordingState, RecordingSummary};
use swarm::spec::Method;

use super::explained::known_explanation;
use super::limits::Limits;
use super::origin::{begin_at_origin, first_whole_epoch};
use super::paths::Stage;
use super::room::bytes_of;
use super::wish::{Wish, all};
use crate::documents::{ResolvedRun, Stretch, asked_recording};
use crate::explain::NOT_STEPPED_AGAIN;
use crate::store::{JobKey, RunKey, RunView, Store};

/// Most recordings that wait.
pub const MOST_WAITING: usize = 64;
/// Most recordings of one run.
pub const MOST_OF_A_RUN: usize = 100;

/// Resolves the stored spec of a run.
pub type SpecOf = Box<dyn Fn(&RunView) -> Result<ResolvedRun, String> + Send + Sync>;

/// Makes recordings.
pub struct Maker {
    shared: Arc<Shared>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

pub(super) struct Shared {
    pub store: Arc<Store>,
    pub spec_of: SpecOf,
    pub settings: Settings,
    state: Mutex<Todo>,
    pub changed: Condvar,
}

/// What recordings may take.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Bytes of recordings.
    pub limits: Limits,
    /// Bytes that a run may hold while it is stepped again.
    pub run_memory_bytes: u64,
}

#[derive(Default)]
pub(super) struct Todo {
    pub waiting: VecDeque<(String, Task)>,
    /// Runs that are explained when nothing waits.
    pub later: VecDeque<String>,
    pub active: Option<Active>,
    pub stopping: bool,
}

#[derive(Clone)]
pub(super) struct Active {
    pub run: String,
    pub task: Task,
    pub stop: Arc<AtomicBool>,
    /// Steps done and in all.
    pub steps: Arc<[AtomicU64; 2]>,
}

/// What is to be done with a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
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
    /// The run cannot be stepped again.
    #[error("{0}")]
    NotRepeatable(&'static str),
    /// The run is not done.
    #[error("the run is {0}: it is explained when it is done")]
    NotDone(State),
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
            state: Mutex::new(Todo {
                waiting,
                ..Todo::default()
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
        can_be_repeated(run, spec)?;
        let run_spec = spec.run_spec();
        let asked = asked_recording(document, &run_spec, first);
        let (request, stretch) = asked.map_err(AskError::Invalid)?;
        let of_jobs = self.shared.bytes_of_jobs(run.seq);
        let mut state = self.shared.state();
        let directory = self.shared.store.recordings().of(&run.id);
        let there = all(&directory);
        let number = there.last().map_or(1, |last| last.number + 1);
        let about_bytes = request.about_bytes(&run_spec, stretch.epochs);
        let wish = Wish::new(number, &request, stretch, about_bytes);
        if let Some(like) = there.iter().find(|other| other.is_like(&wish)) {
            return Ok((like.clone(), false));
        }
        if there.len() >= MOST_OF_A_RUN {
            return Err(AskError::TooMany);
        }
        if state.waiting.len() >= MOST_WAITING {
            return Err(AskError::TooManyWait);
        }
        let limits = &self.shared.settings.limits;
        let of_run = bytes_of(&directory) + self.shared.still_to_come(run, spec);
        for (most_bytes, whose) in [
            (limits.of_one(), "that a recording may take here".to_owned()),
            (
                limits.of_a_run().saturating_sub(of_run),
                left("the run", limits.of_a_run(), of_run),
            ),
            (
                limits.of_a_job().saturating_sub(of_jobs),
                left("the run's job", limits.of_a_job(), of_jobs),
            ),
        ] {
            let fits = request.check_size(&run_spec, stretch.epochs, most_bytes, &whose);
            fits.map_err(|mut error| {
                error.pointer.clear();
                AskError::Invalid(vec![error])
            })?;
        }
        std::fs::create_dir_all(&directory)?;
        // Of one whose wish was lost.
        wish.paths(&directory).remove();
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
            let wish = Wish::new(0, request, stretch, 0);
            let paths = self.shared.store.recordings().live(&run.id);
            let (_, stage) = paths.open().ok()??;
            Some(RecordingSummary {
                name: "live".to_owned(),
                ..summary(&wish, live_state(run, stage), None, paths.bytes())
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
        let is_active = |state: &Todo| {
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
    /// When the run is not done or cannot be stepped again, or too much waits.
    pub fn explained(&self, run: &RunView, spec: &ResolvedRun) -> Result<Explained, AskError> {
        let (life, id) = (run.state.state(), run.id.as_str());
        let directory = self.shared.store.recordings().of(id);
        if let Some(known) = known_explanation(&directory) {
            return Ok(match known {
                Ok(explanation) => Explained::Known(Box::new(explanation)),
                Err(reason) => Explained::Failed(reason),
            });
        }
        can_be_repeated(run, spec)?;
        if life != State::Done {
            return Err(AskError::NotDone(life));
        }
        let mut state = self.shared.state();
        if let Some(active) = &state.active
            && active.is(id, Task::Explain)
        {
            return Ok(Explained::Pending(active.progress()));
        }
        let task = (id.to_owned(), Task::Explain);
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

    /// Explains a run when nothing else is to be made, if it is not explained yet and takes no more
    /// than so many robot-steps.
    pub fn explain_later(&self, run: &RunView, spec: &ResolvedRun, most_robot_steps: u64) {
        let directory = self.shared.store.recordings().of(&run.id);
        if run.state.state() != State::Done
            || spec.robot_steps() > most_robot_steps
            || can_be_repeated(run, spec).is_err()
            || known_explanation(&directory).is_some()
        {
            return;
        }
        let mut state = self.shared.state();
        let is_there = state.later.contains(&run.id);
        if !is_there && state.later.len() < MOST_WAITING {
            state.later.push_back(run.id.clone());
            drop(state);
            self.shared.changed.notify_all();
        }
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
    pub fn is(&self, run: &str, task: Task) -> bool {
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

/// Whether a run can be stepped again.
fn can_be_repeated(run: &RunView, spec: &ResolvedRun) -> Result<(), AskError> {
    if spec.method() == Method::External {
        return Err(AskError::NotRepeatable(NOT_STEPPED_AGAIN));
    }
    if run.results_version != swarm::RESULTS_VERSION {
        return Err(AskError::NotRepeatable(
            "the run is of another version of results: this one would step another run",
        ));
    }
    Ok(())
}

/// How much room there is for `whose` recordings.
fn left(whose: &str, most_bytes: u64, bytes: u64) -> String {
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    format!(
        "that are left: recordings of {whose} may take {:.1} MiB and take {:.1} MiB",
        mib(most_bytes),
        mib(bytes)
    )
}

/// How far what a run records of itself has come.
pub fn live_state(run: &RunView, stage: Stage) -> RecordingState {
    match (stage, run.state.state().is_final()) {
        // It failed, or was cancelled.
        (Stage::Part, true) => RecordingState::Cut,
        _ => stage.into(),
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
            if !wish.has_ended(&directory) {
                left.push((wish.asked_ms, run.clone(), wish.number));
            }
        }
    }
    left.sort();
    left.into_iter()
        .map(|(_, run, number)| (run, Task::Record(number)))
        .collect()
}

impl Shared {
    pub fn state(&self) -> MutexGuard<'_, Todo> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The first whole epoch of a run, where it goes on from the state of another.
    fn first_epoch(&self, run: &str, spec: &ResolvedRun) -> Result<u64, String> {
        let origin = begin_at_origin(&self.store, run, spec)?;
        Ok(origin.as_ref().map_or(0, first_whole_epoch))
    }

    /// Bytes of the recordings of the fullest job that has a run.
    fn bytes_of_jobs(&self, run: RunKey) -> u64 {
        let jobs = self.store.jobs_of(run).unwrap_or_default();
        let by_job = self.runs_by_job();
        let of_job = |job| by_job.get(job).into_iter().flatten();
        let recordings = self.store.recordings();
        let bytes = |job| of_job(job).map(|run| bytes_of(&recordings.of(run))).sum();
        jobs.iter().map(bytes).max().unwrap_or(0)
    }

    /// The runs that have recordings, by their jobs.
    pub fn runs_by_job(&self) -> BTreeMap<JobKey, Vec<String>> {
        let mut by_job: BTreeMap<JobKey, Vec<String>> = BTreeMap::new();
        for id in self.store.recordings().runs() {
            // One that cannot be read counts in all alone.
            let Ok(Some(run)) = self.store.run(&id) else {
                continue;
            };
            for job in self.store.jobs_of(run.seq).unwrap_or_default() {
                by_job.entry(job).or_default().push(id.clone());
            }
        }
        by_job
    }

    /// About how many bytes a run is still to record of itself.
    fn still_to_come(&self, run: &RunView, spec: &ResolvedRun) -> u64 {
        if run.state.state().is_final() {
            return 0;
        }
        let run_spec = spec.run_spec();
        let epochs = Stretch::whole(&run_spec).epochs;
        let about = spec
            .record()
            .map_or(0, |r| r.about_bytes(&run_spec, epochs));
        about.saturating_sub(self.store.recordings().live(&run.id).bytes())
    }
}
