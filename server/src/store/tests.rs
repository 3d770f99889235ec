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

/// Stores a finished run, changes its row by hand, and opens the store again.
fn tampered(change: &str) -> (tempfile::TempDir, Store) {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    let (_, waiting) = create(&store, &["a", "b"]);
    store.claim(waiting[0]).unwrap().unwrap();
    store.finish(waiting[0], &finished(), None).unwrap();
    store.connection().execute_batch(change).unwrap();
    drop(store);
    let store = open(dir.path());
    (dir, store)
}

#[test]
fn a_changed_cut_or_longer_blob_is_damaged() {
    for column in ["coverage", "metrics", "objects"] {
        let hex = format!("hex({column})");
        for new in [
            // The last byte but one digit; cut; longer.
            format!(
                "unhex(substr({hex}, 1, length({hex}) - 1) || (CASE substr({hex}, -1) WHEN '0' THEN '1' ELSE '0' END))"
            ),
            format!("unhex(substr({hex}, 1, length({hex}) - 2))"),
            format!("unhex({hex} || '00')"),
        ] {
            let (_dir, store) = tampered(&format!("UPDATE results SET {column} = {new}"));
            let run = store.run("a").unwrap().unwrap();
            let error = store.findings(run.seq).unwrap_err();
            let is_it = matches!(&error, StoreError::Damaged { what, run, .. } if *what == column && run == "a");
            assert!(is_it, "{new}: {error}");
        }
    }
}

#[test]
fn a_damaged_result_does_not_take_the_list() {
    for change in [
        "UPDATE results SET result = replace(result, '1234', '1235')",
        "UPDATE results SET result = substr(result, 1, 20)",
        "UPDATE results SET result = result || ' '",
        "UPDATE results SET result_sha256 = NULL",
        "UPDATE job_runs SET label = CAST(x'ff' AS TEXT) WHERE ordinal = 0",
        "DELETE FROM results",
    ] {
        let (_dir, store) = tampered(change);
        let runs = store.runs(JobKey(1), 0, 10).unwrap();
        let is_damaged = |run: &RunView| matches!(run.state, RunState::Damaged { .. });
        assert_eq!(runs.len(), 2, "{change}");
        assert!(
            is_damaged(&runs[0]) && !is_damaged(&runs[1]),
            "{change}: {runs:?}"
        );
    }
}

#[test]
fn a_database_that_was_cut_emptied_or_replaced_is_refused_and_checkpoints_stay() {
    let (dir, store) = tampered("SELECT 1");
    let checkpoint = Checkpoint {
        findings: Findings::default(),
        snapshot: vec![1, 2, 3],
    };
    store.checkpoints().write("b", &checkpoint).unwrap();
    drop(store);
    let path = dir.path().join("evswarm.sqlite3");
    let whole = std::fs::read(&path).unwrap();
    let mut torn = whole.clone();
    let middle = torn.len() / 2 / 4096 * 4096;
    torn[middle..middle + 8192].fill(0);
    for (what, bytes) in [
        ("emptied", &[][..]),
        ("cut", &whole[..whole.len() / 2]),
        ("cut in the first page", &whole[..50]),
        ("replaced", b"this is not a database, but a text of more than a hundred bytes, such as someone might put here"),
        ("torn", &torn),
    ] {
        std::fs::write(&path, bytes).unwrap();
        let error = Store::open(dir.path()).err().unwrap();
        assert!(matches!(error, StoreError::Suspicious { .. }), "{what}: {error}");
        assert_eq!(std::fs::read(&path).unwrap(), bytes, "{what}");
    }
    std::fs::remove_file(&path).unwrap();
    assert!(Store::open(dir.path()).is_err(), "missing");
    std::fs::write(&path, whole).unwrap();
    let store = open(dir.path());
    store.recover().unwrap();
    assert_eq!(store.checkpoints().read("b").unwrap(), Some(checkpoint));
}

