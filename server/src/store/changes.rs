//! What changes all runs of a job: pause, resume, cancel, retry, delete. It is written down first
//! what the job is in the middle of, then its runs are changed in transactions of bounded size; the
//! next start ends what a crash cut short.

use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

use rusqlite::{Connection, params};

use super::keys::JobKey;
use super::runs::StoppedRun;
use super::state::Intent;
use super::{Store, StoreError, to_sql};
use crate::break_points::{Place, reach};

/// Runs that are changed in one transaction.
pub const PART: usize = 500;

/// Time between two looks whether others still wait for their turn.
const BREATH: Duration = Duration::from_millis(1);
/// Most looks between two transactions, should others come without end.
const MOST_BREATHS: u32 = 50;

/// Places in a job, from the first to before the second.
#[derive(Clone, Copy)]
pub struct Part {
    pub from: i64,
    pub to: i64,
}

impl Part {
    /// So many places from this one on.
    pub fn of(from: i64, places: usize) -> Self {
        Self {
            from,
            to: from + to_sql(places as u64),
        }
    }
}

/// What becomes of a job after the last part.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Closing {
    /// It is in the middle of nothing any more.
    Done,
    /// Its runs are settled next.
    Settling,
    /// It is gone.
    Gone,
}

impl Store {
    /// Changes what is wanted of a job and, with it, the state of its unfinished runs: a run goes on
    /// while any of its jobs wants it. Returns the runs whose state changed.
    ///
    /// # Errors
    /// When the database fails; the next start ends what was begun then.
    pub fn set_intent(&self, seq: JobKey, intent: Intent) -> Result<Vec<StoppedRun>, StoreError> {
        self.connection()
            .prepare_cached("UPDATE jobs SET intent = ?2, unfinished = 'settling' WHERE seq = ?1")?
            .execute(params![seq, intent.name()])?;
        let mut changed = Vec::new();
        if intent == Intent::Active {
            self.in_parts(seq, Closing::Settling, hold_no_more)?;
        }
        self.settle_in_parts(seq, &mut changed)?;
        Ok(changed)
    }

    /// Makes the failed and cancelled runs of a job wait again, from their beginning, and the job
    /// active.
    ///
    /// # Errors
    /// As for [`Self::set_intent`].
    pub fn retry(&self, seq: JobKey) -> Result<(), StoreError> {
        self.connection()
            .prepare_cached(
                "UPDATE jobs SET intent = 'active', unfinished = 'retrying' WHERE seq = ?1",
            )?
            .execute([seq])?;
        self.in_parts(seq, Closing::Done, requeue)
    }

    /// Deletes a job, and its runs and results that no other job has. Returns the runs whose state
    /// changed or that are gone.
    ///
    /// # Errors
    /// As for [`Self::set_intent`].
    pub fn delete_job(&self, seq: JobKey) -> Result<Vec<StoppedRun>, StoreError> {
        self.connection()
            .prepare_cached(
                "UPDATE jobs SET intent = 'cancelled', unfinished = 'deleting' WHERE seq = ?1",
            )?
            .execute([seq])?;
        let mut changed = Vec::new();
        self.delete_in_parts(seq, &mut changed)?;
        Ok(changed)
    }

    /// Ends what jobs were in the middle of when the process died.
    pub(super) fn end_unfinished(&self) -> Result<(), StoreError> {
        let jobs: Vec<(JobKey, String)> = self
            .connection()
            .prepare("SELECT seq, unfinished FROM jobs WHERE unfinished IS NOT NULL ORDER BY seq")?
            .query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?
            .collect::<Result<_, _>>()?;
        for (job, unfinished) in jobs {
            tracing::info!(%job, unfinished, "ending what a job was in the middle of");
            match unfinished.as_str() {
                "creating" | "deleting" => drop(self.delete_job(job)?),
                "settling" => self.settle_in_parts(job, &mut Vec::new())?,
                _ => self.in_parts(job, Closing::Done, requeue)?,
            }
        }
        Ok(())
    }

    pub(super) fn set_unfinished(&self, seq: JobKey, what: &str) -> Result<(), StoreError> {
        self.connection()
            .prepare_cached("UPDATE jobs SET unfinished = ?2 WHERE seq = ?1")?
            .execute(params![seq, what])?;
        Ok(())
    }

    fn settle_in_parts(
        &self,
        seq: JobKey,
        changed: &mut Vec<StoppedRun>,
    ) -> Result<(), StoreError> {
        self.in_parts(seq, Closing::Done, |connection, seq, part| {
            changed.extend(settle(connection, seq, part)?);
            Ok(())
        })
    }

    fn delete_in_parts(
        &self,
        seq: JobKey,
        changed: &mut Vec<StoppedRun>,
    ) -> Result<(), StoreError> {
        self.in_parts(seq, Closing::Gone, |connection, seq, part| {
            changed.extend(settle(connection, seq, part)?);
            changed.extend(delete(connection, seq, part)?);
            Ok(())
        })
    }

