//! Looks through a data directory from beginning to end, also while a server uses it.

use std::path::Path;

use rusqlite::{Connection, OpenFlags};
use sha2::{Digest, Sha256};

use super::formats::Blobs;
use super::{Checkpoints, StoreError, look, migrations, shown_text};

/// What was looked at, and what is wrong with it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Checked {
    /// Results that were looked at.
    pub results: u64,
    /// Checkpoints that were looked at.
    pub checkpoints: u64,
    /// A line for each fault.
    pub faults: Vec<String>,
}

/// Looks through a data directory and changes nothing.
///
/// # Errors
/// When there is none, or it cannot be read.
pub fn check(dir: &Path) -> Result<Checked, StoreError> {
    // A directory that is no store is told as such; nothing is made in it.
    let path = dir.join(super::DATABASE);
    if let Err(error) = std::fs::metadata(&path) {
        look::at_file(dir)?;
        return Err(StoreError::io(&path)(error));
    }
    let checkpoints = Checkpoints::open(&dir.join(super::CHECKPOINTS))?;
    let mut checked = Checked::default();
    if let Err(error) = database(dir, &mut checked) {
        checked.faults.push(error.to_string());
    }
    let origins = dir.join(super::ORIGINS);
    let origins = origins
        .is_dir()
        .then(|| Checkpoints::open(&origins))
        .transpose()?;
    for folder in [Some(&checkpoints), origins.as_ref()].into_iter().flatten() {
        for run in folder.runs()? {
            checked.checkpoints += 1;
            if let Err(error) = folder.read(&run) {
                checked.faults.push(error.to_string());
            }
        }
    }
    Ok(checked)
}

fn database(dir: &Path, checked: &mut Checked) -> Result<(), StoreError> {
    look::at_file(dir)?;
    let connection =
        Connection::open_with_flags(dir.join(super::DATABASE), OpenFlags::SQLITE_OPEN_READ_ONLY)?;
    let lines = |sql: &str| -> rusqlite::Result<Vec<String>> {
        connection
            .prepare(sql)?
            .query_map([], |row| row.get(0))?
            .collect()
    };
    let found = lines("PRAGMA integrity_check(100)")?;
    let faults = found.into_iter().filter(|line| line != "ok");
    checked
        .faults
        .extend(faults.map(|line| format!("the database: {line}")));
    if !migrations::is_latest(&connection)? {
        let fault = "the database is of another version of the program: what is in it was not \
            looked at; starting the service brings an older one up to date";
        checked.faults.push(fault.to_owned());
        return Ok(());
    }
    checked.faults.extend(lines(
        "SELECT 'a row of ' || \"table\" || ' refers to one of ' || parent || ' that is not there'
         FROM pragma_foreign_key_check",
    )?);
    checked.faults.extend(lines(
        "SELECT 'run ' || id || ' is done and has no result' FROM runs
         WHERE state = 'done' AND NOT EXISTS (SELECT 1 FROM results WHERE run = runs.seq)",
    )?);
    checked.faults.extend(lines(TOTALS)?);
    checked.faults.extend(lines(VALUES)?);
    checked.faults.extend(not_utf8(&connection)?);
    results(&connection, checked)
}

const TOTALS: &str = "WITH counted AS (
        SELECT job, state, count(*) AS runs, sum(robot_steps_done) AS done,
            sum(robot_steps_total) AS total, sum(robot_steps_done * step_cost) AS work_done,
            sum(robot_steps_total * step_cost) AS work_total
        FROM job_runs JOIN runs ON runs.seq = job_runs.run GROUP BY job, state),
    kept AS (
        SELECT job, state, runs, robot_steps_done, robot_steps_total, work_done, work_total
        FROM job_totals WHERE runs <> 0)
    SELECT 'the sums of job ' || job || ' over runs that are ' || state || ' are wrong' FROM (
        SELECT job, state FROM (SELECT * FROM counted EXCEPT SELECT * FROM kept)
        UNION SELECT job, state FROM (SELECT * FROM kept EXCEPT SELECT * FROM counted))";

/// Values that are not what they should be. `CASE`, as `json_type` fails where there is no JSON.
const VALUES: &str =
    "SELECT 'the spec of the run with key ' || seq || ' is no JSON object' FROM runs
        WHERE CASE WHEN json_valid(spec) THEN json_type(spec) <> 'object' ELSE TRUE END
    UNION ALL SELECT 'the document of job ' || seq || ' is no JSON object' FROM jobs
        WHERE document IS NOT NULL
            AND CASE WHEN json_valid(document) THEN json_type(document) <> 'object' ELSE TRUE END
    UNION ALL SELECT 'the design of job ' || seq || ' is no JSON' FROM jobs
        WHERE coalesce(design, '') <> '' AND NOT json_valid(design)
    UNION ALL SELECT 'the priority of job ' || seq || ' is out of range: ' || priority FROM jobs
        WHERE priority NOT BETWEEN -2147483648 AND 2147483647";

/// Names, ids and moments that are not UTF-8, by the keys of their rows.
fn not_utf8(connection: &Connection) -> rusqlite::Result<Vec<String>> {
    let mut faults = Vec::new();
    for (what, sql) in [
        ("name of job", "SELECT seq, name FROM jobs ORDER BY seq"),
        (
            "moment of job",
            "SELECT seq, created_at FROM jobs ORDER BY seq",
        ),
        (
            "id of the run with key",
            "SELECT seq, id FROM runs ORDER BY seq",
        ),
    ] {
        let mut statement = connection.prepare(sql)?;
        let mut rows = statement.query([])?;
        while let Some(row) = rows.next()? {
            if row.get_ref(1)?.as_str().is_err() {
                let seq: i64 = row.get(0)?;
                faults.push(format!("the {what} {seq} is not UTF-8"));
            }
        }
    }
    Ok(faults)
}

fn results(connection: &Connection, checked: &mut Checked) -> Result<(), StoreError> {
    let mut statement = connection.prepare(
        "SELECT id, result, result_sha256, coverage, metrics, objects
         FROM results JOIN runs ON runs.seq = results.run ORDER BY run",
    )?;
    let mut rows = statement.query([])?;
    while let Some(row) = rows.next()? {
        checked.results += 1;
        let id = shown_text(row, "id")?;
        let digest: Option<Vec<u8>> = row.get(2)?;
        let is_whole = row
            .get::<_, String>(1)
            .is_ok_and(|result| digest.as_deref() == Some(&Sha256::digest(&result)[..]));
        if !is_whole {
            let damaged = StoreError::damaged("result", &id, "its digest does not match");
            checked.faults.push(damaged.to_string());
        }
        let blobs = Blobs {
            coverage: row.get(3)?,
            metrics: row.get(4)?,
            objects: row.get(5)?,
        };
        if let Err((kind, why)) = blobs.read() {
            let damaged = StoreError::damaged(kind.name(), &id, why);
            checked.faults.push(damaged.to_string());
        }
    }
    Ok(())
}