#[test]
fn a_row_that_cannot_be_read_takes_no_list_and_check_tells_of_it() {
    for (change, told) in [
        (
            "UPDATE jobs SET name = CAST(x'ff41' AS TEXT)",
            "the name of job 1 is not UTF-8",
        ),
        (
            "UPDATE runs SET id = CAST(x'ff' AS TEXT) WHERE seq = 1",
            "the id of the run with key 1 is not UTF-8",
        ),
        (
            "UPDATE runs SET spec = '{' WHERE seq = 2",
            "the spec of the run with key 2 is no JSON object",
        ),
        (
            "UPDATE runs SET spec = '[]' WHERE seq = 2",
            "the spec of the run with key 2 is no JSON object",
        ),
        (
            "UPDATE jobs SET document = '{'",
            "the document of job 1 is no JSON object",
        ),
        (
            "UPDATE jobs SET design = '{'",
            "the design of job 1 is no JSON",
        ),
        (
            "UPDATE jobs SET priority = 9223372036854775807",
            "the priority of job 1 is out of range: 9223372036854775807",
        ),
    ] {
        let (dir, store) = tampered(change);
        assert_eq!(store.jobs(None, 10).unwrap().len(), 1, "{change}");
        let page = store.list_jobs(&JobFilter::default(), None, 10).unwrap();
        assert_eq!(page.items.len(), 1, "{change}");
        let page = store.list_runs(&RunFilter::default(), None, 10).unwrap();
        assert_eq!(page.items.len(), 2, "{change}");
        assert_eq!(store.all_runs(JobKey(1)).unwrap().len(), 2, "{change}");
        assert!(store.priorities().is_ok(), "{change}");
        let faults = check(dir.path()).unwrap().faults;
        assert!(
            faults.iter().any(|fault| fault == told),
            "{change}: {faults:?}"
        );
    }
}

/// Also where every run is done, so that no checkpoint is left.
#[test]
fn an_empty_or_missing_database_beside_anything_of_a_store_is_refused() {
    for left in [
        "checkpoints/a.checkpoint",
        "origins/a.checkpoint",
        "finals/a.checkpoint",
        "recordings/a/live.evrec",
    ] {
        let dir = tempfile::tempdir().unwrap();
        drop(open(dir.path()));
        let database = dir.path().join(DATABASE);
        std::fs::write(&database, b"").unwrap();
        // Nothing else of a store is there.
        drop(open(dir.path()));
        let left = dir.path().join(left);
        std::fs::create_dir_all(left.parent().unwrap()).unwrap();
        std::fs::write(&left, b"1").unwrap();
        std::fs::write(&database, b"").unwrap();
        for is_missing in [false, true] {
            if is_missing {
                std::fs::remove_file(&database).unwrap();
            }
            let error = Store::open(dir.path()).err().unwrap();
            assert!(
                matches!(error, StoreError::Suspicious { .. }),
                "{}: {error}",
                left.display()
            );
            assert!(left.exists());
            let told = match check(dir.path()) {
                Ok(checked) => checked.faults.concat(),
                Err(error) => error.to_string(),
            };
            assert!(told.contains("empty or missing"), "{told}");
            assert!(!told.contains("version"), "{told}");
        }
    }
}

