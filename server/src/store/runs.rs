//! Runs: shared between the jobs that ask for the same spec, claimed by workers, ended once.

use api::RunResult;
use rusqlite::{Connection, OptionalExtension, Row, params};
use sha2::{Digest, Sha256};

use super::keys::{JobKey, RunKey};
use super::log::log;
use super::state::{Position, RunState};
use super::{Store, StoreError, from_sql, shown_text, to_sql};

/// A run that a worker may now step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClaimedRun {
    /// Key.
    pub seq: RunKey,
    /// Hash of the spec, in hex.
    pub id: String,
    /// The resolved spec, as JSON.
    pub spec: String,
    /// The step of its arena at which it is to be held.
    pub pause_at_step: Option<u64>,
    /// It goes on from a state of another run.
    pub has_origin: bool,
}

/// A run whose state was changed from outside, or that was deleted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoppedRun {
    /// Key.
    pub seq: RunKey,
    /// Hash of the spec, in hex.
    pub id: String,
}

/// A run as stored.
#[derive(Clone, Debug, PartialEq)]
pub struct RunView {
    /// Key.
    pub seq: RunKey,
    /// Hash of the spec, in hex.
    pub id: String,
    /// The job that it was found through, or the first that has it.
    pub job: JobKey,
    /// Place in that job.
    pub ordinal: u64,
    /// Seed.
    pub seed: u64,
    /// Name of the target arena.
    pub arena: String,
    /// Name of the method.
    pub method: String,
    /// What of the job's matrix it has, in words.
    pub label: String,
    /// Where it is in its life.
    pub state: RunState,
    /// Version of the simulation that it was or will be made by.
    pub results_version: u32,
    /// Counted epochs in all.
    pub epochs_total: u32,
    /// Robot-steps in all.
    pub robot_steps_total: u64,
    /// Where it goes on from, if it does not start at its beginning.
    pub origin: Option<api::RunOrigin>,
    /// What a paused run waits for, where it was not asked to pause.
    pub waits: Option<String>,
    /// Processor time a robot-step, nanoseconds, once it is done and where that is known.
    pub cpu_ns_per_robot_step: Option<f64>,
}

impl RunView {
    /// What it found, once it is done.
    pub fn result(&self) -> Option<&RunResult> {
        match &self.state {
            RunState::Done(result) => Some(result),
            _ => None,
        }
    }
}

/// Runs that are read at once.
const PAGE: u32 = 1_000;

pub(super) const VIEW: &str = "SELECT runs.seq, id, job, ordinal, seed, arena, method, state, phase,
        epochs_done, robot_steps_done, reason, waits_for, epochs_total, robot_steps_total, result, result_sha256, label,
        results_version, origin, cpu_ns_per_robot_step
    FROM job_runs JOIN runs ON runs.seq = job_runs.run
    LEFT JOIN results ON results.run = runs.seq";

/// Not of a job that is being stored or deleted.
pub(super) const VISIBLE: &str = "NOT EXISTS (SELECT 1 FROM jobs WHERE jobs.seq = job_runs.job
        AND unfinished IN ('creating', 'starting', 'deleting'))";

impl Store {
    /// Makes runs wait again that a dead process held; removes checkpoints that nothing needs.
    /// Returns every waiting run of every active job, in order of jobs and of places in them.
    ///
    /// # Errors
    /// When the database fails or the checkpoints cannot be listed.
    pub fn recover(&self) -> Result<Vec<(JobKey, RunKey)>, StoreError> {
        self.end_unfinished()?;
        let connection = self.connection();
        connection.execute(
            "UPDATE runs SET state = 'queued' WHERE state = 'running'",
            [],
        )?;
        self.start_anew(&connection)?;
        let unfinished = connection
            .prepare("SELECT id FROM runs WHERE state IN ('queued', 'paused')")?
            .query_map([], |row| row.get(0))?
            .collect::<Result<_, _>>()?;
        self.checkpoints().sweep(&unfinished)?;
        let forked = connection
            .prepare("SELECT id FROM runs WHERE origin IS NOT NULL")?
            .query_map([], |row| row.get(0))?
            .collect::<Result<_, _>>()?;
        self.origins().sweep(&forked)?;
        let waiting = connection
            .prepare(
                "SELECT job, run FROM job_runs JOIN jobs ON jobs.seq = job
                 JOIN runs ON runs.seq = run
                 WHERE runs.state = 'queued' AND jobs.intent = 'active' ORDER BY job, ordinal",
            )?
            .query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?
            .collect::<Result<_, _>>()?;
        Ok(waiting)
    }

