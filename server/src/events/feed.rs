//! One listener: the number of the last change that it heard, and what it was last told of the rest.

use std::sync::Arc;
use std::time::Duration;

use api::Job;
use api::events::{Event, StateChange};
use tokio::time::Instant;

use super::hub::{Hub, Place, TooManyListeners};
use crate::artifacts::{curve_row, metrics_json};
use crate::findings::views;
use crate::scheduler::View;
use crate::store::{RunKey, StoreError, Subject};

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
    /// Number of the last change that was told; `None` before the first look.
    after: Option<u64>,
    job: Option<Job>,
    robot_steps: Option<u64>,
    epochs: u32,
    metrics_steps: u64,
}

impl Feed {
    /// A listener. One that comes back says the number of the last change that it heard.
    ///
    /// # Errors
    /// When there are too many.
    pub fn open(
        hub: &Arc<Hub>,
        subject: Subject,
        heard: Option<u64>,
    ) -> Result<Self, TooManyListeners> {
        let mut place = hub.place()?;
        place.newest.mark_changed();
        Ok(Self {
            state: Some(State {
                hub: Arc::clone(hub),
                subject,
                after: heard,
                job: None,
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
            if let Some(looked) = self.looked {
                tokio::select! {
                    changed = self.place.newest.changed() => changed.ok()?,
                    () = tokio::time::sleep_until(looked + PROGRESS_EVERY) => {}
                }
            }
            if self.state.as_ref()?.hub.scheduler.is_stopping() {
                return None;
            }
            let newest = *self.place.newest.borrow_and_update();
            self.looked = Some(Instant::now());
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
    /// What is new, where `newest` is the number of the newest change that is known of; `None` when
    /// the subject is gone.
    fn look(&mut self, newest: u64) -> Result<Option<Vec<Told>>, StoreError> {
        let mut told = Vec::new();
        let is_first = self.after.is_none();
        let mut is_incomplete = false;
        let mut after = match self.after {
            Some(after) => after,
            None => self.hub.store.newest_change()?,
        };
        let mut is_cut = after < newest;
        while is_cut {
            let changes = self.hub.store.changes(self.subject, after)?;
            after = changes.after;
            is_incomplete |= changes.is_incomplete;
            told.extend(changes.items.into_iter().map(|change| Told {
                id: Some(change.id),
                event: Event::State(StateChange {
                    run_id: change.run,
                    index: change.ordinal,
                    state: change.state,
                }),
            }));
            is_cut = changes.is_cut;
        }
        self.after = Some(after);
        let id = (is_first || is_incomplete).then_some(after);
        let there = match self.subject {
            Subject::Job(key) => {
                let Some(job) = self.hub.job(key)? else {
                    return Ok(None);
                };
                if id.is_some() || self.job.as_ref() != Some(&job) {
                    self.job = Some(job.clone());
                    let event = Event::Job(Box::new(job));
                    told.push(Told { id, event });
                }
                true
            }
            Subject::Run(key) => self.look_at_run(key, id, &mut told)?,
        };
        Ok(there.then_some(told))
    }

    /// Whether the run is there.
    fn look_at_run(
        &mut self,
        key: RunKey,
        id: Option<u64>,
        told: &mut Vec<Told>,
    ) -> Result<bool, StoreError> {
        let ended = told.last().is_some_and(
            |told| matches!(&told.event, Event::State(change) if change.state.is_final()),
        );
        // How it is at first, and its result at the end.
        if id.is_some() || ended {
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
