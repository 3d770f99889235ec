//! Jobs and their runs: stored once, shared, listed, ended.

use super::*;

#[test]
fn what_ran_when_the_process_died_waits_again_in_order() {
    let dir = tempfile::tempdir().unwrap();
    let (one, two, waiting) = {
        let store = open(dir.path());
        let (one, waiting) = create(&store, &["a", "b"]);
        let (two, _) = create(&store, &["b", "c"]);
        let claimed = store.claim(waiting[0]).unwrap().unwrap();
        assert_eq!(
            (claimed.id.as_str(), claimed.spec.as_str()),
            ("a", "{\"of\": \"a\"}")
        );
        assert_eq!(store.claim(waiting[0]).unwrap(), None);
        let checkpoint = Checkpoint {
            findings: Findings::default(),
            snapshot: vec![1, 2, 3],
        };
        store.checkpoints().write("a", &checkpoint).unwrap();
        store.checkpoints().write("nobody's", &checkpoint).unwrap();
        (one, two, waiting)
    };
    let store = open(dir.path());
    let found = store.recover().unwrap();
    let c = store.run("c").unwrap().unwrap().seq;
    let expected = [
        (one, waiting[0]),
        (one, waiting[1]),
        (two, waiting[1]),
        (two, c),
    ];
    assert_eq!(found, expected);
    assert!(store.checkpoints().read("a").unwrap().is_some());
    assert!(store.checkpoints().read("nobody's").unwrap().is_none());
}

#[test]
fn a_repeated_request_is_answered_with_the_first_job() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let keyed = NewJob {
        request: JobRequest::new(b"a", Some("key".to_owned())),
        ..new_job(&["a"])
    };
    let Created::New(first, _) = store.create_job(&keyed, 1_000).unwrap() else {
        panic!("the key is new");
    };
    assert_eq!(
        store.create_job(&keyed, 1_000).unwrap(),
        Created::Replayed(first)
    );
    // Also where there is no room for another job.
    assert_eq!(store.admit(&keyed.request, 1, 0).unwrap(), Some(first));
    let other = NewJob {
        request: JobRequest::new(b"b", Some("key".to_owned())),
        ..new_job(&["b"])
    };
    assert!(matches!(
        store.create_job(&other, 1_000),
        Err(CreateJobError::KeyReused)
    ));
    assert!(store.run("b").unwrap().is_none());
    assert_eq!(store.jobs(None, 10).unwrap().len(), 1);
}

#[test]
fn a_full_queue_stores_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    create(&store, &["a", "b"]);
    let full = store.create_job(&new_job(&["c", "d"]), 3);
    assert!(matches!(
        full,
        Err(CreateJobError::QueueFull {
            unfinished: 2,
            limit: 3
        })
    ));
    assert!(store.run("c").unwrap().is_none());
    let request = JobRequest::new(b"c", None);
    let refused = store.admit(&request, 2, 3);
    assert!(matches!(refused, Err(CreateJobError::QueueFull { .. })));
    assert!(store.admit(&request, 1, 3).unwrap().is_none());
    assert!(store.create_job(&new_job(&["c"]), 3).is_ok());
}

#[test]
fn pages_tell_every_job_and_run_once() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let jobs: Vec<JobKey> = (0..5)
        .map(|n| create(&store, &[&format!("run {n}")]).0)
        .collect();
    let (mut seen, mut before) = (Vec::new(), None);
    loop {
        let page = store.jobs(before, 2).unwrap();
        let Some(last) = page.last() else { break };
        before = Some(last.seq);
        seen.extend(page.iter().map(|job| job.seq));
    }
    seen.reverse();
    assert_eq!(seen, jobs);

    let (job, _) = create(&store, &["p", "q", "r"]);
    let ids = |from| -> Vec<String> {
        store
            .runs(job, from, 2)
            .unwrap()
            .into_iter()
            .map(|run| run.id)
            .collect()
    };
    assert_eq!(
        (ids(0), ids(2), ids(3)),
        (vec!["p".into(), "q".into()], vec!["r".into()], vec![])
    );
}

#[test]
fn a_finished_run_is_kept_and_never_waits_again() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let (first, waiting) = create(&store, &["a"]);
    store.claim(waiting[0]).unwrap().unwrap();
    assert!(store.findings(waiting[0]).unwrap().is_none());
    assert!(store.finish(waiting[0], &finished(), None).unwrap());
    let (second, waiting_again) = create(&store, &["a"]);
    assert!(waiting_again.is_empty());
    for job in [first, second] {
        let view = store.job(job).unwrap().unwrap();
        assert_eq!((view.counts.total, view.counts.done), (1, 1));
        assert_eq!(
            (view.robot_steps_done, view.robot_steps_total),
            (1_234, 1_234)
        );
    }
    assert_eq!(
        store.findings(waiting[0]).unwrap(),
        Some(finished().findings)
    );
    assert_eq!(
        store.run("a").unwrap().unwrap().state,
        RunState::Done(Box::new(finished().result))
    );
}