    /// Makes unfinished runs of another results version start again under the present one.
    fn start_anew(&self, connection: &Connection) -> Result<(), StoreError> {
        let runs: Vec<String> = connection
            .prepare(
                "SELECT id FROM runs WHERE state IN ('queued', 'paused') AND results_version <> ?1",
            )?
            .query_map([swarm::RESULTS_VERSION], |row| row.get(0))?
            .collect::<Result<_, _>>()?;
        // Should the process end in between, the runs have their old version still.
        for run in &runs {
            self.checkpoints().remove(run);
        }
        if !runs.is_empty() {
            tracing::warn!(
                runs = runs.len(),
                "unfinished runs of another version of the simulation start again"
            );
            connection.execute(
                "UPDATE runs SET results_version = ?1, phase = NULL, epochs_done = 0,
                    robot_steps_done = 0
                 WHERE state IN ('queued', 'paused') AND results_version <> ?1",
                [swarm::RESULTS_VERSION],
            )?;
        }
        Ok(())
    }

    /// The job's waiting runs, in order.
    ///
    /// # Errors
    /// When the database fails.
    pub fn waiting(&self, job: JobKey) -> Result<Vec<RunKey>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached(
                "SELECT run FROM job_runs JOIN runs ON runs.seq = run
                 WHERE job = ?1 AND state = 'queued' ORDER BY ordinal",
            )?
            .query_map([job], |row| row.get(0))?
            .collect::<Result<_, _>>()?)
    }

    /// Makes a waiting run running; `None` when it does not wait any more.
    ///
    /// # Errors
    /// When the database fails.
    pub fn claim(&self, run: RunKey) -> Result<Option<ClaimedRun>, StoreError> {
        // After a crash it waits again anyway.
        Ok(self
            .unsynced_connection()
            .prepare_cached(
                "UPDATE runs SET state = 'running' WHERE seq = ?1 AND state = 'queued'
                 RETURNING seq, id, spec, pause_at_step, origin IS NOT NULL",
            )?
            .query_row([run], |row| {
                Ok(ClaimedRun {
                    seq: row.get(0)?,
                    id: row.get(1)?,
                    spec: row.get(2)?,
                    pause_at_step: row.get::<_, Option<i64>>(3)?.map(from_sql),
                    has_origin: row.get(4)?,
                })
            })
            .optional()?)
    }

    /// Stores how far a run is that its worker lets go of. A running one waits again. Returns
    /// whether it is still wanted, and with it its checkpoint.
    ///
    /// # Errors
    /// When the database fails.
    pub fn park(
        &self,
        run: RunKey,
        position: &Position,
        robot_steps_total: u64,
    ) -> Result<bool, StoreError> {
        let changed = self
            .connection()
            .prepare_cached(
                "UPDATE runs SET state = CASE state WHEN 'running' THEN 'queued' ELSE state END,
                    phase = ?2, epochs_done = ?3, robot_steps_done = ?4, robot_steps_total = ?5
                 WHERE seq = ?1 AND state IN ('queued', 'running', 'paused')",
            )?
            .execute(params![
                run,
                position.phase,
                position.epochs_done,
                to_sql(position.robot_steps_done),
                to_sql(robot_steps_total)
            ])?;
        Ok(changed > 0)
    }

    /// Ends a run by an error, unless it has ended otherwise meanwhile.
    ///
    /// # Errors
    /// When the database fails.
    pub fn fail(&self, run: RunKey, reason: &str) -> Result<(), StoreError> {
        self.connection()
            .prepare_cached(
                "UPDATE runs SET state = 'failed', reason = ?2
                 WHERE seq = ?1 AND state IN ('queued', 'running', 'paused')",
            )?
            .execute(params![run, reason])?;
        Ok(())
    }

    /// Cancels one run, in whatever jobs it is. Returns it when it was unfinished.
    ///
    /// # Errors
    /// When the database fails.
    pub fn cancel_run(&self, run: RunKey) -> Result<Option<StoppedRun>, StoreError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        let cancelled = transaction
            .prepare_cached(
                "UPDATE runs SET state = 'cancelled'
                 WHERE seq = ?1 AND state IN ('queued', 'running', 'paused') RETURNING seq, id",
            )?
            .query_row([run], |row| {
                Ok(StoppedRun {
                    seq: row.get(0)?,
                    id: row.get(1)?,
                })
            })
            .optional()?;
        if cancelled.is_some() {
            log(&transaction, run, "cancelled")?;
        }
        transaction.commit()?;
        Ok(cancelled)
    }

    /// Whether a run exists and has not ended.
    ///
    /// # Errors
    /// When the database fails.
    pub fn is_unfinished(&self, run: RunKey) -> Result<bool, StoreError> {
        Ok(self
            .reader()
            .prepare_cached(
                "SELECT EXISTS (SELECT 1 FROM runs
                 WHERE seq = ?1 AND state IN ('queued', 'running', 'paused'))",
            )?
            .query_row([run], |row| row.get(0))?)
    }

    /// A run by its id; `None` when there is none.
    ///
    /// # Errors
    /// When the database fails or holds what cannot be read.
    pub fn run(&self, id: &str) -> Result<Option<RunView>, StoreError> {
        self.reader()
            .prepare_cached(&format!(
                "{VIEW} WHERE id = ?1 AND {VISIBLE} ORDER BY job, ordinal LIMIT 1"
            ))?
            .query_row([id], |row| Ok(view(row)))
            .optional()?
            .transpose()
    }

    /// A run by its key; `None` when there is none.
    ///
    /// # Errors
    /// When the database fails or holds what cannot be read.
    pub fn run_by_key(&self, key: RunKey) -> Result<Option<RunView>, StoreError> {
        self.reader()
            .prepare_cached(&format!(
                "{VIEW} WHERE seq = ?1 AND {VISIBLE} ORDER BY job, ordinal LIMIT 1"
            ))?
            .query_row([key], |row| Ok(view(row)))
            .optional()?
            .transpose()
    }

    /// The resolved spec of a run, as JSON; `None` when there is no such run.
    ///
    /// # Errors
    /// When the database fails.
    pub fn spec(&self, run: RunKey) -> Result<Option<String>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached("SELECT spec FROM runs WHERE seq = ?1")?
            .query_row([run], |row| row.get(0))
            .optional()?)
    }

    /// Bytes of the resolved spec of a run; 0 when there is no such run.
    ///
    /// # Errors
    /// When the database fails.
    pub fn spec_bytes(&self, run: RunKey) -> Result<u64, StoreError> {
        let bytes = self
            .reader()
            .prepare_cached("SELECT octet_length(spec) FROM runs WHERE seq = ?1")?
            .query_row([run], |row| row.get(0))
            .optional()?;
        Ok(bytes.map_or(0, from_sql))
    }

    /// Every run of a job, in order; the database is not held from beginning to end.
    ///
    /// # Errors
    /// When the database fails or holds what cannot be read.
    pub fn all_runs(&self, job: JobKey) -> Result<Vec<RunView>, StoreError> {
        let mut runs: Vec<RunView> = Vec::new();
        loop {
            let from = runs.last().map_or(0, |run| run.ordinal + 1);
            let page = self.runs(job, from, PAGE)?;
            if page.is_empty() {
                return Ok(runs);
            }
            runs.extend(page);
        }
    }

    /// At most `limit` runs of a job from place `from` on, in order.
    ///
    /// # Errors
    /// When the database fails or holds what cannot be read.
    pub fn runs(&self, job: JobKey, from: u64, limit: u32) -> Result<Vec<RunView>, StoreError> {
        self.reader()
            .prepare_cached(&format!(
                "{VIEW} WHERE job = ?1 AND ordinal >= ?2 ORDER BY ordinal LIMIT ?3"
            ))?
            .query_map(params![job, to_sql(from), limit], |row| Ok(view(row)))?
            .collect::<Result<Vec<_>, _>>()?
            .into_iter()
            .collect()
    }
}

