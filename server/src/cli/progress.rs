//! Progress of what takes long: a bar on a terminal, lines fit for a log elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use swarm::run::{Progress, Run};

use crate::runner::{Ended, Observer, Stop};

/// Time to the first line of a log ...
const LOG_FIRST: Duration = Duration::from_secs(2);
/// ... and between two lines.
const LOG_EVERY: Duration = Duration::from_secs(10);

/// Fine enough for a bar of a long job.
const PARTS: u64 = 1_000_000;

fn parts(share: f64) -> u64 {
    (share.clamp(0.0, 1.0) * PARTS as f64) as u64
}

/// Shows how far something is.
pub struct Meter {
    /// What is counted; `None` where only the share done is of interest.
    unit: Option<&'static str>,
    total: u64,
    started_at: Instant,
    started_with: u64,
    view: View,
}

enum View {
    Bar(ProgressBar),
    Log { next: Instant },
}

impl Meter {
    /// A meter of `total` units of which `done` were done before.
    pub fn new(unit: &'static str, total: u64, done: u64) -> Self {
        Self::with_unit(Some(unit), total, done)
    }

    /// A meter that shows the share done, 0 to 1, but no pace.
    pub fn of_share(done: f64) -> Self {
        Self::with_unit(None, PARTS, parts(done))
    }

    fn with_unit(unit: Option<&'static str>, total: u64, done: u64) -> Self {
        let view = if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(total)
                .with_position(done)
                .with_style(style(unit));
            bar.reset_eta();
            bar.enable_steady_tick(Duration::from_millis(250));
            View::Bar(bar)
        } else {
            View::Log {
                next: Instant::now() + LOG_FIRST,
            }
        };
        Self {
            unit,
            total,
            started_at: Instant::now(),
            started_with: done,
            view,
        }
    }

    /// Shows that a share is done, 0 to 1.
    pub fn show_share(&mut self, done: f64, what: &str) {
        self.show(parts(done), what);
    }

    /// Shows that `done` units are done; `what` says what is going on.
    pub fn show(&mut self, done: u64, what: &str) {
        let pace = self.pace(done);
        match &mut self.view {
            View::Bar(bar) => {
                bar.set_position(done);
                bar.set_message(what.to_owned());
            }
            View::Log { next } => {
                let now = Instant::now();
                if now >= *next {
                    *next = now + LOG_EVERY;
                    let percent = 100.0 * done as f64 / self.total.max(1) as f64;
                    let left_s = self.total.saturating_sub(done) as f64 / pace.max(1e-9);
                    let pace = self
                        .unit
                        .map_or(String::new(), |unit| format!(", {pace:.0} {unit}/s"));
                    let left = HumanDuration(seconds(left_s));
                    tracing::info!("{what}: {percent:.1} %{pace}, about {left} left");
                }
            }
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let View::Bar(bar) = &self.view {
            bar.finish_and_clear();
        }
    }

    /// Units a second since this meter began.
    fn pace(&self, done: u64) -> f64 {
        let fresh = done.saturating_sub(self.started_with);
        fresh as f64 / self.started_at.elapsed().as_secs_f64().max(1e-9)
    }
}

/// The robot-steps of a run.
impl Observer for Meter {
    fn after_block(&mut self, _: &Run, progress: &Progress) -> Result<(), Stop> {
        let what = format!(
            "{} {}/{}",
            progress.phase.name(),
            progress.epochs_done,
            progress.epochs_total
        );
        self.show(progress.robot_steps_done, &what);
        Ok(())
    }

    fn end(&mut self, _: &Run, _: &Ended) {
        self.finish();
    }
}

/// Seconds as a duration; a century where there is no pace to tell by.
fn seconds(seconds: f64) -> Duration {
    const CENTURY_S: f64 = 3.2e9;
    Duration::from_secs_f64(seconds.clamp(0.0, CENTURY_S))
}

fn style(unit: Option<&'static str>) -> ProgressStyle {
    #[allow(
        clippy::expect_used,
        reason = "the template is a constant: it cannot fail to parse"
    )]
    ProgressStyle::with_template("{msg} [{bar:32}] {percent:>3} %{pace}, {left} left")
        .expect("the template is valid")
        .progress_chars("=> ")
        .with_key(
            "pace",
            move |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                if let Some(unit) = unit {
                    #[allow(
                        clippy::let_underscore_must_use,
                        reason = "a bar that cannot be drawn is no reason to stop"
                    )]
                    let _ = write!(out, ", {} {unit}/s", in_thousands(state.per_sec()));
                }
            },
        )
        .with_key(
            "left",
            |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                #[allow(
                    clippy::let_underscore_must_use,
                    reason = "a bar that cannot be drawn is no reason to stop"
                )]
                let _ = write!(out, "{}", HumanDuration(state.eta()));
            },
        )
}

/// A number with a short name for its power of a thousand.
fn in_thousands(number: f64) -> String {
    match number {
        n if n >= 1e6 => format!("{:.1} M", n / 1e6),
        n if n >= 1e3 => format!("{:.1} k", n / 1e3),
        n => format!("{n:.1}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let check = |number, text| assert_eq!(in_thousands(number), text);
        check(12.34, "12.3");
        check(12_345.0, "12.3 k");
        check(7_100_000.0, "7.1 M");
    }

    #[test]
    fn an_endless_estimate_is_no_panic() {
        for length in [f64::INFINITY, f64::MAX, -1.0, 0.0] {
            seconds(length);
        }
    }
}
