//! What the store promises: it survives, it never stores a job twice, shared runs are shared.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;

use api::State;

use super::*;

fn new_run(id: &str) -> NewRun {
    NewRun {
        id: id.to_owned(),
        spec: format!("{{\"of\": \"{id}\"}}"),
        seed: 7,
        arena: "maze".to_owned(),
        method: "brownian".to_owned(),
        epochs_total: 10,
        robot_steps_total: 1_000,
        step_cost: 1,
        uploaded_arenas: Vec::new(),
        label: format!("of {id}"),
    }
}

fn new_job(ids: &[&str]) -> NewJob {
    NewJob {
        design: String::new(),
        name: "a job".to_owned(),
        request: JobRequest::new(ids.concat().as_bytes(), None),
        runs: ids.iter().map(|id| new_run(id)).collect(),
    }
}

fn create(store: &Store, ids: &[&str]) -> (JobKey, Vec<RunKey>) {
    match store.create_job(&new_job(ids), 1_000).unwrap() {
        Created::New(job, waiting) => (job, waiting),
        Created::Replayed(_) => panic!("no key was given"),
    }
}

fn state_of(store: &Store, id: &str) -> State {
    store.run(id).unwrap().unwrap().state.state()
}

/// Of a run with an object, at its first step.
fn tracks() -> swarm::run::Tracks {
    let spec = serde_json::json!({ "engine": "rapier", "arena": {
        "name": "yard", "width_m": 0.6, "height_m": 0.6, "walls_m": [],
        "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.8 }],
        "objects": [{ "kind": "disc", "x_m": 0.3, "y_m": 0.3, "radius_m": 0.03 }]
    } });
    let spec = crate::documents::resolve(&spec, &crate::documents::BuiltinArenas).unwrap();
    let tracks = swarm::run::Run::new(spec.run_spec()).unwrap().tracks();
    assert_eq!(tracks.objects(), 1);
    tracks
}

fn finished() -> Finished {
    let result = api::RunResult {
        schema: 1,
        p1: 3,
        p2: 2,
        p5: 1,
        p10: 0,
        reachable: 6,
        fractions: api::Fractions {
            p1: 0.5,
            p2: 1.0 / 3.0,
            p5: 1.0 / 6.0,
            p10: 0.0,
        },
        metrics: None,
        steps: 1_234,
        collisions: 5,
        clusters: api::ClusterCounts::default(),
        model: None,
        bytes: 99,
        memory: api::Memory::default(),
        objects: Vec::new(),
        state_sha256: "00".repeat(32),
    };
    let curve = vec![swarm::run::CurveRow {
        epoch: 1,
        p1: 3,
        p2: 2,
        p5: 1,
        p10: 0,
    }];
    Finished {
        result,
        findings: Findings {
            curve,
            visits: vec![1, 2, 0],
            dwell: vec![4, 5, 0],
            metrics: swarm::run::MetricsLog {
                reachable: 3,
                first_entry: vec![1, 2, 0],
                ..Default::default()
            },
            tracks: tracks(),
        },
        cpu_ns_per_robot_step: Some(123.5),
    }
}

fn position() -> Position {
    Position {
        phase: "exploration".to_owned(),
        epochs_done: 4,
        robot_steps_done: 450,
    }
}

fn open(dir: &Path) -> Store {
    Store::open(dir).unwrap()
}

#[test]
fn one_process_at_a_time_holds_the_directory() {
    let dir = tempfile::tempdir().unwrap();
    let first = open(dir.path());
    let error = Store::open(dir.path()).err().unwrap();
    let pid = std::process::id();
    assert!(matches!(error, StoreError::InUse { pid: Some(holder), .. } if holder == pid));
    assert!(error.to_string().contains("in use"), "{error}");
    drop(first);
    open(dir.path());
}