    /// Changes a job's runs, a part in a transaction.
    pub(super) fn in_parts(
        &self,
        seq: JobKey,
        closing: Closing,
        mut change: impl FnMut(&Connection, JobKey, Part) -> rusqlite::Result<()>,
    ) -> Result<(), StoreError> {
        let mut from = 0;
        loop {
            let part = Part::of(from, PART);
            let mut connection = self.connection();
            let transaction = connection.transaction()?;
            change(&transaction, seq, part)?;
            let goes_on: bool = transaction
                .prepare_cached(
                    "SELECT EXISTS (SELECT 1 FROM job_runs WHERE job = ?1 AND ordinal >= ?2)",
                )?
                .query_row(params![seq, part.to], |row| row.get(0))?;
            if !goes_on {
                let close = match closing {
                    Closing::Done => "UPDATE jobs SET unfinished = NULL WHERE seq = ?1",
                    Closing::Settling => "UPDATE jobs SET unfinished = 'settling' WHERE seq = ?1",
                    Closing::Gone => "DELETE FROM jobs WHERE seq = ?1",
                };
                transaction.prepare_cached(close)?.execute([seq])?;
            }
            transaction.commit()?;
            drop(connection);
            reach(Place::JobChanged);
            if !goes_on {
                return Ok(());
            }
            self.breathe();
            from = part.to;
        }
    }

    /// Lets those have the connection who wait for it.
    pub(super) fn breathe(&self) {
        for _ in 0..MOST_BREATHS {
            if self.waiting_writers.load(Relaxed) == 0 {
                return;
            }
            std::thread::sleep(BREATH);
        }
    }
}

/// Makes runs wait that do not: those of a job that is posted or tried again.
pub fn requeue(connection: &Connection, job: JobKey, part: Part) -> rusqlite::Result<()> {
    connection
        .prepare_cached(
            "UPDATE runs SET
                phase = CASE state WHEN 'paused' THEN phase END,
                epochs_done = CASE state WHEN 'paused' THEN epochs_done ELSE 0 END,
                robot_steps_done = CASE state WHEN 'paused' THEN robot_steps_done ELSE 0 END,
                results_version = ?4, state = 'queued', reason = NULL, held = 0, pause_at_step = NULL
             WHERE state IN ('paused', 'failed', 'cancelled') AND seq IN (
                SELECT run FROM job_runs WHERE job = ?1 AND ordinal >= ?2 AND ordinal < ?3)",
        )?
        .execute(params![job, part.from, part.to, swarm::RESULTS_VERSION])?;
    Ok(())
}

/// Runs that were held one by one do what their jobs want again.
fn hold_no_more(connection: &Connection, job: JobKey, part: Part) -> rusqlite::Result<()> {
    connection
        .prepare_cached(
            "UPDATE runs SET held = 0, pause_at_step = NULL WHERE held = 1 AND seq IN (
                SELECT run FROM job_runs WHERE job = ?1 AND ordinal >= ?2 AND ordinal < ?3)",
        )?
        .execute(params![job, part.from, part.to])?;
    Ok(())
}

/// Brings the unfinished runs of a part of a job in line with what their jobs want: run, hold or
/// drop.
pub(super) fn settle(
    connection: &Connection,
    job: JobKey,
    part: Part,
) -> rusqlite::Result<Vec<StoppedRun>> {
    connection
        .prepare_cached(
            "WITH wants AS MATERIALIZED (
                SELECT mine.run AS run, max(CASE jobs.intent WHEN 'active' THEN 2 WHEN 'paused' THEN 1 ELSE 0 END) AS want
                FROM job_runs mine CROSS JOIN job_runs every ON every.run = mine.run
                JOIN jobs ON jobs.seq = every.job
                WHERE mine.job = ?1 AND mine.ordinal >= ?2 AND mine.ordinal < ?3 GROUP BY mine.run)
             UPDATE runs SET state = CASE want WHEN 2 THEN 'queued' WHEN 1 THEN 'paused' ELSE 'cancelled' END
             FROM wants WHERE runs.seq = wants.run AND (
                (want = 2 AND state = 'paused' AND held = 0)
                OR (want = 1 AND state IN ('queued', 'running'))
                OR (want = 0 AND state IN ('queued', 'running', 'paused')))
             RETURNING seq, id",
        )?
        .query_map(params![job, part.from, part.to], stopped)?
        .collect()
}

/// Takes the runs of a part out of a job, and deletes those that no other job has.
fn delete(connection: &Connection, job: JobKey, part: Part) -> rusqlite::Result<Vec<StoppedRun>> {
    let alone: Vec<StoppedRun> = connection
        .prepare_cached(
            "SELECT DISTINCT runs.seq, runs.id FROM job_runs mine JOIN runs ON runs.seq = mine.run
             WHERE mine.job = ?1 AND mine.ordinal >= ?2 AND mine.ordinal < ?3 AND NOT EXISTS (
                SELECT 1 FROM job_runs other WHERE other.run = mine.run
                    AND (other.job <> ?1 OR other.ordinal >= ?3))",
        )?
        .query_map(params![job, part.from, part.to], stopped)?
        .collect::<Result<_, _>>()?;
    connection
        .prepare_cached("DELETE FROM job_runs WHERE job = ?1 AND ordinal >= ?2 AND ordinal < ?3")?
        .execute(params![job, part.from, part.to])?;
    for run in &alone {
        connection
            .prepare_cached("DELETE FROM runs WHERE seq = ?1")?
            .execute([run.seq])?;
    }
    Ok(alone)
}

fn stopped(row: &rusqlite::Row<'_>) -> rusqlite::Result<StoppedRun> {
    Ok(StoppedRun {
        seq: row.get(0)?,
        id: row.get(1)?,
    })
}
