//! Who sees a run of a worker between two blocks of steps, and while the run waits for another
//! program: then too its progress is shown, and questions and wishes for checkpoints are answered.

use std::cell::RefCell;
use std::time::Instant;

use api::WaitsFor;
use swarm::run::{Progress, Run};

use super::live::LiveRun;
use crate::runner::{Attendant, Ended, Observer, Stop};

/// Observers that may see a run at any step boundary.
pub struct Onlookers<'a> {
    live: &'a LiveRun,
    observers: RefCell<Vec<Box<dyn Observer + 'a>>>,
}

impl<'a> Onlookers<'a> {
    /// Of this run.
    pub fn new(live: &'a LiveRun, observers: Vec<Box<dyn Observer + 'a>>) -> Self {
        Self {
            live,
            observers: RefCell::new(observers),
        }
    }

    fn each(
        &self,
        see: impl FnMut(&mut Box<dyn Observer + 'a>) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        self.observers.borrow_mut().iter_mut().try_for_each(see)
    }
}

impl Observer for &Onlookers<'_> {
    fn begin(&mut self, run: &Run) -> Result<(), Stop> {
        self.each(|observer| observer.begin(run))
    }

    fn after_block(&mut self, run: &Run, progress: &Progress) -> Result<(), Stop> {
        self.each(|observer| observer.after_block(run, progress))
    }

    fn end(&mut self, run: &Run, ended: &Ended) {
        for observer in self.observers.borrow_mut().iter_mut() {
            observer.end(run, ended);
        }
    }
}

impl Attendant for Onlookers<'_> {
    fn attend(&self, run: &Run, waits_for: WaitsFor, since: Instant) {
        self.live.waits(waits_for, since);
        let progress = run.progress();
        // Whoever stops the run does so after the block.
        drop(self.each(|observer| observer.after_block(run, &progress)));
    }

    fn goes_on(&self) {
        self.live.goes_on();
    }

    fn is_stopping(&self) -> bool {
        self.live.is_stopping()
    }
}
