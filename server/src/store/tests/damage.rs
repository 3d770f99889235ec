//! What is damaged is told, and takes nothing else with it.

use super::*;

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
        (
            "UPDATE jobs SET created_at = CAST(x'ff' AS TEXT)",
            "the moment of job 1 is not UTF-8",
        ),
        (
            "UPDATE job_totals SET state = 'dead' WHERE state = 'queued'",
            "the sums of job 1 over runs that are dead are wrong",
        ),
        (
            "UPDATE job_totals SET robot_steps_total = 9223372036854775807, work_total = 9223372036854775807",
            "the sums of job 1 over runs that are queued are wrong",
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
