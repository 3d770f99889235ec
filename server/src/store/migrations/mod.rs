//! The database's layout, brought up to date: all that is missing in one transaction together with
//! its number (`PRAGMA user_version`), so that a crash leaves the old layout or the new one.

use rusqlite::{Connection, Transaction, params};
use rusqlite_migration::{HookResult, M, Migrations};
use sha2::{Digest, Sha256};

use super::StoreError;
use super::formats::{Blobs, upgrade_v0};
use crate::break_points::{Place, reach};

/// In order; the number of a migration is its place, from 1. None of these is ever changed.
fn migrations() -> Migrations<'static> {
    let plain = |sql| M::up_with_hook(sql, |_: &Transaction<'_>| at_break_point());
    Migrations::new(vec![
        plain(include_str!("1_jobs_runs_arenas.sql")),
        plain(include_str!("2_labels.sql")),
        plain(include_str!("3_metrics.sql")),
        plain(include_str!("4_objects.sql")),
        plain(include_str!("5_step_cost.sql")),
        M::up_with_hook(include_str!("6_versions.sql"), seal_results),
        plain(include_str!("7_totals.sql")),
        plain(include_str!("8_run_control.sql")),
        plain(include_str!("9_events.sql")),
        plain(include_str!("10_origins.sql")),
        plain(include_str!("11_controllers.sql")),
        plain(include_str!("12_ends.sql")),
        plain(include_str!("13_gone_jobs.sql")),
    ])
}

fn at_break_point() -> HookResult {
    reach(Place::Migration);
    Ok(())
}

/// Brings a database up to date.
///
/// # Errors
/// When a later program made it, or it cannot be changed; it is as before then.
pub fn run(connection: &mut Connection) -> Result<(), StoreError> {
    reach(Place::Migration);
    take_over(connection)?;
    migrations().to_latest(connection)?;
    reach(Place::Migration);
    Ok(())
}

/// Whether a database is up to date.
///
/// # Errors
/// When it cannot be read.
pub fn is_latest(connection: &Connection) -> Result<bool, StoreError> {
    Ok(migrations().pending_migrations(connection)? == 0)
}

/// Programs before this one numbered migrations in a table, in a transaction apart: one that was
/// killed in between left a database that it could not open again. What such a database has
/// decides, not what the table says.
fn take_over(connection: &mut Connection) -> Result<(), StoreError> {
    let transaction = connection.transaction()?;
    let is_old: bool = transaction.query_row(
        "SELECT EXISTS (SELECT 1 FROM sqlite_schema WHERE name = 'refinery_schema_history')",
        [],
        |row| row.get(0),
    )?;
    if is_old {
        let version: i64 = transaction.query_row(
            "SELECT CASE
                WHEN EXISTS (SELECT 1 FROM pragma_table_info('runs') WHERE name = 'step_cost') THEN 5
                WHEN EXISTS (SELECT 1 FROM pragma_table_info('results') WHERE name = 'objects') THEN 4
                WHEN EXISTS (SELECT 1 FROM pragma_table_info('results') WHERE name = 'metrics') THEN 3
                WHEN EXISTS (SELECT 1 FROM pragma_table_info('job_runs') WHERE name = 'label') THEN 2
                WHEN EXISTS (SELECT 1 FROM pragma_table_info('jobs')) THEN 1
                ELSE 0 END",
            [],
            |row| row.get(0),
        )?;
        transaction.pragma_update(None, "user_version", version)?;
        transaction.execute("DROP TABLE refinery_schema_history", [])?;
        reach(Place::Migration);
    }
    Ok(transaction.commit()?)
}

/// Puts the bare blobs of older programs into envelopes. One that is damaged already stays as it
/// is, and answers as damaged from then on.
fn seal_results(transaction: &Transaction<'_>) -> HookResult {
    reach(Place::Migration);
    let runs: Vec<i64> = transaction
        .prepare("SELECT run FROM results ORDER BY run")?
        .query_map([], |row| row.get(0))?
        .collect::<Result<_, _>>()?;
    let mut read = transaction
        .prepare("SELECT result, coverage, metrics, objects FROM results WHERE run = ?1")?;
    let mut write = transaction.prepare(
        "UPDATE results SET result_sha256 = ?2, coverage = ?3, metrics = ?4, objects = ?5
         WHERE run = ?1",
    )?;
    for run in runs {
        let (result, old) = read.query_row([run], |row| {
            let blobs = Blobs {
                coverage: row.get(1)?,
                metrics: row.get(2)?,
                objects: row.get(3)?,
            };
            Ok((row.get::<_, String>(0)?, blobs))
        })?;
        let new = upgrade_v0(&old).unwrap_or_else(|damage| {
            tracing::warn!(run, %damage, "the findings of a run are damaged");
            old
        });
        let digest = Sha256::digest(&result);
        write.execute(params![
            run,
            &digest[..],
            new.coverage,
            new.metrics,
            new.objects
        ])?;
    }
    reach(Place::Migration);
    Ok(())
}

#[cfg(test)]
mod tests;
