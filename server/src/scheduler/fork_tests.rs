//! Runs that go on from states, through the store and on workers.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::{Fork, State as Life};
use serde_json::{Value, json};

use super::tests::{digest, digest_alone, job, runs, start, submit, wait_for, wait_until_done};
use super::*;
use crate::store::{JobKey, RunView, Store};

fn only_run(store: &Store, job: JobKey) -> RunView {
    store.runs(job, 0, 10).unwrap().remove(0)
}

fn said(store: &Store, run: &RunView) -> Vec<String> {
    let log = store.run_log(run.seq).unwrap();
    log.into_iter().map(|entry| entry.what).collect()
}

fn changes(list: &[(&str, Value)]) -> Fork {
    let changes = list
        .iter()
        .map(|(path, value)| ((*path).to_owned(), value.clone()));
    Fork {
        epoch: None,
        changes: changes.collect(),
    }
}

#[test]
fn a_run_is_extended_from_its_end_where_that_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    for (short, long) in [(2, 5), (65, 70)] {
        for kept in [true, false] {
            let seeds = 1 + u32::from(!kept);
            let shorter = job(short, seeds);
            wait_until_done(&store, submit(&scheduler, &shorter));
            let shorter_run = &runs(&shorter)[seeds as usize - 1];
            let shorter = store.run(&shorter_run.key()).unwrap().unwrap();
            let before = store.findings(shorter.seq).unwrap().unwrap();
            if !kept {
                store.finals().remove(&shorter.id);
            }
            let made = scheduler.extend_run(&shorter, long - short).unwrap();
            wait_until_done(&store, made);
            let longer = &runs(&job(long, seeds))[seeds as usize - 1];
            assert_eq!(only_run(&store, made).id, longer.key());
            assert_eq!(digest(&store, longer), digest_alone(longer));
            let found = store.findings(only_run(&store, made).seq).unwrap().unwrap();
            let mut alone = swarm::run::Run::new(longer.run_spec()).unwrap();
            alone.advance(u64::MAX);
            assert_eq!(found, findings_of(&alone));
            // The shorter run's findings are what they were.
            let after = store.findings(shorter.seq).unwrap().unwrap();
            assert_eq!(before, after);
            let log = said(&store, &only_run(&store, made));
            let goes_on = format!("goes on from the end of run {}", shorter.id);
            assert_eq!(log.contains(&goes_on), kept, "{log:?}");
        }
    }
}

#[test]
fn a_fork_carries_its_origin_and_starts_from_there_again() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let document = json!({ "base": {
        "arena": "easy", "epochs": 1_000_000, "steps_per_epoch": 100,
        "controller": { "method": "im", "babbling_epochs": 1 } } });
    let endless = submit(&scheduler, &document);
    let origin = only_run(&store, endless);
    let begun = || {
        let view = scheduler.view(origin.seq);
        view.is_some_and(|view| view.progress.epochs_done > 2)
    };
    wait_for("some epochs", begun);
    // Taken while it runs.
    let taken = scheduler.take_checkpoint(&origin).unwrap();
    assert!(taken.epochs_done > 2 && taken.bytes > 0);
    scheduler.pause_run(&origin).unwrap();
    wait_for("the worker", || scheduler.view(origin.seq).is_none());
    let stands = scheduler.take_checkpoint(&origin).unwrap();
    assert!(stands.epochs_done >= taken.epochs_done);

    let epochs = stands.epochs_done + 3;
    let fork = changes(&[("epochs", json!(epochs)), ("controller.eta", json!(0.75))]);
    let made = scheduler.fork_run(&origin, &fork).unwrap();
    wait_until_done(&store, made);
    let forked = only_run(&store, made);
    let from = forked.origin.clone().unwrap();
    assert_eq!(from.checkpoint_sha256, stands.checkpoint_sha256);
    assert_eq!(
        (from.run.as_str(), from.uploaded),
        (origin.id.as_str(), false)
    );
    assert_eq!(
        store.findings(forked.seq).unwrap().unwrap().curve.len(),
        epochs as usize
    );
    assert!(said(&store, &forked)[0].contains(&origin.id));
    let text = store.document(made).unwrap().unwrap();
    assert!(text.contains(&stands.checkpoint_sha256), "{text}");
    // The spec alone is another run.
    let spec = crate::documents::parse(&store.spec(forked.seq).unwrap().unwrap()).unwrap();
    assert_eq!(spec["controller"]["eta"], 0.75);
    assert_ne!(runs(&json!({ "base": spec }))[0].key(), forked.id);
    // The same fork again is the same run; other changes make another.
    let again = scheduler.fork_run(&origin, &fork).unwrap();
    assert_eq!(only_run(&store, again).id, forked.id);
    let result = forked.result().unwrap().state_sha256.clone();
    // From its end a fork is extended as a fork.
    let longer = scheduler.extend_run(&forked, 2).unwrap();
    wait_until_done(&store, longer);
    let longer = only_run(&store, longer);
    assert_eq!(longer.origin.as_ref().unwrap().run, forked.id);
    assert!(
        scheduler
            .extend_job(&store.job(made).unwrap().unwrap(), 1)
            .is_err()
    );

    // Without its result it starts from its origin again, and comes to the same.
    let other = changes(&[
        ("epochs", json!(epochs + 1)),
        ("controller.eta", json!(0.75)),
    ]);
    let other = scheduler.fork_run(&origin, &other).unwrap();
    wait_until_done(&store, other);
    assert_ne!(only_run(&store, other).id, forked.id);
    for job in [made, again] {
        scheduler.delete(job).unwrap();
    }
    assert!(store.origins().read(&forked.id).unwrap().is_none());
    let once_more = scheduler.fork_run(&origin, &fork).unwrap();
    wait_until_done(&store, once_more);
    let once_more = only_run(&store, once_more);
    assert_eq!(once_more.id, forked.id);
    assert_eq!(once_more.result().unwrap().state_sha256, result);
}

#[test]
fn what_a_fork_cannot_change_is_told_where_it_stands() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let short = submit(&scheduler, &job(3, 1));
    wait_until_done(&store, short);
    let run = only_run(&store, short);
    for (path, value) in [
        ("robots", json!(2)),
        ("arena", json!("maze")),
        ("steps_per_epoch", json!(7)),
        ("controller.method", json!("im")),
        ("controller.lambda", json!(3)),
        ("nothing", json!(1)),
        ("epochs", json!(3)),
        ("epochs", json!(0)),
        ("epochs", json!("many")),
        ("controller.eta", json!(2)),
    ] {
        let refused = scheduler.fork_run(&run, &changes(&[(path, value)]));
        let Err(ControlError::Invalid(errors)) = refused else {
            panic!("{path}: {refused:?}");
        };
        assert_eq!(errors[0].pointer, format!("/changes/{path}"));
    }
    let wrong_epoch = Fork {
        epoch: Some(2),
        ..changes(&[("epochs", json!(9))])
    };
    let refused = scheduler.fork_run(&run, &wrong_epoch);
    assert!(matches!(refused, Err(ControlError::Invalid(e)) if e[0].pointer == "/epoch"));
    store.finals().remove(&run.id);
    let refused = scheduler.fork_run(&run, &changes(&[("epochs", json!(9))]));
    assert!(matches!(
        refused,
        Err(ControlError::NoCheckpoint(Life::Done))
    ));
}
