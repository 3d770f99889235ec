//! What can be asked of jobs and runs from outside, in every state, and what comes of it.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::State as Life;
use serde_json::{Value, json};

use super::tests::{job, runs, start, start_with, submit, wait_for, wait_until_done};
use super::*;
use crate::documents::{BuiltinArenas, expand};
use crate::recording::Limits;
use crate::store::{Created, Intent, JobKey, JobRequest, RunView, Store};

/// A job without end of one run, begun; its run.
fn begun(store: &Store, scheduler: &Scheduler) -> (JobKey, RunView) {
    let endless = job(1_000_000, 1);
    let submitted = submit(scheduler, &endless);
    let id = runs(&endless)[0].key();
    let find = || store.run(&id).unwrap().unwrap();
    wait_for("a view", || scheduler.view(find().seq).is_some());
    (submitted, find())
}

fn life(store: &Store, run: &RunView) -> Life {
    store.run(&run.id).unwrap().unwrap().state.state()
}

fn robot_steps(store: &Store, run: &RunView) -> u64 {
    store.robot_steps_done(run.seq).unwrap().unwrap()
}

#[test]
fn a_run_is_paused_stepped_by_epochs_and_resumed_alone() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let (job, run) = begun(&store, &scheduler);
    assert!(matches!(
        scheduler.step_run(&run, 1),
        Err(ControlError::Running)
    ));
    scheduler.pause_run(&run).unwrap();
    scheduler.pause_run(&run).unwrap();
    wait_for("the worker", || scheduler.view(run.seq).is_none());
    assert_eq!(life(&store, &run), Life::Paused);
    let view = store.job(job).unwrap().unwrap();
    assert_eq!(view.intent.job_state(&view.counts), Life::Paused);

    // It stands in an epoch of 500 steps, which is the first of those that are asked for.
    let mut stood = robot_steps(&store, &run);
    for epochs in [1, 3] {
        let paused = store.run(&run.id).unwrap().unwrap();
        scheduler.step_run(&paused, epochs).unwrap();
        wait_for("the steps", || {
            life(&store, &run) == Life::Paused && scheduler.view(run.seq).is_none()
        });
        let stands = robot_steps(&store, &run);
        assert_eq!(stands, (stood / 500 + u64::from(epochs)) * 500);
        stood = stands;
    }
    // Paused it stays, over the end of the process too.
    drop(scheduler);
    drop(store);
    let (store, scheduler) = start(dir.path(), 1);
    assert_eq!(
        (life(&store, &run), robot_steps(&store, &run)),
        (Life::Paused, stood)
    );
    scheduler.resume_run(&run).unwrap();
    wait_for("a view", || {
        (scheduler.view(run.seq)).is_some_and(|view| view.progress.robot_steps_done > stood)
    });
    let log = store.run_log(run.seq).unwrap();
    let said: Vec<&str> = log.iter().map(|entry| entry.what.as_str()).collect();
    let reached = "paused after the steps asked for";
    assert_eq!(
        said,
        [
            "paused",
            "steps 1 epochs",
            reached,
            "steps 3 epochs",
            reached,
            "resumed"
        ]
    );
    assert_eq!(log[5].robot_steps_done, Some(stood));

    scheduler.cancel_run(run.seq).unwrap();
    for refused in [
        scheduler.pause_run(&run),
        scheduler.resume_run(&run),
        scheduler.step_run(&store.run(&run.id).unwrap().unwrap(), 1),
    ] {
        assert!(
            matches!(refused, Err(ControlError::Ended("run", Life::Cancelled))),
            "{refused:?}"
        );
    }
}

#[test]
fn a_job_that_is_resumed_takes_the_runs_with_it_that_were_paused_alone() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let (job, run) = begun(&store, &scheduler);
    scheduler.pause_run(&run).unwrap();
    let view = store.job(job).unwrap().unwrap();
    scheduler.want(&view, Intent::Paused).unwrap();
    // Its job holds it now too.
    assert!(matches!(
        scheduler.resume_run(&run),
        Err(ControlError::NotWanted(Life::Paused))
    ));
    let view = store.job(job).unwrap().unwrap();
    scheduler.want(&view, Intent::Active).unwrap();
    wait_for("the run", || life(&store, &run) == Life::Running);
}

