//! Observers see what they ask for, and no result depends on them.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::cell::Cell;

use serde_json::json;

use swarm::run::Progress;

use super::*;
use crate::documents::{BuiltinArenas, resolve};

fn run() -> Run {
    let spec = json!({
        "arena": "easy", "controller": { "method": "ev-iter-c", "babbling_epochs": 2,
            "train": { "arena": "easy", "epochs": 4 } },
        "epochs": 6, "steps_per_epoch": 50,
    });
    Run::new(resolve(&spec, &BuiltinArenas).unwrap().run_spec()).unwrap()
}

fn digest(run: &Run) -> String {
    run.outcome().unwrap().state_sha256
}

fn undisturbed() -> String {
    let mut run = run();
    run.advance(u64::MAX);
    digest(&run)
}

/// Wants to see every so many steps.
struct Every {
    steps: u64,
    seen: Vec<u64>,
    begun: u32,
    ended: Vec<Ended>,
}

impl Every {
    fn new(steps: u64) -> Self {
        Self {
            steps,
            seen: Vec::new(),
            begun: 0,
            ended: Vec::new(),
        }
    }

    fn wanted(&self) -> Vec<u64> {
        let wanted = |step: &u64| step.is_multiple_of(self.steps);
        self.seen.iter().copied().filter(wanted).collect()
    }
}

impl Observer for Every {
    fn begin(&mut self, _: &Run) -> Result<(), Stop> {
        self.begun += 1;
        Ok(())
    }

    fn next_step_wanted(&self, step: u64) -> Option<u64> {
        Some((step / self.steps + 1) * self.steps)
    }

    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        self.seen.push(run.step());
        Ok(())
    }

    fn end(&mut self, _: &Run, ended: &Ended) {
        self.ended.push(ended.clone());
    }
}

#[test]
fn an_observer_sees_each_step_that_it_asks_for_and_changes_nothing() {
    let (mut seven, mut three) = (Every::new(7), Every::new(3));
    let mut run = run();
    let ended = step(&mut run, &|| false, &mut [&mut seven, &mut three]);
    assert_eq!(ended, Ended::Done);
    assert_eq!(digest(&run), undisturbed());
    let last = run.step();
    for observer in [&seven, &three] {
        let all: Vec<u64> = (1..=last / observer.steps)
            .map(|number| number * observer.steps)
            .collect();
        assert_eq!(observer.wanted(), all);
        assert_eq!((observer.begun, observer.ended.len()), (1, 1));
        assert_eq!(observer.ended[0], Ended::Done);
    }
}

#[test]
fn a_run_stopped_between_blocks_goes_on_to_the_same_end() {
    let mut run = run();
    let mut ends = 0;
    loop {
        let asked = Cell::new(0);
        let stopping = || {
            asked.set(asked.get() + 1);
            asked.get() > 3
        };
        let mut every = Every::new(40);
        let ended = step(&mut run, &stopping, &mut [&mut every]);
        assert_eq!(every.ended, std::slice::from_ref(&ended));
        if ended == Ended::Done {
            break;
        }
        assert_eq!((ended, every.seen.len()), (Ended::Stopped, 3));
        ends += 1;
    }
    assert!(ends > 3, "{ends}");
    assert_eq!(digest(&run), undisturbed());
    // A run that is done is not stepped again.
    let mut every = Every::new(1);
    assert_eq!(step(&mut run, &|| true, &mut [&mut every]), Ended::Done);
    assert!(every.seen.is_empty());
}

#[test]
fn a_run_that_may_hold_nothing_fails_before_its_first_step() {
    let mut run = run();
    let (mut memory, mut every) = (MemoryBound::new(1_000), Every::new(5));
    let ended = step(&mut run, &|| false, &mut [&mut memory, &mut every]);
    assert!(
        matches!(&ended, Ended::Failed(reason) if reason.contains("may hold 1000")),
        "{ended:?}"
    );
    assert_eq!((run.step(), every.ended), (0, vec![ended]));
}

/// Lets go after the first block.
struct Once;

impl Observer for Once {
    fn after_block(&mut self, _: &Run, _: &Progress) -> Result<(), Stop> {
        Err(Stop::LetGo)
    }
}

#[test]
fn an_observer_can_let_go() {
    let mut run = run();
    let mut nobody: Option<Every> = None;
    let ended = step(&mut run, &|| false, &mut [&mut nobody, &mut Once]);
    assert_eq!((ended, run.step()), (Ended::Stopped, 1));
}

#[test]
fn threads_that_come_and_go_change_no_result() {
    let spec = json!({
        "arena": { "from": "easy", "tile": [10, 10] }, "controller": { "method": "brownian" },
        "robots": 1_100, "placement": "random", "epochs": 2, "steps_per_epoch": 150,
    });
    let run = || Run::new(resolve(&spec, &BuiltinArenas).unwrap().run_spec()).unwrap();
    let mut alone = run();
    alone.advance(u64::MAX);
    let (mut shared, asked) = (run(), Cell::new(0));
    let mut threads = Threads::new(|| {
        asked.set(asked.get() + 1);
        asked.get() % 3 + 1
    });
    let ended = step(&mut shared, &|| false, &mut [&mut threads]);
    assert_eq!(ended, Ended::Done);
    assert!(asked.get() > 3, "asked {} times", asked.get());
    assert!(threads.cpu_s() > 0.0, "other threads did nothing");
    assert_eq!(digest(&shared), digest(&alone));
}