#[test]
fn a_shared_run_goes_on_while_any_job_wants_it() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let (one, _) = create(&store, &["a", "shared"]);
    let (two, _) = create(&store, &["shared"]);
    let changed = |job, intent| -> Vec<String> {
        store
            .set_intent(job, intent)
            .unwrap()
            .into_iter()
            .map(|run| run.id)
            .collect()
    };
    assert_eq!(changed(one, Intent::Paused), ["a"]);
    assert_eq!(
        (state_of(&store, "a"), state_of(&store, "shared")),
        (State::Paused, State::Queued)
    );
    assert_eq!(changed(two, Intent::Cancelled), ["shared"]);
    assert_eq!(state_of(&store, "shared"), State::Paused);
    assert_eq!(changed(one, Intent::Active).len(), 2);
    assert_eq!(store.waiting(one).unwrap().len(), 2);
    assert_eq!(changed(one, Intent::Cancelled).len(), 2);
    assert_eq!(state_of(&store, "shared"), State::Cancelled);

    let (three, waiting) = create(&store, &["shared"]);
    assert_eq!(waiting.len(), 1);
    assert_eq!(store.delete_job(three).unwrap().len(), 1);
    assert!(store.job(three).unwrap().is_none());
    assert_eq!(state_of(&store, "shared"), State::Cancelled);
    let gone = store.delete_job(one).unwrap();
    assert_eq!(gone.len(), 1);
    assert!(store.run("a").unwrap().is_none());
    assert!(store.run("shared").unwrap().is_some());
    store.delete_job(two).unwrap();
    assert!(store.run("shared").unwrap().is_none());
}

#[test]
fn a_run_let_go_keeps_its_position_if_it_is_wanted() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let (_, waiting) = create(&store, &["a", "b"]);
    for run in &waiting {
        store.claim(*run).unwrap().unwrap();
    }
    assert!(store.park(waiting[0], &position(), 2_000).unwrap());
    let run = store.run("a").unwrap().unwrap();
    assert_eq!(run.state, RunState::Queued(Some(position())));
    assert_eq!(run.robot_steps_total, 2_000);
    assert!(store.cancel_run(waiting[1]).unwrap().is_some());
    assert!(!store.park(waiting[1], &position(), 2_000).unwrap());
    assert!(!store.finish(waiting[1], &finished(), None).unwrap());
    assert!(store.cancel_run(waiting[1]).unwrap().is_none());
    assert_eq!(state_of(&store, "b"), State::Cancelled);
}

#[test]
fn a_failed_run_says_why_and_waits_again_when_posted_again() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let (job, waiting) = create(&store, &["a"]);
    store.claim(waiting[0]).unwrap().unwrap();
    store.fail(waiting[0], "it broke").unwrap();
    let state = store.run("a").unwrap().unwrap().state;
    assert_eq!(
        state,
        RunState::Failed {
            reason: "it broke".to_owned()
        }
    );
    let view = store.job(job).unwrap().unwrap();
    assert_eq!(view.intent.job_state(&view.counts), State::Failed);
    assert_eq!(create(&store, &["a"]).1, waiting);
    assert_eq!(state_of(&store, "a"), State::Queued);
}

#[test]
fn a_job_of_many_runs_is_stored_and_changed_in_parts() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let ids: Vec<String> = (0..2_345).map(|run| format!("run {run}")).collect();
    let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
    let create = |limit| store.create_job(&new_job(&ids), limit);
    assert!(matches!(
        create(2_344),
        Err(CreateJobError::TooLarge { .. })
    ));
    let Created::New(job, waiting) = create(2_345).unwrap() else {
        panic!("no key")
    };
    assert_eq!(waiting.len(), 2_345);
    let queued = |job| store.job(job).unwrap().unwrap().counts.queued;
    assert_eq!(queued(job), 2_345);
    let Created::New(twin, waiting) = create(10_000).unwrap() else {
        panic!("no key")
    };
    assert_eq!((waiting.len(), queued(twin)), (2_345, 2_345));
    assert_eq!(store.set_intent(job, Intent::Paused).unwrap(), []);
    assert_eq!(
        store.set_intent(twin, Intent::Cancelled).unwrap().len(),
        2_345
    );
    assert_eq!(store.job(job).unwrap().unwrap().counts.paused, 2_345);
    assert_eq!(store.delete_job(job).unwrap().len(), 2_345);
    assert_eq!(store.job(twin).unwrap().unwrap().counts.cancelled, 2_345);
    store.retry(twin).unwrap();
    assert_eq!(store.waiting(twin).unwrap().len(), 2_345);
    assert_eq!(check(dir.path()).unwrap().faults, Vec::<String>::new());
    store.delete_job(twin).unwrap();
    assert!(store.run("run 7").unwrap().is_none());
}

#[test]
fn a_job_that_is_being_stored_is_not_seen_and_its_key_is_taken() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let keyed = NewJob {
        request: JobRequest::new(b"a", Some("key".to_owned())),
        ..new_job(&["a", "b"])
    };
    let Created::New(job, _) = store.create_job(&keyed, 10).unwrap() else {
        panic!("the key is new");
    };
    store.set_unfinished(job, "creating").unwrap();
    assert!(store.job(job).unwrap().is_none());
    assert!(store.run("a").unwrap().is_none());
    assert!(store.jobs(None, 10).unwrap().is_empty());
    let again = store.create_job(&keyed, 10);
    assert!(matches!(again, Err(CreateJobError::UnderWay)));
    drop(store);
    let store = open(dir.path());
    assert!(store.recover().unwrap().is_empty());
    assert!(matches!(store.create_job(&keyed, 10), Ok(Created::New(..))));
}
