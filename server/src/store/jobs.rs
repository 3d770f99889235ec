//! Jobs: created once (idempotency keys), listed newest first, paused, resumed, cancelled, deleted.

use api::{RunCounts, State};
use rusqlite::{Connection, OptionalExtension, Row, params};
use sha2::{Digest, Sha256};

use super::keys::{JobKey, RunKey};
use super::runs::{StoppedRun, settle};
use super::state::Intent;
use super::{Store, StoreError, from_sql, to_sql};

/// A run to be stored.
#[derive(Clone, Debug)]
pub struct NewRun {
    /// Hash of the spec, in hex.
    pub id: String,
    /// The spec with every default filled in, as JSON.
    pub spec: String,
    /// Seed.
    pub seed: u64,
    /// Name of the target arena.
    pub arena: String,
    /// Name of the method.
    pub method: String,
    /// Counted epochs.
    pub epochs_total: u32,
    /// Robot-steps in all, as far as that is known before it starts.
    pub robot_steps_total: u64,
    /// About what a robot-step costs against one of the kinematic engine.
    pub step_cost: u32,
    /// Names of the uploaded arenas that it uses.
    pub uploaded_arenas: Vec<String>,
    /// What of the job's matrix it has, in words.
    pub label: String,
}

/// What tells a request for a job from others.
#[derive(Clone, Debug)]
pub struct JobRequest {
    /// SHA-256 of the request's body, in hex.
    pub sha256: String,
    /// The header `Idempotency-Key`, which makes a repeated request harmless.
    pub idempotency_key: Option<String>,
}

impl JobRequest {
    /// A request with this body.
    pub fn new(body: &[u8], idempotency_key: Option<String>) -> Self {
        let digest = Sha256::digest(body);
        Self {
            sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
            idempotency_key,
        }
    }
}

/// A job to be stored.
#[derive(Clone, Debug)]
pub struct NewJob {
    /// Text given by who posted it.
    pub name: String,
    /// What it varies, as JSON.
    pub design: String,
    /// The request that asked for it.
    pub request: JobRequest,
    /// Its runs in order; one that is stored already is shared.
    pub runs: Vec<NewRun>,
}

/// What became of a job to be stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Created {
    /// It is stored; holds the runs that wait, in order.
    New(JobKey, Vec<RunKey>),
    /// The same request had been stored before.
    Replayed(JobKey),
}

/// Why a job was not stored.
#[derive(Debug, thiserror::Error)]
pub enum CreateJobError {
    /// The key was used with another body.
    #[error("the idempotency key was used for another request")]
    KeyReused,
    /// Too many runs wait already.
    #[error("{unfinished} runs wait or run already; {limit} are allowed")]
    QueueFull {
        /// Runs that are not finished.
        unfinished: u64,
        /// Most that may be unfinished.
        limit: u64,
    },
    /// It would not fit even if nothing else waited.
    #[error("the job has {runs} runs; at most {limit} may be unfinished")]
    TooLarge {
        /// Its runs.
        runs: u64,
        /// Most that may be unfinished.
        limit: u64,
    },
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl From<rusqlite::Error> for CreateJobError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Store(error.into())
    }
}

/// A job as stored, with sums over its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct JobView {
    /// Key.
    pub seq: JobKey,
    /// Text given by who posted it.
    pub name: String,
    /// What its owner wants.
    pub intent: Intent,
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

pub(super) const COLUMNS: &str = "SELECT seq, name, intent, created_at FROM jobs";