#[test]
fn what_is_done_is_neither_resumed_nor_tried_again() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let submitted = submit(&scheduler, &job(1, 1));
    wait_until_done(&store, submitted);
    let view = store.job(submitted).unwrap().unwrap();
    for refused in [
        scheduler.want(&view, Intent::Active),
        scheduler.want(&view, Intent::Paused),
        scheduler.want(&view, Intent::Cancelled),
        scheduler.try_again(&view),
    ] {
        assert!(
            matches!(refused, Err(ControlError::Ended("job", Life::Done))),
            "{refused:?}"
        );
    }
    let run = store.all_runs(submitted).unwrap().remove(0);
    for refused in [scheduler.resume_run(&run), scheduler.retry_run(&run)] {
        assert!(
            matches!(refused, Err(ControlError::Ended("run", Life::Done))),
            "{refused:?}"
        );
    }
}

#[test]
fn a_cancelled_run_is_tried_again_where_its_job_wants_it() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let (job, run) = begun(&store, &scheduler);
    assert!(matches!(
        scheduler.retry_run(&run),
        Err(ControlError::NotEnded("run", _))
    ));
    scheduler.cancel_run(run.seq).unwrap();
    let cancelled = store.run(&run.id).unwrap().unwrap();
    scheduler.retry_run(&cancelled).unwrap();
    wait_for("the run", || life(&store, &run) == Life::Running);
    scheduler
        .want(&store.job(job).unwrap().unwrap(), Intent::Cancelled)
        .unwrap();
    let cancelled = store.run(&run.id).unwrap().unwrap();
    assert!(matches!(
        scheduler.retry_run(&cancelled),
        Err(ControlError::NotWanted(Life::Cancelled))
    ));
    scheduler.delete_run(run.seq).unwrap();
    assert!(store.run(&run.id).unwrap().is_none());
    assert_eq!(store.job(job).unwrap().unwrap().counts.total, 0);
}

#[test]
fn a_job_grows_by_seeds_and_what_it_had_stays() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 2);
    let document = json!({
        "base": job(2, 1)["base"], "matrix": { "epochs": [1, 2] }, "seeds": { "first": 1, "count": 2 },
    });
    let expanded = expand(&document, &BuiltinArenas).unwrap();
    let request = JobRequest::of_document(document.to_string().as_bytes(), None);
    let made = scheduler.new_job(expanded, request).unwrap();
    let (Created::New(seq, _) | Created::Replayed(seq)) = scheduler.submit(&made).unwrap();
    wait_until_done(&store, seq);
    let before = store.all_runs(seq).unwrap();
    let view = store.job(seq).unwrap().unwrap();
    assert_eq!(scheduler.extend_job(&view, 3).unwrap(), 6);
    wait_for("more runs", || {
        store.job(seq).unwrap().unwrap().counts.total == 10
    });
    wait_until_done(&store, seq);
    let after = store.all_runs(seq).unwrap();
    assert_eq!(after[..4], before);
    let seeds: std::collections::BTreeSet<u64> = after.iter().map(|run| run.seed).collect();
    assert_eq!(seeds, (1..=5).collect());
    assert_eq!(after[9].label, before[3].label);
    // As if it had been posted so.
    let longer: Value = serde_json::from_str(&store.document(seq).unwrap().unwrap()).unwrap();
    assert_eq!(longer["seeds"]["count"], 5);
    // A job of a version that kept no documents.
    let old = submit(&scheduler, &job(3, 1));
    let old = store.job(old).unwrap().unwrap();
    assert!(matches!(
        scheduler.extend_job(&old, 1),
        Err(ControlError::NoDocument)
    ));
}

/// Extending simulates anew: the first epochs of the longer run must be those of the shorter.
#[test]
fn a_run_with_more_epochs_begins_as_the_one_with_fewer() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 2);
    // All but the one that waits for a program outside.
    let methods: Vec<&str> = swarm::spec::Method::ALL
        .iter()
        .filter(|&&method| method != swarm::spec::Method::External)
        .map(|method| method.name())
        .collect();
    let document = json!({
        "base": { "arena": "maze", "epochs": 3, "steps_per_epoch": 60 },
        "matrix": { "controller.method": methods },
    });
    let submitted = submit(&scheduler, &document);
    wait_until_done(&store, submitted);
    for run in store.all_runs(submitted).unwrap() {
        let longer = scheduler.extend_run(&run, 2).unwrap();
        wait_until_done(&store, longer);
        let long = store.all_runs(longer).unwrap().remove(0);
        assert_eq!((long.epochs_total, long.seed), (5, run.seed));
        let (short, long) = (
            store.findings(run.seq).unwrap().unwrap(),
            store.findings(long.seq).unwrap().unwrap(),
        );
        assert_eq!((short.curve.len(), long.curve.len()), (3, 5));
        assert_eq!(short.curve[..], long.curve[..3], "{}", run.method);
    }
}

