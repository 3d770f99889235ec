//! Shows a run through its window between blocks of steps, at the pace of pages.

use std::time::Duration;

use swarm::run::{Progress, Run};

use super::frame::ROBOT_BYTES;
use super::window::Window;
use crate::runner::{Ended, Observer, Pace, Stop};

/// Least time between two pictures: with blocks of 10 ms some 33 a second.
const FRAME_EVERY: Duration = Duration::from_millis(24);
/// Most bytes of robots a second.
const BYTES_PER_S: f64 = 16e6;
/// Least time between two looks at what was covered.
const SQUARES_EVERY: Duration = Duration::from_millis(500);

/// Shows a run to whoever looks.
pub struct Watched<'a> {
    window: &'a Window,
    frames: Pace,
    squares: Pace,
}

impl<'a> Watched<'a> {
    /// Through this window, a run of so many robots.
    pub fn new(window: &'a Window, robots: usize) -> Self {
        let bytes = robots.saturating_mul(ROBOT_BYTES);
        let every = Duration::from_secs_f64(bytes as f64 / BYTES_PER_S).max(FRAME_EVERY);
        Self {
            window,
            frames: Pace::watched(every),
            squares: Pace::watched(SQUARES_EVERY),
        }
    }
}

impl Observer for Watched<'_> {
    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        self.window.answer(run);
        if self.window.is_watched() {
            self.frames.when_due(|| self.window.show(run));
            self.squares.when_due(|| self.window.show_squares(run));
        }
        Ok(())
    }

    /// Where the run stands when it is let go.
    fn end(&mut self, run: &Run, _: &Ended) {
        self.window.answer(run);
        if self.window.is_watched() {
            self.window.show(run);
            self.window.show_squares(run);
        }
    }
}