impl Store {
    /// Stores a job and its runs as one, durably. Runs that are stored already are shared: done
    /// ones are not computed again, cancelled, failed and paused ones wait again.
    ///
    /// # Errors
    /// `KeyReused`, `QueueFull`, `TooLarge`, or `Store` when the database fails; nothing is stored then.
    pub fn create_job(&self, job: &NewJob, limit: u64) -> Result<Created, CreateJobError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        if let Some(seq) = admit(&transaction, &job.request, job.runs.len() as u64, limit)? {
            return Ok(Created::Replayed(seq));
        }
        let seq: JobKey = transaction
            .prepare_cached(
                "INSERT INTO jobs (name, request_sha256, idempotency_key, design)
                 VALUES (?1, ?2, ?3, ?4) RETURNING seq",
            )?
            .query_row(
                params![
                    job.name,
                    job.request.sha256,
                    job.request.idempotency_key,
                    job.design
                ],
                |row| row.get(0),
            )?;
        let mut waiting = Vec::new();
        for (ordinal, run) in job.runs.iter().enumerate() {
            let (run_seq, waits) = add_run(&transaction, run)?;
            if waits {
                waiting.push(run_seq);
            }
            transaction
                .prepare_cached(
                    "INSERT INTO job_runs (job, ordinal, run, label) VALUES (?1, ?2, ?3, ?4)",
                )?
                .execute(params![seq, to_sql(ordinal as u64), run_seq, run.label])?;
        }
        transaction.commit()?;
        Ok(Created::New(seq, waiting))
    }

    /// Whether [`Self::create_job`] would take a job of so many runs right now. Returns the job
    /// that the same request made before, if it did.
    ///
    /// # Errors
    /// As there.
    pub fn admit(
        &self,
        request: &JobRequest,
        runs: u64,
        limit: u64,
    ) -> Result<Option<JobKey>, CreateJobError> {
        admit(&self.connection(), request, runs, limit)
    }

    /// A job; `None` when there is none of this key.
    ///
    /// # Errors
    /// When the database fails.
    pub fn job(&self, seq: JobKey) -> Result<Option<JobView>, StoreError> {
        let connection = self.connection();
        let found = connection
            .prepare_cached(&format!("{COLUMNS} WHERE seq = ?1"))?
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
            .connection()
            .prepare_cached("SELECT design FROM jobs WHERE seq = ?1")?
            .query_row([seq], |row| row.get(0))
            .optional()?
            .flatten())
    }

    /// At most `limit` jobs, newest first, older than `before` when that is given.
    ///
    /// # Errors
    /// When the database fails.
    pub fn jobs(&self, before: Option<JobKey>, limit: u32) -> Result<Vec<JobView>, StoreError> {
        let connection = self.connection();
        let heads = connection
            .prepare_cached(&format!(
                "{COLUMNS} WHERE seq < ?1 ORDER BY seq DESC LIMIT ?2"
            ))?
            .query_map(params![before.unwrap_or(JobKey::MAX), limit], head)?
            .collect::<Result<Vec<_>, _>>()?;
        heads
            .into_iter()
            .map(|head| view(&connection, head))
            .collect()
    }

    /// Changes what is wanted of a job and, with it, the state of its unfinished runs: a run goes on
    /// while any of its jobs wants it. Returns the runs whose state changed.
    ///
    /// # Errors
    /// When the database fails; nothing is changed then.
    pub fn set_intent(&self, seq: JobKey, intent: Intent) -> Result<Vec<StoppedRun>, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        transaction
            .prepare_cached("UPDATE jobs SET intent = ?2 WHERE seq = ?1")?
            .execute(params![seq, intent.name()])?;
        let changed = settle(&transaction, seq)?;
        transaction.commit()?;
        Ok(changed)
    }

    /// Makes the failed and cancelled runs of a job wait again, from their beginning, and the job
    /// active.
    ///
    /// # Errors
    /// When the database fails; nothing is changed then.
    pub fn retry(&self, seq: JobKey) -> Result<(), StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        transaction
            .prepare_cached("UPDATE jobs SET intent = 'active' WHERE seq = ?1")?
            .execute([seq])?;
        transaction
            .prepare_cached(
                "UPDATE runs SET state = 'queued', reason = NULL, phase = NULL,
                    epochs_done = 0, robot_steps_done = 0
                 WHERE state IN ('failed', 'cancelled')
                    AND seq IN (SELECT run FROM job_runs WHERE job = ?1)",
            )?
            .execute([seq])?;
        settle(&transaction, seq)?;
        transaction.commit()?;
        Ok(())
    }

    /// Deletes a job, and its runs and results that no other job has. Returns the runs whose state
    /// changed or that are gone.
    ///
    /// # Errors
    /// When the database fails; nothing is changed then.
    pub fn delete_job(&self, seq: JobKey) -> Result<Vec<StoppedRun>, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        transaction.execute("UPDATE jobs SET intent = 'cancelled' WHERE seq = ?1", [seq])?;
        let mut changed = settle(&transaction, seq)?;
        let alone = transaction
            .prepare(
                "SELECT DISTINCT runs.seq, runs.id FROM runs JOIN job_runs ON job_runs.run = runs.seq
                 WHERE job_runs.job = ?1 AND NOT EXISTS (
                    SELECT 1 FROM job_runs other WHERE other.run = runs.seq AND other.job <> ?1)",
            )?
            .query_map([seq], |row| Ok(StoppedRun { seq: row.get(0)?, id: row.get(1)? }))?
            .collect::<Result<Vec<_>, _>>()?;
        transaction.execute("DELETE FROM jobs WHERE seq = ?1", [seq])?;
        for run in &alone {
            transaction
                .prepare_cached("DELETE FROM runs WHERE seq = ?1")?
                .execute([run.seq])?;
        }
        transaction.commit()?;
        changed.extend(alone);
        Ok(changed)
    }
}

