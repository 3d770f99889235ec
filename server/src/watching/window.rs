//! Between a run's thread and those who look at the run: the latest pictures, which a slow viewer
//! skips, and questions that the thread answers between two blocks.

use std::sync::{Mutex, PoisonError};

use bytes::Bytes;
use swarm::run::Run;
use tokio::sync::{oneshot, watch};

use super::{frame, learnt};

/// Most questions that wait for an answer.
const MAX_QUESTIONS: usize = 64;

/// What a robot has learnt; `None` where it learns nothing.
pub type Answer = Option<Box<api::learnt::Learnt>>;

/// What has the robot of this number learnt?
#[derive(Debug)]
struct Question {
    robot: u32,
    answer: oneshot::Sender<Answer>,
}

/// Where a run can be looked at.
#[derive(Debug, Default)]
pub struct Window {
    frames: watch::Sender<Bytes>,
    squares: watch::Sender<Bytes>,
    questions: Mutex<Vec<Question>>,
}

/// Who looks at a run.
pub struct Viewer {
    /// Robots and objects; empty before the first.
    pub frames: watch::Receiver<Bytes>,
    /// What was covered; empty before the first.
    pub squares: watch::Receiver<Bytes>,
}

impl Window {
    /// Somebody who looks from now on.
    pub fn look(&self) -> Viewer {
        Viewer {
            frames: self.frames.subscribe(),
            squares: self.squares.subscribe(),
        }
    }

    /// Asks what a robot has learnt; `None` where too many ask already.
    pub fn ask(&self, robot: u32) -> Option<oneshot::Receiver<Answer>> {
        let mut questions = self.questions();
        questions.retain(|question| !question.answer.is_closed());
        if questions.len() >= MAX_QUESTIONS {
            return None;
        }
        let (answer, answered) = oneshot::channel();
        questions.push(Question { robot, answer });
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
        for Question { robot, answer } in questions {
            let learnt = learnt::shown(run, robot, true);
            // Whoever asked may have gone.
            drop(answer.send(learnt.map(Box::new)));
        }
    }

    fn questions(&self) -> std::sync::MutexGuard<'_, Vec<Question>> {
        self.questions
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
