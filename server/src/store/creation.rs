//! Storing a job: in transactions of bounded size, so that others get their turn; a job that fits
//! into one is stored as one. The job is seen once all of it is there; of one that a crash cut short
//! nothing is left after the next start.

use std::sync::atomic::Ordering::Relaxed;

use rusqlite::{Connection, OptionalExtension, params};
use sha2::{Digest, Sha256};

use super::changes::{Closing, PART, Part, requeue};
use super::keys::{JobKey, RunKey};
use super::{Store, StoreError, from_sql, to_sql};
use crate::break_points::{Place, reach};

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
    /// Where it goes on from, as JSON, if it does not start at its beginning.
    pub origin: Option<String>,
}

/// What tells a request for a job from others.
#[derive(Clone, Debug)]
pub struct JobRequest {
    /// SHA-256 of the request's body, in hex.
    pub sha256: String,
    /// The header `Idempotency-Key`, which makes a repeated request harmless.
    pub idempotency_key: Option<String>,
    /// The body, where it is the job's document.
    pub document: Option<String>,
}

impl JobRequest {
    /// A request with this body.
    pub fn new(body: &[u8], idempotency_key: Option<String>) -> Self {
        Self {
            sha256: hex::encode(Sha256::digest(body)),
            idempotency_key,
            document: None,
        }
    }

    /// A request whose body is the job's document.
    pub fn of_document(body: &[u8], idempotency_key: Option<String>) -> Self {
        Self {
            document: String::from_utf8(body.to_vec()).ok(),
            ..Self::new(body, idempotency_key)
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
    /// The same request is being stored, or its job deleted, at this moment.
    #[error("another request with this idempotency key is under way")]
    UnderWay,
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

/// Runs of jobs that are being stored for which there is room, but no row yet.
struct Reserved<'a> {
    store: &'a Store,
    runs: u64,
}

impl Reserved<'_> {
    fn spend(&mut self, runs: u64) {
        let spent = runs.min(self.runs);
        self.runs -= spent;
        self.store.reserved_runs.fetch_sub(spent, Relaxed);
    }
}

impl Drop for Reserved<'_> {
    fn drop(&mut self) {
        self.spend(self.runs);
    }
}

impl Store {
    /// Stores a job and its runs, durably. Runs that are stored already are shared: done ones are
    /// not computed again, cancelled, failed and paused ones wait again.
    ///
    /// # Errors
    /// `KeyReused`, `UnderWay`, `QueueFull`, `TooLarge`, or `Store` when the database fails; nothing
    /// is stored then.
    pub fn create_job(&self, job: &NewJob, limit: u64) -> Result<Created, CreateJobError> {
        if job.runs.len() <= PART {
            return self.create_at_once(job, limit);
        }
        let (seq, reserved) = match self.begin(job, limit)? {
            Begun::New(seq, reserved) => (seq, reserved),
            Begun::Replayed(seq) => return Ok(Created::Replayed(seq)),
        };
        let stored = self.fill(seq, job, reserved);
        if let Err(error) = stored {
            if let Err(error) = self.delete_job(seq) {
                tracing::warn!(job = %seq, %error, "what there is of a job goes at the next start");
            }
            return Err(error.into());
        }
        reach(Place::JobStored);
        Ok(Created::New(seq, self.waiting(seq)?))
    }

    fn create_at_once(&self, job: &NewJob, limit: u64) -> Result<Created, CreateJobError> {
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        let reserved = self.reserved_runs.load(Relaxed);
        let runs = job.runs.len() as u64;
        if let Some(seq) = admit(&transaction, &job.request, reserved, runs, limit)? {
            return Ok(Created::Replayed(seq));
        }
        let seq = add_job(&transaction, job, None)?;
        add_runs(&transaction, seq, 0, &job.runs)?;
        requeue(&transaction, seq, Part::of(0, job.runs.len()))?;
        transaction.commit()?;
        drop(connection);
        reach(Place::JobStored);
        Ok(Created::New(seq, self.waiting(seq)?))
    }