#[test]
fn a_new_store_and_an_old_one_are_migrated() {
    let dir = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let store = open(dir.path());
        store.ping().unwrap();
        let connection = store.connection();
        let mode: String = connection
            .query_row("PRAGMA journal_mode", [], |row| row.get(0))
            .unwrap();
        let synchronous: i64 = connection
            .query_row("PRAGMA synchronous", [], |row| row.get(0))
            .unwrap();
        assert_eq!((mode.as_str(), synchronous), ("wal", 2));
    }
}

#[test]
fn results_of_versions_without_objects_stay_readable() {
    let dir = tempfile::tempdir().unwrap();
    let Findings {
        curve,
        visits,
        dwell,
        metrics,
        ..
    } = finished().findings;
    {
        let mut old = Connection::open(dir.path().join("evswarm.sqlite3")).unwrap();
        let runner = migrations::migrations::runner().set_target(refinery::Target::Version(3));
        runner.run(&mut old).unwrap();
        old.execute(
            "INSERT INTO runs (id, seed, arena, method, state, epochs_total, robot_steps_total, spec)
             VALUES ('a', 1, 'maze', 'im', 'done', 1, 1, '{}')",
            [],
        )
        .unwrap();
        // The layout as it was, field by field.
        let metrics = (
            metrics.reachable,
            &metrics.rows,
            &metrics.robots,
            &metrics.first_entry,
        );
        old.execute(
            "INSERT INTO results (run, result, coverage, metrics) VALUES (1, '{}', ?1, ?2)",
            (
                postcard::to_allocvec(&(&curve, &visits, &dwell)).unwrap(),
                postcard::to_allocvec(&metrics).unwrap(),
            ),
        )
        .unwrap();
    }
    let read = open(dir.path()).findings(RunKey(1)).unwrap().unwrap();
    assert!(read.tracks.is_empty());
    let expected = Findings {
        curve,
        visits,
        dwell,
        metrics,
        tracks: Default::default(),
    };
    assert_eq!(read, expected);
}

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
    assert!(store.finish(waiting[0], &finished()).unwrap());
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
    assert!(!store.finish(waiting[1], &finished()).unwrap());
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
fn an_arena_in_use_stays() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let listing = api::ArenaListing {
        name: "mine".to_owned(),
        builtin: false,
        width_m: 1.0,
        height_m: 1.0,
        walls: 0,
        starts: 1,
        squares: api::Squares::Side(100),
        reachable: 9_000,
    };
    let arena = StoredArena {
        name: "mine".to_owned(),
        body: "{}".to_owned(),
        listing,
    };
    assert!(store.save_arena(&arena, 1).unwrap());
    assert!(!store.save_arena(&arena, 1).unwrap());
    let changed = StoredArena {
        body: "{ }".to_owned(),
        ..arena.clone()
    };
    assert!(matches!(
        store.save_arena(&changed, 1),
        Err(SaveArenaError::NameTaken)
    ));
    let another = StoredArena {
        name: "other".to_owned(),
        ..arena.clone()
    };
    assert!(matches!(
        store.save_arena(&another, 1),
        Err(SaveArenaError::Full(1))
    ));
    assert_eq!(store.arenas().unwrap(), [arena.listing]);
    assert_eq!(store.arena("mine").unwrap().as_deref(), Some("{}"));

    let uses = NewRun {
        uploaded_arenas: vec!["mine".to_owned(); 2],
        ..new_run("a")
    };
    let job = NewJob {
        runs: vec![uses],
        ..new_job(&[])
    };
    let Created::New(job, _) = store.create_job(&job, 10).unwrap() else {
        panic!("no key")
    };
    assert_eq!(
        store.delete_arena("mine").unwrap(),
        ArenaDeletion::InUse { runs: 1 }
    );
    store.delete_job(job).unwrap();
    assert_eq!(store.delete_arena("mine").unwrap(), ArenaDeletion::Deleted);
    assert_eq!(store.delete_arena("mine").unwrap(), ArenaDeletion::Unknown);
}
