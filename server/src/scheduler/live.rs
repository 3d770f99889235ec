//! What the rest of the program sees of a run while a worker steps it: the latest view, and a flag
//! to stop it by.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use api::WaitsFor;
use swarm::run::{Progress, Run};

use crate::runner::{Observer, Pace, Stop};
use crate::store::{Findings, StoreError};
use crate::watching::Window;

/// How long a run waits before it is shown to: whoever is in step with it makes it wait again and
/// again, which says nothing.
const SHOWN_AFTER: Duration = Duration::from_millis(300);

/// A run at one moment.
#[derive(Clone, Debug)]
pub struct View {
    /// How far it is.
    pub progress: Progress,
    /// Speed over about the last `MEMORY_S` seconds; `None` until it is known.
    pub robot_steps_per_s: Option<f64>,
    /// What it has covered.
    pub findings: Findings,
    /// Length of a control step, seconds.
    pub step_s: f64,
}

impl View {
    /// Seconds left at this speed.
    pub fn eta_s(&self) -> Option<f64> {
        let Progress {
            robot_steps_done,
            robot_steps_total,
            ..
        } = self.progress;
        let left = robot_steps_total.saturating_sub(robot_steps_done);
        self.robot_steps_per_s.map(|speed| left as f64 / speed)
    }
}

/// What a run has covered right now.
pub fn findings_of(run: &Run) -> Findings {
    Findings {
        curve: run.curve().to_vec(),
        visits: run.visits(),
        dwell: run.dwell(),
        metrics: run.metrics(),
        tracks: run.tracks(),
    }
}

/// Checkpoints that are asked for while a run is stepped.
#[derive(Debug, Default)]
pub struct Saves {
    asked: AtomicBool,
    written: AtomicU64,
    /// Why the last one could not be written.
    failed: Mutex<Option<StoreError>>,
}

impl Saves {
    /// Asks for one at the next step boundary.
    pub fn ask(&self) {
        self.asked.store(true, Ordering::Relaxed);
    }

    /// Whether one was asked for since this was last looked at.
    pub fn is_asked(&self) -> bool {
        self.asked.swap(false, Ordering::Relaxed)
    }

    /// One more is written, or could not be.
    pub fn is_written(&self, outcome: Result<(), StoreError>) {
        *self.failed.lock().unwrap_or_else(PoisonError::into_inner) = outcome.err();
        self.written.fetch_add(1, Ordering::Release);
    }

    /// Why the last one could not be written; whoever asks next is not told again.
    pub fn take_failure(&self) -> Option<StoreError> {
        self.failed
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take()
    }

    /// How many there were.
    pub fn written(&self) -> u64 {
        self.written.load(Ordering::Acquire)
    }
}

/// A run in the hands of a worker.
#[derive(Debug)]
pub struct LiveRun {
    begun: Instant,
    stop: Arc<AtomicBool>,
    view: Mutex<Option<Arc<View>>>,
    pace: Mutex<Option<f64>>,
    saves: Arc<Saves>,
    waits: Mutex<Option<(WaitsFor, Instant)>>,
    /// Where others can look at it.
    pub window: Window,
}

impl LiveRun {
    /// A run that is expected to do as many robot-steps a second as the one before it.
    pub fn new(pace: Option<f64>) -> Self {
        Self {
            begun: Instant::now(),
            stop: Arc::default(),
            view: Mutex::default(),
            pace: Mutex::new(pace),
            saves: Arc::default(),
            waits: Mutex::default(),
            window: Window::default(),
        }
    }

    /// When the worker took it.
    pub fn begun(&self) -> Instant {
        self.begun
    }

