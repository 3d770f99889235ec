//! What the store promises: it survives, it never stores a job twice, shared runs are shared.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;

use api::State;

use super::*;

mod backup;
mod damage;
mod jobs;

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
        origin: None,
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
        dwell: None,
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
fn files_are_for_their_owner_alone() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let data = dir.path().join("data");
    let store = open(&data);
    create(&store, &["a"]);
    let mode = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&data), 0o700);
    for entry in std::fs::read_dir(&data).unwrap() {
        let path = entry.unwrap().path();
        let expected = if path.is_dir() { 0o700 } else { 0o600 };
        assert_eq!(mode(&path), expected, "{}", path.display());
    }
}

#[test]
fn unfinished_runs_of_another_results_version_start_again() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let (_, waiting) = create(&store, &["a", "b", "c"]);
    for run in &waiting[..2] {
        store.claim(*run).unwrap().unwrap();
    }
    store.park(waiting[0], &position(), 1_000).unwrap();
    store.finish(waiting[1], &finished(), None).unwrap();
    let checkpoint = Checkpoint {
        findings: Findings::default(),
        snapshot: vec![1, 2, 3],
    };
    store.checkpoints().write("a", &checkpoint).unwrap();
    store.checkpoints().write("c", &checkpoint).unwrap();
    store
        .connection()
        .execute("UPDATE runs SET results_version = 0 WHERE id <> 'c'", [])
        .unwrap();
    drop(store);
    let store = open(dir.path());
    store.recover().unwrap();
    let of = |id: &str| store.run(id).unwrap().unwrap();
    assert_eq!(of("a").state, RunState::Queued(None));
    assert_eq!(of("a").results_version, swarm::RESULTS_VERSION);
    assert!(store.checkpoints().read("a").unwrap().is_none());
    assert!(store.checkpoints().read("c").unwrap().is_some());
    assert_eq!(
        (of("b").results_version, of("b").state.state()),
        (0, State::Done)
    );
}

#[test]
fn an_arena_in_use_stays() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let arena = StoredArena::example();
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
    assert_eq!(store.arena("mine").unwrap(), Some(arena.body));

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
    // A job that is being made of it would have none, or another one of that name.
    let lent = [store.lend_arena("mine"), store.lend_arena("mine")];
    for lent in lent {
        assert_eq!(store.delete_arena("mine").unwrap(), ArenaDeletion::Lent);
        drop(lent);
    }
    assert_eq!(store.delete_arena("mine").unwrap(), ArenaDeletion::Deleted);
    assert_eq!(store.delete_arena("mine").unwrap(), ArenaDeletion::Unknown);
}

#[test]
fn readers_do_not_wait_for_the_writer() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let (job, _) = create(&store, &["a"]);
    let mut writer = store.connection();
    let transaction = writer.transaction().unwrap();
    transaction
        .execute("UPDATE runs SET state = 'cancelled'", [])
        .unwrap();
    // On this very thread: waiting would be for ever.
    assert_eq!(store.job(job).unwrap().unwrap().counts.queued, 1);
    assert_eq!(state_of(&store, "a"), State::Queued);
    transaction.commit().unwrap();
    assert_eq!(state_of(&store, "a"), State::Cancelled);
}
