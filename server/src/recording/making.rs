//! The thread that makes recordings and explanations, one at a time: steps runs again, from the
//! nearest checkpoint that was kept or from their beginning, and sees to it that recordings do not
//! take too much room, and that none outlives its run.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use swarm::run::{Progress, Run};

use super::explained::{keep_explanation, known_explanation};
use super::kept::nearest;
use super::maker::{Active, Shared, Task};
use super::origin::begin_at_origin;
use super::recorder::{Recorder, SharedRecorder};
use super::room::{bytes_of, keep_within, sweep};
use super::subject::header;
use super::wish::{Wish, all};
use crate::documents::{RecordRequest, ResolvedRun, Stretch, asked_recording};
use crate::explain::{ExplainError, explain};
use crate::runner::{self, MemoryBound, Observer, PauseAt, Stop};

/// How often room is looked after.
const TIDY: Duration = Duration::from_secs(20);

/// Tells how many steps are done.
struct Meter(Arc<[AtomicU64; 2]>, u64);

impl Observer for Meter {
    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        self.0[0].store(run.step().saturating_sub(self.1), Ordering::Relaxed);
        Ok(())
    }
}

impl Shared {
    pub fn work(&self) {
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
            let next = state.waiting.pop_front();
            let later = |run| (run, Task::Explain);
            let Some((run, task)) = next.or_else(|| state.later.pop_front().map(later)) else {
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
        let limits = &self.settings.limits;
        for runs in self.runs_by_job().values() {
            keep_within(recordings, runs, limits.of_a_job());
        }
        keep_within(recordings, &recordings.runs(), limits.all_bytes);
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
        if known_explanation(directory).is_some() {
            return Ok(());
        }
        let robots = u64::from(spec.run_spec().robots).max(1);
        active.steps[1].store(spec.robot_steps() / robots, Ordering::Relaxed);
        let stop = || active.stop.load(Ordering::Relaxed);
        let mut meter = Meter(Arc::clone(&active.steps), 0);
        let mut memory = MemoryBound::new(self.settings.run_memory_bytes);
        let run = self.at_beginning(&active.run, spec)?;
        match explain(run, &stop, &mut [&mut memory, &mut meter]) {
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
        let limits = &self.settings.limits;
        let others = bytes_of(directory).saturating_sub(wish.about_bytes);
        let most_bytes = limits
            .of_one()
            .min(limits.of_a_run().saturating_sub(others));
        let recorder = Recorder::open(header, &paths, &run, most_bytes);
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
