//! Control of single runs, priorities of jobs, jobs that grow, and the log of all that.

use std::collections::BTreeSet;
use std::sync::atomic::Ordering::Relaxed;

use rusqlite::{Connection, OptionalExtension, params};

use super::changes::{PART, Part, requeue, settle};
use super::creation::{CreateJobError, NewJob, NewRun, add_runs, check_room};
use super::keys::{JobKey, RunKey};
use super::log::log;
use super::runs::StoppedRun;
use super::{Store, StoreError, from_sql, nearest_i32, to_sql};

/// What was changed of a run, and when.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogEntry {
    /// RFC 3339 in UTC.
    pub at: String,
    /// Where the run stood; `None` while a worker held it.
    pub robot_steps_done: Option<u64>,
    /// In words.
    pub what: String,
}

impl Store {
    /// Holds a run that waits or runs, whatever its jobs want. Returns it, unless it is in another
    /// state.
    ///
    /// # Errors
    /// When the database fails; nothing is changed then.
    pub fn hold(&self, run: RunKey, why: &str) -> Result<Option<StoppedRun>, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        transaction
            .prepare_cached(
                "UPDATE runs SET awaits_controllers = 0, waits_for = NULL WHERE seq = ?1",
            )?
            .execute([run])?;
        let held = held(&transaction, run, why)?;
        transaction.commit()?;
        Ok(held)
    }

    /// As [`Store::hold`], for a reason that is shown with the run, and perhaps only until the
    /// programs that steer it are there.
    ///
    /// # Errors
    /// When the database fails; nothing is changed then.
    pub fn hold_waiting(
        &self,
        run: RunKey,
        why: &str,
        for_controllers: bool,
    ) -> Result<Option<StoppedRun>, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        let held = held(&transaction, run, why)?;
        if held.is_some() {
            transaction
                .prepare_cached(
                    "UPDATE runs SET awaits_controllers = ?2, waits_for = ?3 WHERE seq = ?1",
                )?
                .execute(params![run, for_controllers, why])?;
        }
        transaction.commit()?;
        Ok(held)
    }

    /// Runs that are held until the programs that steer them are there, oldest first.
    ///
    /// # Errors
    /// When the database fails.
    pub fn await_controllers(&self, most: u32) -> Result<Vec<StoppedRun>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached(
                "SELECT seq, id FROM runs
                 WHERE state = 'paused' AND held = 1 AND awaits_controllers = 1
                 ORDER BY seq LIMIT ?1",
            )?
            .query_map([most], stopped)?
            .collect::<Result<_, _>>()?)
    }

    /// Holds a run no more, so that it does what its jobs want; it is held again at a step of its
    /// arena where one is given. Returns whether it waits now; `None` when there is no such run.
    ///
    /// # Errors
    /// When the database fails; nothing is changed then.
    pub fn release(
        &self,
        run: RunKey,
        pause_at_step: Option<u64>,
        why: &str,
    ) -> Result<Option<bool>, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        transaction
            .prepare_cached(
                "UPDATE runs SET held = 0, awaits_controllers = 0, waits_for = NULL, pause_at_step = ?2
                 WHERE seq = ?1 AND state IN ('queued', 'paused')",
            )?
            .execute(params![run, pause_at_step.map(to_sql)])?;
        transaction
            .prepare_cached(
                "UPDATE runs SET state = 'queued' WHERE seq = ?1 AND state = 'paused' AND EXISTS (
                    SELECT 1 FROM job_runs JOIN jobs ON jobs.seq = job
                    WHERE run = ?1 AND intent = 'active')",
            )?
            .execute([run])?;
        let waits: Option<bool> = transaction
            .prepare_cached("SELECT state = 'queued' FROM runs WHERE seq = ?1")?
            .query_row([run], |row| row.get(0))
            .optional()?;
        if waits == Some(true) {
            log(&transaction, run, why)?;
            transaction.commit()?;
        }
        Ok(waits)
    }

    /// Makes a failed or cancelled run wait again, from its beginning. Returns whether it waits now:
    /// not where it is in another state or no job wants it.
    ///
    /// # Errors
    /// When the database fails; nothing is changed then.
    pub fn retry_run(&self, run: RunKey) -> Result<bool, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        let changed = transaction
            .prepare_cached(
                "UPDATE runs SET state = 'queued', reason = NULL, phase = NULL, epochs_done = 0,
                    robot_steps_done = 0, held = 0, pause_at_step = NULL
                 WHERE seq = ?1 AND state IN ('failed', 'cancelled') AND EXISTS (
                    SELECT 1 FROM job_runs JOIN jobs ON jobs.seq = job
                    WHERE run = ?1 AND intent = 'active')",
            )?
            .execute([run])?;
        if changed > 0 {
            log(&transaction, run, "tried again")?;
        }
        transaction.commit()?;
        Ok(changed > 0)
    }

    /// Deletes a run with its result, in every job that has it. Returns it if it was there.
    ///
    /// # Errors
    /// When the database fails; nothing is changed then.
    pub fn delete_run(&self, run: RunKey) -> Result<Option<StoppedRun>, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        transaction.execute("DELETE FROM job_runs WHERE run = ?1", [run])?;
        let gone = transaction
            .prepare_cached("DELETE FROM runs WHERE seq = ?1 RETURNING seq, id")?
            .query_row([run], stopped)
            .optional()?;
        transaction.commit()?;
        Ok(gone)
    }

    /// Adds an entry to a run's log.
    ///
    /// # Errors
    /// When the database fails.
    pub fn note(&self, run: RunKey, what: &str) -> Result<(), StoreError> {
        Ok(log(&self.connection(), run, what)?)
    }

    /// Whether there is such a run.
    ///
    /// # Errors
    /// When the database fails.
    pub fn has_run(&self, run: RunKey) -> Result<bool, StoreError> {
        Ok(self
            .reader()
            .prepare_cached("SELECT 1 FROM runs WHERE seq = ?1")?
            .exists([run])?)
    }

    /// Robot-steps that a run had done when it was last let go of; `None` when there is no such run.
    ///
    /// # Errors
    /// When the database fails.
    pub fn robot_steps_done(&self, run: RunKey) -> Result<Option<u64>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached("SELECT robot_steps_done FROM runs WHERE seq = ?1")?
            .query_row([run], |row| row.get(0).map(from_sql))
            .optional()?)
    }

    /// The jobs that have a run, oldest first.
    ///
    /// # Errors
    /// When the database fails.
    pub fn jobs_of(&self, run: RunKey) -> Result<Vec<JobKey>, StoreError> {
        Ok(jobs_of(&self.reader(), run)?)
    }

    /// The newest entries of a run's log, oldest first.
    ///
    /// # Errors
    /// When the database fails.
    pub fn run_log(&self, run: RunKey) -> Result<Vec<LogEntry>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached(
                "SELECT at, robot_steps_done, what FROM run_log WHERE run = ?1 ORDER BY seq",
            )?
            .query_map([run], |row| {
                Ok(LogEntry {
                    at: row.get(0)?,
                    robot_steps_done: row.get::<_, Option<i64>>(1)?.map(from_sql),
                    what: row.get(2)?,
                })
            })?
            .collect::<Result<_, _>>()?)
    }

    /// Changes the priority of a job. Returns whether it is there.
    ///
    /// # Errors
    /// When the database fails.
    pub fn set_priority(&self, job: JobKey, priority: i32) -> Result<bool, StoreError> {
        let changed = self
            .connection()
            .prepare_cached("UPDATE jobs SET priority = ?2 WHERE seq = ?1")?
            .execute(params![job, priority])?;
        Ok(changed > 0)
    }

    /// Every job whose priority is not 0.
    ///
    /// # Errors
    /// When the database fails.
    pub fn priorities(&self) -> Result<Vec<(JobKey, i32)>, StoreError> {
        Ok(self
            .connection()
            .prepare_cached("SELECT seq, priority FROM jobs WHERE priority <> 0")?
            .query_map([], |row| Ok((row.get(0)?, nearest_i32(row, "priority")?)))?
            .collect::<Result<_, _>>()?)
    }

    /// A job's document as it was posted, with what it was extended by; `None` where there is none.
    ///
    /// # Errors
    /// When the database fails.
    pub fn document(&self, job: JobKey) -> Result<Option<String>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached("SELECT document FROM jobs WHERE seq = ?1")?
            .query_row([job], |row| row.get(0))
            .optional()?
            .flatten())
    }

    /// Adds those runs to a job that it does not have, behind its others, and replaces its document
    /// and design. Returns how many there are.
    ///
    /// # Errors
    /// `QueueFull` or `TooLarge`; or `Store` when the database fails: what was added till then stays,
    /// and asking again adds the rest.
    pub fn extend_job(&self, seq: JobKey, job: &NewJob, limit: u64) -> Result<u64, CreateJobError> {
        let known: BTreeSet<String> = self
            .reader()
            .prepare("SELECT id FROM job_runs JOIN runs ON runs.seq = run WHERE job = ?1")?
            .query_map([seq], |row| row.get(0))?
            .collect::<Result<_, _>>()?;
        let is_fresh = |run: &&NewRun| !known.contains(&run.id);
        let fresh: Vec<&NewRun> = job.runs.iter().filter(is_fresh).collect();
        let reserved = self.reserved_runs.load(Relaxed);
        check_room(&self.reader(), reserved, fresh.len() as u64, limit)?;
        for runs in fresh.chunks(PART) {
            let mut connection = self.connection();
            let transaction = connection.transaction()?;
            add_part(&transaction, seq, runs)?;
            transaction.commit()?;
            drop(connection);
            self.breathe();
        }
        self.connection()
            .prepare_cached("UPDATE jobs SET document = ?2, design = ?3 WHERE seq = ?1")?
            .execute(params![seq, job.request.document, job.design])?;
        Ok(fresh.len() as u64)
    }
}

