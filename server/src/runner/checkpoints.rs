//! Checkpoints on the way, at least every half minute. The run's thread takes them, a thread of
//! their own writes them: steps and views do not wait for a disk.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

use swarm::run::{Progress, Run};

use super::observer::{Ended, Observer, Stop};
use super::pace::Pace;

/// Saves a run now and then, one checkpoint at a time.
pub struct Checkpoints<T, Take> {
    pace: Pace,
    take: Take,
    write: Arc<dyn Fn(T) + Send + Sync>,
    is_asked: Box<dyn Fn() -> bool + Send>,
    /// When the last one was begun, and who writes it.
    writing: Option<(Instant, JoinHandle<()>)>,
}

impl<T, Take> Checkpoints<T, Take>
where
    T: Send + 'static,
    Take: FnMut(&Run) -> T,
{
    /// `take` copies what is to be kept; `write` keeps it and deals with its own failures: a run
    /// without a checkpoint is stepped all the same.
    pub fn new(take: Take, write: impl Fn(T) + Send + Sync + 'static) -> Self {
        Self {
            pace: Pace::every_half_minute(),
            take,
            write: Arc::new(write),
            is_asked: Box::new(|| false),
            writing: None,
        }
    }

    /// Takes one out of turn too, whenever somebody asks for it.
    #[must_use]
    pub fn also_when(mut self, is_asked: impl Fn() -> bool + Send + 'static) -> Self {
        self.is_asked = Box::new(is_asked);
        self
    }

    fn begin_one(&mut self, run: &Run, now: Instant) {
        let (taken, write) = ((self.take)(run), Arc::clone(&self.write));
        let thread = std::thread::Builder::new().name("checkpoint".to_owned());
        // The closure is lost with the thread that cannot be had: the next one is taken anew.
        match thread.spawn(move || write(taken)) {
            Ok(thread) => self.writing = Some((now, thread)),
            Err(error) => {
                tracing::warn!(%error, "no thread to write a checkpoint");
                self.pace.rest_after(now, Instant::now());
            }
        }
    }
}

impl<T, Take> Checkpoints<T, Take> {
    /// Waits until nothing is being written.
    fn wait(&mut self) {
        if let Some((start, thread)) = self.writing.take() {
            if thread.join().is_err() {
                tracing::error!("the thread that writes a checkpoint panicked");
            }
            self.pace.rest_after(start, Instant::now());
        }
    }
}

impl<T, Take> Observer for Checkpoints<T, Take>
where
    T: Send + 'static,
    Take: FnMut(&Run) -> T,
{
    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        if let Some((_, thread)) = &self.writing {
            if !thread.is_finished() {
                return Ok(());
            }
            self.wait();
        }
        let now = Instant::now();
        if (self.is_asked)() || self.pace.is_due(now) {
            self.begin_one(run, now);
        }
        Ok(())
    }

    fn end(&mut self, _: &Run, _: &Ended) {
        self.wait();
    }
}

/// Also where stepping panicked: nothing is written after its owner has gone on.
impl<T, Take> Drop for Checkpoints<T, Take> {
    fn drop(&mut self) {
        self.wait();
    }
}
