#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;

#[test]
fn migrations_are_valid() {
    migrations().validate().unwrap();
}

/// A database as a program that numbered its migrations in a table left it.
fn old(version: usize, history: usize) -> Connection {
    let mut connection = Connection::open_in_memory().unwrap();
    migrations().to_version(&mut connection, version).unwrap();
    connection
        .execute_batch("CREATE TABLE refinery_schema_history (version INTEGER PRIMARY KEY)")
        .unwrap();
    for version in 1..=history {
        let sql = "INSERT INTO refinery_schema_history VALUES (?1)";
        connection.execute(sql, [version as i64]).unwrap();
    }
    connection.pragma_update(None, "user_version", 0).unwrap();
    connection
}

fn schema(connection: &Connection) -> Vec<String> {
    connection
        .prepare("SELECT sql FROM sqlite_schema WHERE sql IS NOT NULL ORDER BY name")
        .unwrap()
        .query_map([], |row| row.get(0))
        .unwrap()
        .collect::<Result<_, _>>()
        .unwrap()
}

#[test]
fn a_database_locked_by_a_kill_between_a_migration_and_its_history_opens() {
    let mut fresh = Connection::open_in_memory().unwrap();
    run(&mut fresh).unwrap();
    for version in 0..=5_usize {
        for history in [version.saturating_sub(1), version] {
            let mut connection = old(version, history);
            run(&mut connection).unwrap();
            assert_eq!(schema(&connection), schema(&fresh), "{version} {history}");
        }
    }
}

#[test]
fn a_later_database_is_refused() {
    let mut connection = Connection::open_in_memory().unwrap();
    run(&mut connection).unwrap();
    connection
        .pragma_update(None, "user_version", 1_000)
        .unwrap();
    assert!(matches!(
        run(&mut connection),
        Err(StoreError::Migration(_))
    ));
}

#[test]
fn a_damaged_blob_does_not_keep_a_database_from_its_upgrade() {
    let mut connection = old(5, 5);
    connection
        .execute_batch(
            "INSERT INTO runs (id, seed, arena, method, state, epochs_total, robot_steps_total, spec)
                VALUES ('a', 1, 'maze', 'im', 'done', 1, 1, '{}');
             INSERT INTO results (run, result, coverage) VALUES (1, '{}', x'ff00')",
        )
        .unwrap();
    run(&mut connection).unwrap();
    let coverage: Vec<u8> = connection
        .query_row("SELECT coverage FROM results", [], |row| row.get(0))
        .unwrap();
    assert_eq!(coverage, [0xff, 0]);
}
