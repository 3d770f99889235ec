//! Jobs as they are shown: one, or a list, newest first, with sums over their runs.

use api::{RunCounts, State};
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OptionalExtension, Row, params};
use sha2::{Digest, Sha256};

use super::keys::{JobKey, RunKey};
use super::state::Intent;
use super::{Store, StoreError, from_sql, nearest_i32, shown_text};

/// A job as stored, with sums over its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct JobView {
    /// Key.
    pub seq: JobKey,
    /// Text given by who posted it.
    pub name: String,
    /// What its owner wants.
    pub intent: Intent,
    /// Jobs of higher priority come first.
    pub priority: i32,
    /// RFC 3339 in UTC.
    pub created_at: String,
    /// Its runs by state.
    pub counts: RunCounts,
    /// Robot-steps done of its runs that are not running.
    pub robot_steps_done: u64,
    /// Robot-steps in all of these runs.
    pub robot_steps_total: u64,
    /// Work done of these runs: robot-steps times what one costs.
    pub work_done: u64,
    /// Work in all of these runs.
    pub work_total: u64,
    /// Work that those of them have left that wait.
    pub work_left: u64,
    /// Its runs that are held by workers.
    pub running: Vec<RunningRun>,
}

/// A run that a worker holds, as it was when it was claimed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunningRun {
    /// Key.
    pub seq: RunKey,
    /// Robot-steps done before it was claimed.
    pub robot_steps_done: u64,
    /// Robot-steps in all.
    pub robot_steps_total: u64,
    /// About what a robot-step costs against one of the kinematic engine.
    pub step_cost: u32,
}

/// Jobs that are there as a whole.
pub(super) const COLUMNS: &str = "SELECT seq, name, intent, created_at, priority FROM jobs
    WHERE (unfinished IS NULL OR unfinished IN ('settling', 'retrying'))";

impl Store {
    /// A job; `None` when there is none of this key.
    ///
    /// # Errors
    /// When the database fails.
    pub fn job(&self, seq: JobKey) -> Result<Option<JobView>, StoreError> {
        let connection = self.reader();
        let found = connection
            .prepare_cached(&format!("{COLUMNS} AND seq = ?1"))?
            .query_row([seq], head)
            .optional()?;
        found.map(|head| view(&connection, head)).transpose()
    }

    /// What a job varies, as JSON; `None` for jobs of versions that did not store it.
    ///
    /// # Errors
    /// When the database fails.
    pub fn design(&self, seq: JobKey) -> Result<Option<String>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached("SELECT design FROM jobs WHERE seq = ?1")?
            .query_row([seq], |row| row.get(0))
            .optional()?
            .flatten())
    }

    /// Epochs that the finished runs of a job have together.
    ///
    /// # Errors
    /// When the database fails.
    pub fn epochs_done(&self, seq: JobKey) -> Result<u64, StoreError> {
        Ok(self
            .reader()
            .prepare_cached(
                "SELECT coalesce(sum(epochs_total), 0) FROM job_runs JOIN runs ON runs.seq = run
                 WHERE job = ?1 AND state = 'done'",
            )?
            .query_row([seq], |row| row.get(0).map(from_sql))?)
    }

    /// A digest of which runs a job has, where, and which of them are done.
    ///
    /// # Errors
    /// When the database fails.
    pub fn done_runs_sha256(&self, seq: JobKey) -> Result<[u8; 32], StoreError> {
        let connection = self.reader();
        let mut statement = connection.prepare_cached(
            "SELECT ordinal, run, state = 'done' FROM job_runs JOIN runs ON runs.seq = job_runs.run
             WHERE job = ?1 ORDER BY ordinal",
        )?;
        let mut rows = statement.query([seq])?;
        let mut digest = Sha256::new();
        while let Some(row) = rows.next()? {
            for column in 0..3 {
                digest.update(row.get::<_, i64>(column)?.to_le_bytes());
            }
        }
        Ok(digest.finalize().into())
    }

    /// A digest of what is stored of a job's runs, which are told by it: their places, ids, labels,
    /// states and results. `None` while one of them is under way.
    ///
    /// # Errors
    /// When the database fails.
    pub fn ended_runs_sha256(&self, seq: JobKey) -> Result<Option<[u8; 32]>, StoreError> {
        let connection = self.reader();
        let mut statement = connection.prepare_cached(
            "SELECT state IN ('queued', 'running', 'paused'), job, ordinal, id, label, state, reason,
                runs.results_version, result_sha256, cpu_ns_per_robot_step
             FROM job_runs JOIN runs ON runs.seq = job_runs.run
             LEFT JOIN results ON results.run = runs.seq
             WHERE job = ?1 ORDER BY ordinal",
        )?;
        let columns = statement.column_count();
        let mut rows = statement.query([seq])?;
        let mut digest = Sha256::new();
        while let Some(row) = rows.next()? {
            if row.get(0)? {
                return Ok(None);
            }
            for column in 1..columns {
                match row.get_ref(column)? {
                    ValueRef::Null => digest.update([0]),
                    ValueRef::Integer(number) => {
                        digest.update([1]);
                        digest.update(number.to_le_bytes());
                    }
                    ValueRef::Real(number) => {
                        digest.update([2]);
                        digest.update(number.to_le_bytes());
                    }
                    ValueRef::Text(bytes) | ValueRef::Blob(bytes) => {
                        digest.update([3]);
                        digest.update((bytes.len() as u64).to_le_bytes());
                        digest.update(bytes);
                    }
                }
            }
        }
        Ok(Some(digest.finalize().into()))
    }

    /// At most `limit` jobs, newest first, older than `before` when that is given.
    ///
    /// # Errors
    /// When the database fails.
    pub fn jobs(&self, before: Option<JobKey>, limit: u32) -> Result<Vec<JobView>, StoreError> {
        let connection = self.reader();
        let heads = connection
            .prepare_cached(&format!(
                "{COLUMNS} AND seq < ?1 ORDER BY seq DESC LIMIT ?2"
            ))?
            .query_map(params![before.unwrap_or(JobKey::MAX), limit], head)?
            .collect::<Result<Vec<_>, _>>()?;
        heads
            .into_iter()
            .map(|head| view(&connection, head))
            .collect()
    }
}

