//! One listener: the number of the last change that it heard, and what it was last told of the rest.

use std::sync::Arc;
use std::time::Duration;

use api::events::{Event, JobGone, StateChange};
use api::{Job, WaitsFor};
use tokio::time::Instant;

use super::hub::{Hub, Latest, Place, TooManyListeners};
use crate::artifacts::{curve_row, metrics_json};
use crate::findings::views;
use crate::scheduler::View;
use crate::store::{Change, Changed, RunKey, StoreError, Subject};

/// Least time between two looks at progress.
const PROGRESS_EVERY: Duration = Duration::from_millis(500);

/// An event, and the number of a change of state.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// What to come back with; progress has none.
    pub id: Option<u64>,
    /// The event.
    pub event: Event,
}

impl Told {
    fn of(change: Change) -> Self {
        let event = match change.what {
            Changed::Run {
                run,
                ordinal,
                state,
            } => Event::State(StateChange {
                run_id: run,
                index: ordinal,
                state,
            }),
            Changed::JobGone(job) => Event::Gone(JobGone {
                job_id: job.to_string(),
            }),
        };
        Self {
            id: Some(change.id),
            event,
        }
    }
}

/// A listener. Its place is free again when it is dropped.
pub struct Feed {
    state: Option<State>,
    place: Place,
    looked: Option<Instant>,
}

/// What a look needs and changes.
struct State {
    hub: Arc<Hub>,
    subject: Subject,
    /// The run that a listener to all wants to hear more of, and its id.
    and_run: Option<(RunKey, String)>,
    /// Number of the last change that was told; `None` before the first look.
    after: Option<u64>,
    /// It came with a number, and has not been answered: that may be one of another database.
    comes_back: bool,
    /// More changes than one look takes in: the next look is at once.
    is_behind: bool,
    job: Option<Job>,
    /// The look at all jobs that was told last.
    all: Option<u64>,
    /// Whom the run waits for.
    waits_for: Option<WaitsFor>,
    robot_steps: Option<u64>,
    epochs: u32,
    metrics_steps: u64,
}

impl Feed {
    /// A listener. One that comes back says the number of the last change that it heard; one to all
    /// may want to hear of a run what listeners to it do.
    ///
    /// # Errors
    /// When there are too many.
    pub fn open(
        hub: &Arc<Hub>,
        subject: Subject,
        and_run: Option<(RunKey, String)>,
        heard: Option<u64>,
    ) -> Result<Self, TooManyListeners> {
        let mut place = hub.place()?;
        place.latest.mark_changed();
        Ok(Self {
            state: Some(State {
                hub: Arc::clone(hub),
                subject,
                and_run,
                after: heard,
                comes_back: heard.is_some(),
                is_behind: false,
                job: None,
                all: None,
                waits_for: None,
                robot_steps: None,
                epochs: 0,
                metrics_steps: 0,
            }),
            place,
            looked: None,
        })
    }

    /// Waits for something new. `None` when the job or run is gone, or cannot be read.
    pub async fn next(&mut self) -> Option<Vec<Told>> {
        loop {
            let is_behind = self.state.as_ref()?.is_behind;
            let mut is_due = true;
            if let Some(looked) = self.looked.filter(|_| !is_behind) {
                tokio::select! {
                    changed = self.place.latest.changed() => {
                        changed.ok()?;
                        is_due = false;
                    }
                    () = tokio::time::sleep_until(looked + PROGRESS_EVERY) => {}
                }
            }
            let state = self.state.as_mut()?;
            if state.hub.scheduler.is_stopping() {
                return None;
            }
            let latest = self.place.latest.borrow_and_update().clone();
            let newest = latest.newest;
            let is_nothing = !is_behind && state.passes(&latest);
            if is_nothing && !is_due {
                continue;
            }
            self.looked = Some(Instant::now());
            if is_nothing && let Some(told) = state.glance() {
                if told.is_empty() {
                    continue;
                }
                return Some(told);
            }
            let mut state = self.state.take()?;
            let look =
                tokio::task::spawn_blocking(move || state.look(newest).map(|told| (state, told)));
            let (state, told) = match look.await {
                Ok(Ok((state, told))) => (state, told?),
                Ok(Err(error)) => {
                    tracing::warn!(%error, "a listener is let go: its events cannot be read");
                    return None;
                }
                Err(_) => return None,
            };
            self.state = Some(state);
            if !told.is_empty() {
                return Some(told);
            }
        }
    }
}

impl State {
    /// Whether none of the latest changes is of what is listened to; they are behind it then.
    fn passes(&mut self, latest: &Latest) -> bool {
        let heard = self.after.filter(|_| !self.comes_back);
        let passed = heard.filter(|heard| latest.is_nothing_to(self.subject, *heard));
        if let Some(heard) = passed {
            self.after = Some(heard.max(latest.newest));
        }
        passed.is_some()
    }

    /// What is new where no change is, if that can be said without the store: most of those who
    /// listen to a job look at what one of them has read.
    fn glance(&mut self) -> Option<Vec<Told>> {
        let Subject::Job(key) = self.subject else {
            return None;
        };
        let job = self.hub.kept_job(key)?;
        Some(self.tell_job(job, None).into_iter().collect())
    }