#[test]
fn a_job_of_higher_priority_comes_first() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let (blocking, _) = begun(&store, &scheduler);
    let [early, late] = [job(100_000, 3), job(4, 3)].map(|job| submit(&scheduler, &job));
    scheduler.set_priority(late, 1).unwrap();
    assert_eq!(store.job(late).unwrap().unwrap().priority, 1);
    scheduler.set_intent(blocking, Intent::Cancelled).unwrap();
    wait_until_done(&store, late);
    assert_eq!(store.job(early).unwrap().unwrap().counts.done, 0);
}

#[test]
fn no_job_is_stored_whose_recordings_would_not_fit_however_many_ask_at_once() {
    let mut document = job(20, 1);
    document["base"]["record"] = json!({ "every_steps": 1 });
    let run = &runs(&document)[0];
    let one = run.record().unwrap().about_bytes(&run.run_spec(), 20);
    let limits = Limits {
        job_bytes: one * 5 / 2,
        ..Limits::DEFAULT
    };
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start_with(dir.path(), 1, limits);
    let made = |count: u32| {
        let mut document = document.clone();
        document["seeds"]["count"] = json!(count);
        let expanded = expand(&document, &BuiltinArenas).unwrap();
        let request = JobRequest::of_document(document.to_string().as_bytes(), None);
        scheduler.new_job(expanded, request)
    };
    assert!(matches!(made(3), Err(ControlError::Invalid(_))));
    let (Created::New(seq, _) | Created::Replayed(seq)) =
        scheduler.submit(&made(1).unwrap()).unwrap();
    let view = store.job(seq).unwrap().unwrap();
    // One more run fits, two do not.
    let extended = std::thread::scope(|scope| {
        let both = [(); 2].map(|()| scope.spawn(|| scheduler.extend_job(&view, 1)));
        both.map(|one| one.join().unwrap())
    });
    let (done, refused): (Vec<_>, Vec<_>) = extended.into_iter().partition(Result::is_ok);
    assert_eq!((done.len(), refused.len()), (1, 1));
    let Err(ControlError::Invalid(errors)) = &refused[0] else {
        panic!("{refused:?}");
    };
    assert_eq!(errors[0].pointer, "/base/record");
    assert_eq!(store.job(seq).unwrap().unwrap().counts.total, 2);
}

/// A run or a job that was deleted after the request had found it is unknown, whatever is asked.
#[test]
fn what_was_deleted_meanwhile_is_told_as_unknown() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let (job, run) = begun(&store, &scheduler);
    scheduler.pause_run(&run).unwrap();
    wait_for("the worker", || scheduler.view(run.seq).is_none());
    let paused = store.run(&run.id).unwrap().unwrap();
    scheduler.cancel_run(run.seq).unwrap();
    let cancelled = store.run(&run.id).unwrap().unwrap();
    scheduler.delete_run(run.seq).unwrap();
    let fork = api::Fork {
        epoch: None,
        changes: Default::default(),
    };
    for (what, refused) in [
        ("pause", scheduler.pause_run(&paused)),
        ("resume", scheduler.resume_run(&paused)),
        // Deleted between the look at its state and the change.
        ("release", scheduler.release(&paused, None, "resumed")),
        ("step", scheduler.step_run(&paused, 1)),
        ("retry", scheduler.retry_run(&cancelled)),
        ("extend", scheduler.extend_run(&paused, 1).map(drop)),
        ("fork", scheduler.fork_run(&paused, &fork).map(drop)),
        ("checkpoint", scheduler.take_checkpoint(&paused).map(drop)),
    ] {
        assert!(
            matches!(&refused, Err(ControlError::RunGone(id)) if *id == run.id),
            "{what}: {refused:?}"
        );
    }
    assert_eq!(store.release(run.seq, None, "resumed").unwrap(), None);
    assert_eq!(store.robot_steps_done(run.seq).unwrap(), None);

    let view = store.job(job).unwrap().unwrap();
    scheduler.delete(job).unwrap();
    for refused in [
        scheduler.extend_job(&view, 1).map(drop),
        scheduler.set_priority(job, 3),
    ] {
        assert!(
            matches!(refused, Err(ControlError::JobGone(gone)) if gone == job),
            "{refused:?}"
        );
    }
}