/// A row as a run. One that cannot be read does not take a whole list with it: it is a run that
/// says so.
pub(super) fn view(row: &Row<'_>) -> Result<RunView, StoreError> {
    view_whole(row).or_else(|error| {
        let id = shown_text(row, "id")?;
        tracing::error!(run = id, %error, "a run cannot be read");
        Ok(RunView {
            waits: None,
            seq: row.get("seq")?,
            id,
            job: row.get("job")?,
            ordinal: from_sql(row.get("ordinal")?),
            seed: row.get("seed").map_or(0, from_sql),
            arena: row.get("arena").unwrap_or_default(),
            method: row.get("method").unwrap_or_default(),
            label: row.get("label").unwrap_or_default(),
            state: RunState::Damaged {
                reason: error.to_string(),
            },
            results_version: row.get("results_version").unwrap_or_default(),
            epochs_total: row.get("epochs_total").unwrap_or_default(),
            robot_steps_total: row.get("robot_steps_total").map_or(0, from_sql),
            origin: None,
            cpu_ns_per_robot_step: None,
        })
    })
}

fn view_whole(row: &Row<'_>) -> Result<RunView, StoreError> {
    let id: String = row.get("id")?;
    let state: String = row.get("state")?;
    let phase: Option<String> = row.get("phase")?;
    let epochs_done = row.get("epochs_done")?;
    let robot_steps_done = from_sql(row.get("robot_steps_done")?);
    let position = phase.map(|phase| Position {
        phase,
        epochs_done,
        robot_steps_done,
    });
    let result: Option<String> = row.get("result")?;
    let digest: Option<Vec<u8>> = row.get("result_sha256")?;
    let origin: Option<String> = row.get("origin")?;
    let result = result
        .map(|text| read_result(&text, digest.as_deref()))
        .transpose()
        .map_err(|why| StoreError::damaged("result", &id, why))?;
    let origin = origin
        .map(|text| serde_json::from_str(&text))
        .transpose()
        .map_err(|why| StoreError::damaged("origin", &id, why))?;
    let waits: Option<String> = row.get("waits_for")?;
    let waits = waits.filter(|_| state == "paused");
    Ok(RunView {
        seq: row.get("seq")?,
        id,
        waits,
        job: row.get("job")?,
        ordinal: from_sql(row.get("ordinal")?),
        seed: from_sql(row.get("seed")?),
        arena: row.get("arena")?,
        method: row.get("method")?,
        label: row.get("label")?,
        state: RunState::from_columns(&state, position, row.get("reason")?, result)?,
        results_version: row.get("results_version")?,
        epochs_total: row.get("epochs_total")?,
        robot_steps_total: from_sql(row.get("robot_steps_total")?),
        origin,
        cpu_ns_per_robot_step: row.get("cpu_ns_per_robot_step")?,
    })
}

fn read_result(text: &str, digest: Option<&[u8]>) -> Result<RunResult, String> {
    if digest != Some(&Sha256::digest(text)[..]) {
        return Err("its digest does not match".to_owned());
    }
    serde_json::from_str(text).map_err(|error| error.to_string())
}