pub(super) type Head = (JobKey, String, String, String, i32);

pub(super) fn head(row: &Row<'_>) -> rusqlite::Result<Head> {
    Ok((
        row.get("seq")?,
        shown_text(row, "name")?,
        row.get("intent")?,
        shown_text(row, "created_at")?,
        nearest_i32(row, "priority")?,
    ))
}

pub(super) fn view(connection: &Connection, head: Head) -> Result<JobView, StoreError> {
    let (seq, name, intent, created_at, priority) = head;
    let mut view = JobView {
        seq,
        name,
        intent: Intent::from_name(&intent)?,
        priority,
        created_at,
        counts: RunCounts::default(),
        robot_steps_done: 0,
        robot_steps_total: 0,
        work_done: 0,
        work_total: 0,
        work_left: 0,
        running: Vec::new(),
    };
    let mut statement = connection.prepare_cached(
        "SELECT state, runs, robot_steps_done, robot_steps_total, work_done, work_total
         FROM job_totals WHERE job = ?1",
    )?;
    let mut rows = statement.query([seq])?;
    while let Some(row) = rows.next()? {
        let state = shown_text(row, "state")?;
        let count = from_sql(row.get(1)?);
        let (done, total) = (from_sql(row.get(2)?), from_sql(row.get(3)?));
        let (work_done, work_total) = (from_sql(row.get(4)?), from_sql(row.get(5)?));
        let counts = &mut view.counts;
        // What is no state was written outside of this program; `check` tells of it.
        let Some(state) = State::from_name(&state) else {
            continue;
        };
        *match state {
            State::Queued => &mut counts.queued,
            State::Running => &mut counts.running,
            State::Paused => &mut counts.paused,
            State::Done => &mut counts.done,
            State::Failed => &mut counts.failed,
            State::Cancelled => &mut counts.cancelled,
        } = count;
        let add = |sum: &mut u64, more: u64| *sum = sum.saturating_add(more);
        add(&mut counts.total, count);
        if state != State::Running {
            add(&mut view.robot_steps_done, done);
            add(&mut view.robot_steps_total, total);
            add(&mut view.work_done, work_done);
            add(&mut view.work_total, work_total);
        }
        if state == State::Queued {
            add(&mut view.work_left, work_total.saturating_sub(work_done));
        }
    }
    if view.counts.running > 0 {
        view.running = connection
            .prepare_cached(
                "SELECT run, robot_steps_done, robot_steps_total, step_cost
                 FROM runs JOIN job_runs ON job_runs.run = runs.seq
                 WHERE runs.state = 'running' AND job_runs.job = ?1",
            )?
            .query_map([seq], |row| {
                Ok(RunningRun {
                    seq: row.get(0)?,
                    robot_steps_done: from_sql(row.get(1)?),
                    robot_steps_total: from_sql(row.get(2)?),
                    step_cost: row.get::<_, i64>(3)?.try_into().unwrap_or(1),
                })
            })?
            .collect::<Result<Vec<_>, _>>()?;
    }
    Ok(view)
}
