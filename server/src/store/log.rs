//! Entries of a run's log, in the transaction of what they tell.

use rusqlite::{Connection, params};

use super::keys::RunKey;

/// Most entries kept of a run's log; the oldest go.
const LOG_ENTRIES: u32 = 1_000;

/// Notes what was changed of a run, and where it stood.
pub(super) fn log(connection: &Connection, run: RunKey, what: &str) -> rusqlite::Result<()> {
    connection
        .prepare_cached(
            "INSERT INTO run_log (run, robot_steps_done, what)
             SELECT seq, CASE state WHEN 'running' THEN NULL ELSE robot_steps_done END, ?2
             FROM runs WHERE seq = ?1",
        )?
        .execute(params![run, what])?;
    connection
        .prepare_cached(
            "DELETE FROM run_log WHERE run = ?1 AND seq <= (
                SELECT seq FROM run_log WHERE run = ?1 ORDER BY seq DESC LIMIT 1 OFFSET ?2)",
        )?
        .execute(params![run, LOG_ENTRIES])?;
    Ok(())
}