    /// Robot-steps a second: those of the run before this one, and at its end its own.
    pub fn pace(&self) -> Option<f64> {
        *self.pace.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says how many robot-steps a second the run did, its preparation included.
    pub fn set_pace(&self, pace: f64) {
        *self.pace.lock().unwrap_or_else(PoisonError::into_inner) = Some(pace);
    }

    /// Whom it waits for, and since when, once it has waited for so long that it says something.
    pub fn waiting(&self) -> Option<(WaitsFor, Instant)> {
        let waits = *self.waits.lock().unwrap_or_else(PoisonError::into_inner);
        waits.filter(|(_, since)| since.elapsed() >= SHOWN_AFTER)
    }

    /// Says that it has waited since then.
    pub fn waits(&self, waits_for: WaitsFor, since: Instant) {
        *self.waits.lock().unwrap_or_else(PoisonError::into_inner) = Some((waits_for, since));
    }

    /// Says that it waits no longer.
    pub fn goes_on(&self) {
        *self.waits.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Checkpoints that are asked for.
    pub fn saves(&self) -> &Arc<Saves> {
        &self.saves
    }

    /// Asks the worker to let go of the run after the present block of steps.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Becomes true when the worker is asked to let go.
    pub fn stop_flag(&self) -> &Arc<AtomicBool> {
        &self.stop
    }

    /// Whether the worker was asked to let go.
    pub fn is_stopping(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The latest view; `None` before the first.
    pub fn view(&self) -> Option<Arc<View>> {
        self.view
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// Replaces the view.
    pub fn publish(&self, view: View) {
        let view = Some(Arc::new(view));
        *self.view.lock().unwrap_or_else(PoisonError::into_inner) = view;
    }
}

/// Shows a run to the rest of the program, at least every second.
pub struct Views<'a> {
    live: &'a LiveRun,
    speed: Speed,
    pace: Pace,
}

impl<'a> Views<'a> {
    /// Views of a run that has done so many robot-steps.
    pub fn new(live: &'a LiveRun, robot_steps_done: u64) -> Self {
        Self {
            live,
            speed: Speed::new(robot_steps_done),
            pace: Pace::every_second(),
        }
    }
}

impl Observer for Views<'_> {
    fn after_block(&mut self, run: &Run, progress: &Progress) -> Result<(), Stop> {
        let Self { live, speed, pace } = self;
        pace.when_due(|| {
            let measured = speed.update(Instant::now(), progress.robot_steps_done);
            live.publish(View {
                progress: *progress,
                robot_steps_per_s: measured.or(live.pace()),
                findings: findings_of(run),
                step_s: run.spec().robot.parameters.step_s,
            });
        });
        Ok(())
    }
}

/// Time over which a speed is averaged, in seconds.
pub const MEMORY_S: f64 = 5.0;

/// Shortest time that a speed is measured over, in seconds.
const SAMPLE_S: f64 = 0.1;

/// Robot-steps a second as an exponential average over [`MEMORY_S`].
#[derive(Debug)]
pub struct Speed {
    at: Instant,
    robot_steps_done: u64,
    average: Option<f64>,
}

impl Speed {
    /// Starts to measure at this many robot-steps.
    pub fn new(robot_steps_done: u64) -> Self {
        Self {
            at: Instant::now(),
            robot_steps_done,
            average: None,
        }
    }

    /// Takes in how far the run is now. Returns the speed, `None` until there is one above zero.
    pub fn update(&mut self, now: Instant, robot_steps_done: u64) -> Option<f64> {
        let elapsed_s = now.saturating_duration_since(self.at).as_secs_f64();
        let steps = robot_steps_done.saturating_sub(self.robot_steps_done);
        if elapsed_s >= SAMPLE_S && steps > 0 {
            let speed = steps as f64 / elapsed_s;
            let weight = 1.0 - (-elapsed_s / MEMORY_S).exp();
            let average = self
                .average
                .map_or(speed, |old| old + weight * (speed - old));
            *self = Self {
                at: now,
                robot_steps_done,
                average: Some(average),
            };
        }
        self.average
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_wait_is_shown_once_it_lasts() {
        let live = LiveRun::new(None);
        let now = Instant::now();
        live.waits(WaitsFor::Controllers, now);
        assert_eq!(live.waiting(), None);
        let since = now.checked_sub(SHOWN_AFTER).unwrap();
        live.waits(WaitsFor::Controllers, since);
        assert_eq!(live.waiting(), Some((WaitsFor::Controllers, since)));
        live.goes_on();
        assert_eq!(live.waiting(), None);
    }

    #[test]
    fn speed_follows_the_run() {
        let mut speed = Speed::new(1_000);
        let start = speed.at;
        assert_eq!(speed.update(start + Duration::from_secs(1), 1_000), None);
        assert_eq!(
            speed.update(start + Duration::from_secs(2), 3_000),
            Some(1_000.0)
        );
        for second in 3..60 {
            speed.update(
                start + Duration::from_secs(second),
                3_000 + (second - 2) * 500,
            );
        }
        let settled = speed
            .update(start + Duration::from_secs(60), 3_000 + 58 * 500)
            .unwrap();
        assert!((settled - 500.0).abs() < 1.0, "{settled}");
    }
}
