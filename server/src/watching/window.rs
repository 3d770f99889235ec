//! Between a run's thread and those who look at the run: the latest pictures, which a slow viewer
//! skips, and questions that the thread answers between two blocks.

use std::fmt;
use std::sync::{Mutex, PoisonError};

use bytes::Bytes;
use swarm::run::Run;
use tokio::sync::{oneshot, watch};

use super::frame;

/// Most questions that wait for an answer.
const MAX_QUESTIONS: usize = 64;

/// Something that is asked of a run.
trait Question: Send {
    /// Whether whoever asked has gone.
    fn is_gone(&self) -> bool;
    fn answer(self: Box<Self>, run: &Run);
}

struct Asked<T, L> {
    look: L,
    answer: oneshot::Sender<T>,
}

impl<T: Send, L: FnOnce(&Run) -> T + Send> Question for Asked<T, L> {
    fn is_gone(&self) -> bool {
        self.answer.is_closed()
    }

    fn answer(self: Box<Self>, run: &Run) {
        // Whoever asked may have gone.
        drop(self.answer.send((self.look)(run)));
    }
}

impl fmt::Debug for dyn Question {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Question")
    }
}

/// Where a run can be looked at.
#[derive(Debug, Default)]
pub struct Window {
    frames: watch::Sender<Bytes>,
    squares: watch::Sender<Bytes>,
    questions: Mutex<Vec<Box<dyn Question>>>,
}

/// Who looks at a run.
pub struct Viewer {
    /// Robots and objects.
    frames: watch::Receiver<Bytes>,
    /// What was covered.
    squares: watch::Receiver<Bytes>,
}

impl Viewer {
    /// The next picture; `None` when the worker has let the run go and both last ones were seen.
    pub async fn next(&mut self) -> Option<Bytes> {
        let Self { frames, squares } = self;
        tokio::select! {
            Ok(()) = squares.changed() => Some(squares.borrow_and_update().clone()),
            Ok(()) = frames.changed() => Some(frames.borrow_and_update().clone()),
            else => None,
        }
    }
}

impl Window {
    /// Somebody who looks from now on.
    pub fn look(&self) -> Viewer {
        Viewer {
            frames: self.frames.subscribe(),
            squares: self.squares.subscribe(),
        }
    }

    /// Asks what a look at the run says, between two blocks; `None` where too many ask already.
    pub fn ask<T: Send + 'static>(
        &self,
        look: impl FnOnce(&Run) -> T + Send + 'static,
    ) -> Option<oneshot::Receiver<T>> {
        let mut questions = self.questions();
        questions.retain(|question| !question.is_gone());
        if questions.len() >= MAX_QUESTIONS {
            return None;
        }
        let (answer, answered) = oneshot::channel();
        questions.push(Box::new(Asked { look, answer }));
        Some(answered)
    }

    /// Whether somebody looks.
    pub(super) fn is_watched(&self) -> bool {
        self.frames.receiver_count() > 0
    }

    pub(super) fn show(&self, run: &Run) {
        self.frames.send_replace(frame::frame(run));
    }

    pub(super) fn show_squares(&self, run: &Run) {
        self.squares.send_replace(frame::squares(run));
    }

    pub(super) fn answer(&self, run: &Run) {
        let questions = std::mem::take(&mut *self.questions());
        for question in questions {
            question.answer(run);
        }
    }

    fn questions(&self) -> std::sync::MutexGuard<'_, Vec<Box<dyn Question>>> {
        self.questions
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn both_last_pictures_of_a_run_that_is_let_go_are_seen() {
        // Which of the two is looked at first is left to chance.
        for _ in 0..64 {
            let window = Window::default();
            let mut viewer = window.look();
            window.frames.send_replace(Bytes::from_static(b"robots"));
            window.squares.send_replace(Bytes::from_static(b"squares"));
            drop(window);
            let mut seen = [viewer.next().await, viewer.next().await];
            seen.sort();
            assert_eq!(seen, [Some("robots".into()), Some("squares".into())]);
            assert_eq!(viewer.next().await, None);
        }
    }
}
