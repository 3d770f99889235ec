//! What runs found: coverage while they run, and the result once they are done.

use rusqlite::{OptionalExtension, params};
use serde::{Deserialize, Serialize};
use swarm::run::{CurveRow, MetricsLog, Tracks};

use super::keys::RunKey;
use super::{Store, StoreError};

/// What a run has covered so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// One row a completed counted epoch.
    pub curve: Vec<CurveRow>,
    /// Entries counted a square, row by row from the lowest y.
    pub visits: Vec<u32>,
    /// Steps spent a square, same shape.
    pub dwell: Vec<u32>,
    /// Swarm metrics over time; empty in results of versions that had none.
    pub metrics: MetricsLog,
    /// Movable objects over time; empty in results of versions that did not record them.
    pub tracks: Tracks,
}

/// What a finished run leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    /// `result.json`.
    pub result: api::RunResult,
    /// The whole curve and the final counts.
    pub findings: Findings,
    /// Processor time a robot-step, nanoseconds, of the last time that a worker held the run.
    pub cpu_ns_per_robot_step: Option<f64>,
}

/// Findings, metrics and objects of a result; the last two are younger than the first.
type Blobs = (Vec<u8>, Option<Vec<u8>>, Option<Vec<u8>>);

fn read<T: serde::de::DeserializeOwned>(what: &'static str, blob: &[u8]) -> Result<T, StoreError> {
    postcard::from_bytes(blob).map_err(|error| StoreError::unreadable(what, error))
}

/// What a column holds that older versions did not have.
fn read_or_default<T: serde::de::DeserializeOwned + Default>(
    what: &'static str,
    blob: Option<Vec<u8>>,
) -> Result<T, StoreError> {
    blob.map_or_else(|| Ok(T::default()), |blob| read(what, &blob))
}

fn write(what: &'static str, value: &impl Serialize) -> Result<Vec<u8>, StoreError> {
    postcard::to_allocvec(value).map_err(|error| StoreError::unreadable(what, error))
}

impl Store {
    /// The coverage of a finished run; `None` when it is not finished.
    ///
    /// # Errors
    /// When the database fails or holds what cannot be read.
    pub fn findings(&self, run: RunKey) -> Result<Option<Findings>, StoreError> {
        let blobs: Option<Blobs> = self
            .connection()
            .prepare_cached("SELECT coverage, metrics, objects FROM results WHERE run = ?1")?
            .query_row([run], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))
            .optional()?;
        blobs
            .map(|(coverage, metrics, objects)| {
                let (curve, visits, dwell) = read("coverage", &coverage)?;
                Ok(Findings {
                    curve,
                    visits,
                    dwell,
                    metrics: read_or_default("metrics", metrics)?,
                    tracks: read_or_default("objects", objects)?,
                })
            })
            .transpose()
    }

    /// Processor time a robot-step of a finished run, nanoseconds, where it is known.
    ///
    /// # Errors
    /// When the database fails.
    pub fn cost(&self, run: RunKey) -> Result<Option<f64>, StoreError> {
        Ok(self
            .connection()
            .prepare_cached("SELECT cpu_ns_per_robot_step FROM results WHERE run = ?1")?
            .query_row([run], |row| row.get(0))
            .optional()?
            .flatten())
    }

    /// Stores what a run found and makes it done, as one. Returns whether the run was still wanted:
    /// a run that was cancelled or deleted meanwhile stays so, and nothing is stored.
    ///
    /// # Errors
    /// When the database fails; nothing is stored then.
    pub fn finish(&self, run: RunKey, finished: &Finished) -> Result<bool, StoreError> {
        let Findings {
            curve,
            visits,
            dwell,
            metrics,
            tracks,
        } = &finished.findings;
        let coverage = write("coverage", &(curve, visits, dwell))?;
        let metrics = write("metrics", metrics)?;
        let objects = (!tracks.is_empty())
            .then(|| write("objects", tracks))
            .transpose()?;
        let result = serde_json::to_string(&finished.result)
            .map_err(|error| StoreError::unreadable("result", error))?;
        let mut connection = self.connection();
        let transaction = connection.transaction()?;
        let changed = transaction
            .prepare_cached(
                "UPDATE runs SET state = 'done', phase = 'done', epochs_done = epochs_total,
                    robot_steps_done = ?2, robot_steps_total = ?2
                 WHERE seq = ?1 AND state IN ('queued', 'running', 'paused')",
            )?
            .execute(params![run, super::to_sql(finished.result.steps)])?;
        if changed == 0 {
            return Ok(false);
        }
        transaction
            .prepare_cached(
                "INSERT INTO results (run, result, coverage, metrics, objects, cpu_ns_per_robot_step)
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
            )?
            .execute(params![
                run,
                result,
                coverage,
                metrics,
                objects,
                finished.cpu_ns_per_robot_step
            ])?;
        transaction.commit()?;
        Ok(true)
    }
}