    /// The job, if it is not what was told last.
    fn tell_job(&mut self, job: Job, id: Option<u64>) -> Option<Told> {
        if id.is_none() && self.job.as_ref() == Some(&job) {
            return None;
        }
        self.job = Some(job.clone());
        let event = Event::Job(Box::new(job));
        Some(Told { id, event })
    }

    /// What is new, where `newest` is the number of the newest change that is known of; `None` when
    /// the subject is gone.
    fn look(&mut self, newest: u64) -> Result<Option<Vec<Told>>, StoreError> {
        let mut told = Vec::new();
        let is_first = self.after.is_none();
        let mut is_incomplete = false;
        let mut after = match (self.after, self.subject) {
            (Some(after), _) => after,
            (None, Subject::All) => self.hub.newest_of_all()?,
            (None, _) => self.hub.store.newest_change()?,
        };
        self.is_behind = false;
        if std::mem::take(&mut self.comes_back) || after < newest {
            let changes = self.hub.store.changes(self.subject, after)?;
            after = changes.after;
            is_incomplete |= changes.is_incomplete;
            told.extend(changes.items.into_iter().map(Told::of));
            self.is_behind = changes.is_cut;
        }
        self.after = Some(after);
        let id = (is_first || is_incomplete).then_some(after);
        let there = match self.subject {
            Subject::Job(key) => {
                let Some(job) = self.hub.job(key)? else {
                    return Ok(None);
                };
                told.extend(self.tell_job(job, id));
                true
            }
            Subject::All => {
                let heard = self.all.filter(|_| id.is_none());
                let Some((mut events, look)) = self.hub.all_since(heard, after)? else {
                    return Ok(None);
                };
                // The board may be of a moment ago, when a job was there that is gone by now.
                events.retain(|event| !is_of_gone(event, &told));
                let is_first = self.all.replace(look).is_none();
                if let Some((run, run_id)) = self.and_run.clone() {
                    let is_wanted = is_first || id.is_some() || has_ended(&told, Some(&run_id));
                    self.look_at_run(run, None, is_wanted, &mut told)?;
                }
                told.extend(events.into_iter().map(|event| Told { id: None, event }));
                // Whoever comes back after that goes on behind all of them.
                if let Some(last) = told.last_mut() {
                    last.id = last.id.or(id);
                }
                true
            }
            Subject::Run(key) => {
                let is_wanted = id.is_some() || has_ended(&told, None);
                self.hub.store.has_run(key)? && self.look_at_run(key, id, is_wanted, &mut told)?
            }
        };
        Ok(there.then_some(told))
    }

    /// Whether the run is there. How it is is wanted at first, when it begins or ends to wait for
    /// another program, and its result at the end.
    fn look_at_run(
        &mut self,
        key: RunKey,
        id: Option<u64>,
        is_wanted: bool,
        told: &mut Vec<Told>,
    ) -> Result<bool, StoreError> {
        let waits_for = self.hub.scheduler.waiting(key).map(|(whom, _)| whom);
        let is_other = std::mem::replace(&mut self.waits_for, waits_for) != waits_for;
        if is_wanted || is_other {
            let Some(view) = self.hub.store.run_by_key(key)? else {
                return Ok(false);
            };
            let run = Box::new(views::run(&view, &self.hub.scheduler));
            let event = Event::Run(run);
            told.push(Told { id, event });
        }
        if let Some(view) = self.hub.scheduler.view(key) {
            self.look_at_progress(&view, told);
        }
        Ok(true)
    }

    fn look_at_progress(&mut self, view: &View, told: &mut Vec<Told>) {
        let mut tell = |event| told.push(Told { id: None, event });
        let robot_steps = Some(view.progress.robot_steps_done);
        if self.robot_steps == robot_steps {
            return;
        }
        self.robot_steps = robot_steps;
        tell(Event::Progress(views::live_progress(view)));
        if let Some(row) = view.findings.curve.last()
            && row.epoch != self.epochs
        {
            self.epochs = row.epoch;
            tell(Event::Coverage(curve_row(row)));
        }
        let log = &view.findings.metrics;
        if let Some(last) = log.rows.last()
            && last.steps != self.metrics_steps
        {
            self.metrics_steps = last.steps;
            let newest = swarm::run::MetricsLog {
                reachable: log.reachable,
                rows: vec![*last],
                ..swarm::run::MetricsLog::default()
            };
            let mut shown = metrics_json(&newest, view.step_s);
            if let Some(row) = shown.rows.pop() {
                tell(Event::Metrics(row));
            }
        }
    }
}

/// Whether an event shows a job of which is told that it is gone.
fn is_of_gone(event: &Event, told: &[Told]) -> bool {
    let Event::Job(job) = event else { return false };
    told.iter()
        .any(|told| matches!(&told.event, Event::Gone(gone) if gone.job_id == job.id))
}

/// Whether what is told is of the end of a run: of this one, or of the one that all of it is about.
fn has_ended(told: &[Told], run: Option<&str>) -> bool {
    let mut changes = told.iter().filter_map(|told| match &told.event {
        Event::State(change) if run.is_none_or(|run| run == change.run_id) => Some(change),
        _ => None,
    });
    changes
        .next_back()
        .is_some_and(|change| change.state.is_final())
}