fn admit(
    connection: &Connection,
    request: &JobRequest,
    runs: u64,
    limit: u64,
) -> Result<Option<JobKey>, CreateJobError> {
    if let Some(key) = &request.idempotency_key {
        let earlier: Option<(JobKey, String)> = connection
            .prepare_cached("SELECT seq, request_sha256 FROM jobs WHERE idempotency_key = ?1")?
            .query_row([key], |row| Ok((row.get(0)?, row.get(1)?)))
            .optional()?;
        match earlier {
            Some((seq, digest)) if digest == request.sha256 => return Ok(Some(seq)),
            Some(_) => return Err(CreateJobError::KeyReused),
            None => {}
        }
    }
    let unfinished = from_sql(connection.query_row(
        "SELECT count(*) FROM runs WHERE state IN ('queued', 'running', 'paused')",
        [],
        |row| row.get(0),
    )?);
    if runs > limit {
        return Err(CreateJobError::TooLarge { runs, limit });
    }
    if unfinished + runs > limit {
        return Err(CreateJobError::QueueFull { unfinished, limit });
    }
    Ok(None)
}

/// Stores a run or finds it; returns its key and whether it waits for a worker.
fn add_run(connection: &Connection, run: &NewRun) -> rusqlite::Result<(RunKey, bool)> {
    connection
        .prepare_cached(
            "INSERT INTO runs
                (id, seed, arena, method, epochs_total, robot_steps_total, step_cost, spec)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)
             ON CONFLICT (id) DO UPDATE SET
                phase = CASE state WHEN 'paused' THEN phase END,
                epochs_done = CASE state WHEN 'paused' THEN epochs_done ELSE 0 END,
                robot_steps_done = CASE state WHEN 'paused' THEN robot_steps_done ELSE 0 END,
                robot_steps_total = excluded.robot_steps_total,
                state = 'queued', reason = NULL
             WHERE state IN ('paused', 'failed', 'cancelled')",
        )?
        .execute(params![
            run.id,
            to_sql(run.seed),
            run.arena,
            run.method,
            run.epochs_total,
            to_sql(run.robot_steps_total),
            run.step_cost,
            run.spec
        ])?;
    let (seq, waits) = connection
        .prepare_cached("SELECT seq, state = 'queued' FROM runs WHERE id = ?1")?
        .query_row([&run.id], |row| Ok((row.get(0)?, row.get(1)?)))?;
    for arena in &run.uploaded_arenas {
        connection
            .prepare_cached("INSERT OR IGNORE INTO run_arenas (run, arena) VALUES (?1, ?2)")?
            .execute(params![seq, arena])?;
    }
    Ok((seq, waits))
}

pub(super) type Head = (JobKey, String, String, String);

pub(super) fn head(row: &Row<'_>) -> rusqlite::Result<Head> {
    Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?))
}

pub(super) fn view(connection: &Connection, head: Head) -> Result<JobView, StoreError> {
    let (seq, name, intent, created_at) = head;
    let mut view = JobView {
        seq,
        name,
        intent: Intent::from_name(&intent)?,
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
        "SELECT state, count(*), sum(robot_steps_done), sum(robot_steps_total),
            sum(robot_steps_done * step_cost), sum(robot_steps_total * step_cost)
         FROM job_runs JOIN runs ON runs.seq = job_runs.run WHERE job = ?1 GROUP BY state",
    )?;
    let mut rows = statement.query([seq])?;
    while let Some(row) = rows.next()? {
        let state: String = row.get(0)?;
        let count = from_sql(row.get(1)?);
        let (done, total) = (from_sql(row.get(2)?), from_sql(row.get(3)?));
        let (work_done, work_total) = (from_sql(row.get(4)?), from_sql(row.get(5)?));
        let counts = &mut view.counts;
        let state =
            State::from_name(&state).ok_or_else(|| StoreError::unreadable("run state", &state))?;
        *match state {
            State::Queued => &mut counts.queued,
            State::Running => &mut counts.running,
            State::Paused => &mut counts.paused,
            State::Done => &mut counts.done,
            State::Failed => &mut counts.failed,
            State::Cancelled => &mut counts.cancelled,
        } = count;
        counts.total += count;
        if state != State::Running {
            view.robot_steps_done += done;
            view.robot_steps_total += total;
            view.work_done += work_done;
            view.work_total += work_total;
        }
        if state == State::Queued {
            view.work_left += work_total.saturating_sub(work_done);
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
                    step_cost: row.get(3)?,
                })
            })?
            .collect::<Result<Vec<_>, _>>()?;
    }
    Ok(view)
}