/// Adds runs behind the others of a job; they wait if the job does.
fn add_part(connection: &Connection, job: JobKey, runs: &[&NewRun]) -> rusqlite::Result<()> {
    let from: i64 = connection.query_row(
        "SELECT coalesce(max(ordinal) + 1, 0) FROM job_runs WHERE job = ?1",
        [job],
        |row| row.get(0),
    )?;
    add_runs(connection, job, from, runs.iter().copied())?;
    let part = Part::of(from, runs.len());
    requeue(connection, job, part)?;
    settle(connection, job, part)?;
    Ok(())
}

fn jobs_of(connection: &Connection, run: RunKey) -> rusqlite::Result<Vec<JobKey>> {
    connection
        .prepare_cached("SELECT DISTINCT job FROM job_runs WHERE run = ?1 ORDER BY job")?
        .query_map([run], |row| row.get(0))?
        .collect()
}

/// Holds a run that waits or runs.
fn held(connection: &Connection, run: RunKey, why: &str) -> rusqlite::Result<Option<StoppedRun>> {
    let held = connection
        .prepare_cached(
            "UPDATE runs SET state = 'paused', held = 1, pause_at_step = NULL
             WHERE seq = ?1 AND state IN ('queued', 'running') RETURNING seq, id",
        )?
        .query_row([run], stopped)
        .optional()?;
    if held.is_some() {
        log(connection, run, why)?;
    }
    Ok(held)
}

fn stopped(row: &rusqlite::Row<'_>) -> rusqlite::Result<StoppedRun> {
    Ok(StoppedRun {
        seq: row.get(0)?,
        id: row.get(1)?,
    })
}