#[test]
fn a_full_disk_is_told_apart() {
    let dir = tempfile::tempdir().unwrap();
    let store = open(dir.path());
    create(&store, &["a"]);
    let set = |pages: i64| {
        let connection = store.connection();
        let sql = format!("PRAGMA max_page_count = {pages}");
        connection.query_row(&sql, [], |_| Ok(())).unwrap();
    };
    set(1);
    let large = NewJob {
        design: "x".repeat(100_000),
        ..new_job(&["b"])
    };
    let error = store.create_job(&large, 10).unwrap_err();
    assert!(
        matches!(error, CreateJobError::Store(StoreError::Full(_))),
        "{error}"
    );
    set(1_000_000);
    assert_eq!(store.jobs(None, 10).unwrap().len(), 1);
    store.create_job(&large, 10).unwrap();
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

#[test]
fn check_finds_every_damage_and_a_backup_is_whole() {
    let dir = tempfile::tempdir().unwrap();
    let (data, copy) = (dir.path().join("data"), dir.path().join("copy"));
    let store = open(&data);
    let (_, waiting) = create(&store, &["a", "b"]);
    store.claim(waiting[0]).unwrap().unwrap();
    store.finish(waiting[0], &finished(), None).unwrap();
    let checkpoint = Checkpoint {
        findings: finished().findings,
        snapshot: vec![1, 2, 3],
    };
    store.checkpoints().write("b", &checkpoint).unwrap();
    // While the store is open.
    let whole = check(&data).unwrap();
    assert_eq!((whole.results, whole.checkpoints), (1, 1));
    assert_eq!(whole.faults, Vec::<String>::new());
    backup(&data, &copy).unwrap();
    assert!(backup(&data, &copy).is_err(), "it is there");
    assert_eq!(check(&copy).unwrap(), whole);
    let restored = open(&copy);
    assert_eq!(
        restored.findings(waiting[0]).unwrap(),
        Some(finished().findings)
    );
    assert_eq!(restored.checkpoints().read("b").unwrap(), Some(checkpoint));

    let sql = "UPDATE results SET result = result || ' ', coverage = x'00';
        UPDATE job_totals SET runs = runs + 1 WHERE state = 'done'";
    store.connection().execute_batch(sql).unwrap();
    std::fs::write(data.join("checkpoints/b.checkpoint"), b"half").unwrap();
    let faults = check(&data).unwrap().faults;
    assert_eq!(faults.len(), 4, "{faults:#?}");
    drop(store);
    std::fs::write(data.join(DATABASE), b"").unwrap();
    assert!(!check(&data).unwrap().faults.is_empty());
}

#[test]
fn a_backup_has_recordings_and_last_states_for_its_owner_alone() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let (data, copy) = (dir.path().join("data"), dir.path().join("copy"));
    let store = open(&data);
    create(&store, &["a"]);
    let checkpoint = Checkpoint {
        findings: finished().findings,
        snapshot: vec![1, 2, 3],
    };
    store.origins().write("a", &checkpoint).unwrap();
    Checkpoints::open(&data.join("finals"))
        .unwrap()
        .write("a", &checkpoint)
        .unwrap();
    store.recordings().make("a").unwrap();
    let recording = store.recordings().of("a");
    for name in ["live.evrec", "1.json", "1.evrec.part"] {
        std::fs::write(recording.join(name), name).unwrap();
    }
    // Still being written.
    std::fs::write(recording.join(".tmp1"), "").unwrap();
    backup(&data, &copy).unwrap();
    let names = |path: &Path| {
        let entries = std::fs::read_dir(path).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    let copied = copy.join("recordings/a");
    assert_eq!(names(&copied), ["1.evrec.part", "1.json", "live.evrec"]);
    assert_eq!(
        std::fs::read(copied.join("live.evrec")).unwrap(),
        b"live.evrec"
    );
    let mode = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o777;
    let mut folders = vec![copy.clone()];
    while let Some(folder) = folders.pop() {
        assert_eq!(mode(&folder), 0o700, "{}", folder.display());
        for name in names(&folder) {
            let path = folder.join(name);
            match path.is_dir() {
                true => folders.push(path),
                false => assert_eq!(mode(&path), 0o600, "{}", path.display()),
            }
        }
    }
    let restored = open(&copy);
    let last = restored.finals().read("a").unwrap();
    assert_eq!(last.as_ref(), Some(&checkpoint));
    assert_eq!(restored.origins().read("a").unwrap(), Some(checkpoint));
}

#[test]
fn a_backup_inside_the_data_directory_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let data = dir.path().join("data");
    drop(open(&data));
    let before = std::fs::read_dir(&data).unwrap().count();
    for to in [
        "data",
        "data/copy",
        "data/new/copy",
        "other/../data/copy",
        "data/finals/copy",
    ] {
        let error = backup(&data, &dir.path().join(to)).unwrap_err().to_string();
        assert!(error.contains("inside the data directory"), "{to}: {error}");
        assert_eq!(std::fs::read_dir(&data).unwrap().count(), before, "{to}");
    }
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