    fn begin(&self, job: &NewJob, limit: u64) -> Result<Begun<'_>, CreateJobError> {
        let runs = job.runs.len() as u64;
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        let reserved = self.reserved_runs.load(Relaxed);
        if let Some(seq) = admit(&transaction, &job.request, reserved, runs, limit)? {
            return Ok(Begun::Replayed(seq));
        }
        let seq = add_job(&transaction, job, Some("creating"))?;
        transaction.commit()?;
        // Under the connection's mutex, as all requests for room are.
        self.reserved_runs.fetch_add(runs, Relaxed);
        Ok(Begun::New(seq, Reserved { store: self, runs }))
    }

    fn fill(
        &self,
        seq: JobKey,
        job: &NewJob,
        mut reserved: Reserved<'_>,
    ) -> Result<(), StoreError> {
        for (part, runs) in job.runs.chunks(PART).enumerate() {
            let mut connection = self.connection();
            let transaction = connection.transaction()?;
            add_runs(&transaction, seq, to_sql((part * PART) as u64), runs)?;
            transaction.commit()?;
            reserved.spend(runs.len() as u64);
            drop(connection);
            reach(Place::JobPart);
            self.breathe();
        }
        self.set_unfinished(seq, "starting")?;
        self.in_parts(seq, Closing::Done, requeue)
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
        let reserved = self.reserved_runs.load(Relaxed);
        admit(&self.reader(), request, reserved, runs, limit)
    }
}

fn add_job(
    connection: &Connection,
    job: &NewJob,
    unfinished: Option<&str>,
) -> rusqlite::Result<JobKey> {
    connection
        .prepare_cached(
            "INSERT INTO jobs (name, request_sha256, idempotency_key, design, document, unfinished)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6) RETURNING seq",
        )?
        .query_row(
            params![
                job.name,
                job.request.sha256,
                job.request.idempotency_key,
                job.design,
                job.request.document,
                unfinished
            ],
            |row| row.get(0),
        )
}

/// Stores runs of a job from this place in it on.
pub(super) fn add_runs<'a>(
    connection: &Connection,
    seq: JobKey,
    first: i64,
    runs: impl IntoIterator<Item = &'a NewRun>,
) -> rusqlite::Result<()> {
    for (place, run) in (first..).zip(runs) {
        let run_seq = add_run(connection, run)?;
        connection
            .prepare_cached(
                "INSERT INTO job_runs (job, ordinal, run, label) VALUES (?1, ?2, ?3, ?4)",
            )?
            .execute(params![seq, place, run_seq, run.label])?;
    }
    Ok(())
}

enum Begun<'a> {
    New(JobKey, Reserved<'a>),
    Replayed(JobKey),
}

fn admit(
    connection: &Connection,
    request: &JobRequest,
    reserved: u64,
    runs: u64,
    limit: u64,
) -> Result<Option<JobKey>, CreateJobError> {
    if let Some(key) = &request.idempotency_key {
        let earlier: Option<(JobKey, String, bool)> = connection
            .prepare_cached(
                "SELECT seq, request_sha256,
                    coalesce(unfinished IN ('creating', 'starting', 'deleting'), FALSE)
                 FROM jobs WHERE idempotency_key = ?1",
            )?
            .query_row([key], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))
            .optional()?;
        match earlier {
            Some((_, digest, _)) if digest != request.sha256 => {
                return Err(CreateJobError::KeyReused);
            }
            Some((_, _, true)) => return Err(CreateJobError::UnderWay),
            Some((seq, _, false)) => return Ok(Some(seq)),
            None => {}
        }
    }
    check_room(connection, reserved, runs, limit)?;
    Ok(None)
}

/// Whether so many more runs may be unfinished.
pub(super) fn check_room(
    connection: &Connection,
    reserved: u64,
    runs: u64,
    limit: u64,
) -> Result<(), CreateJobError> {
    let unfinished = reserved
        + from_sql(connection.query_row(
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
    Ok(())
}

/// Stores a run or finds it; returns its key. One that is found is left as it is.
fn add_run(connection: &Connection, run: &NewRun) -> rusqlite::Result<RunKey> {
    connection
        .prepare_cached(
            "INSERT INTO runs
                (id, seed, arena, method, epochs_total, robot_steps_total, step_cost, spec,
                results_version, origin)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10) ON CONFLICT (id) DO NOTHING",
        )?
        .execute(params![
            run.id,
            to_sql(run.seed),
            run.arena,
            run.method,
            run.epochs_total,
            to_sql(run.robot_steps_total),
            run.step_cost,
            run.spec,
            swarm::RESULTS_VERSION,
            run.origin
        ])?;
    let seq = connection
        .prepare_cached("SELECT seq FROM runs WHERE id = ?1")?
        .query_row([&run.id], |row| row.get(0))?;
    for arena in &run.uploaded_arenas {
        connection
            .prepare_cached("INSERT OR IGNORE INTO run_arenas (run, arena) VALUES (?1, ?2)")?
            .execute(params![seq, arena])?;
    }
    Ok(seq)
}
