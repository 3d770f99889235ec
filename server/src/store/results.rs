//! What runs found: coverage while they run, and the result once they are done.

use rusqlite::{Connection, OptionalExtension, params};
use sha2::{Digest, Sha256};

use super::findings::Findings;
use super::formats::Blobs;
use super::keys::RunKey;
use super::{Store, StoreError};

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

/// The state that a run ended in.
#[derive(Clone, Copy, Debug)]
pub struct Last<'a> {
    /// The run.
    pub id: &'a str,
    /// What `swarm::run::Run::restore` takes.
    pub snapshot: &'a [u8],
}

/// Processor time that a crash of the machine may cost, seconds: runs that took less are not waited
/// for on disk when they are done, as they can be run again to the same bits.
const QUICK_S: f64 = 0.5;

impl Finished {
    fn is_quick(&self) -> bool {
        let steps = self.result.steps as f64;
        self.cpu_ns_per_robot_step
            .is_some_and(|cost_ns| cost_ns * 1e-9 * steps < QUICK_S)
    }
}

impl Store {
    /// The coverage of a finished run; `None` when it is not finished.
    ///
    /// # Errors
    /// When the database fails, `Damaged` when what it holds of the run cannot be used.
    pub fn findings(&self, run: RunKey) -> Result<Option<Findings>, StoreError> {
        let found = self
            .reader()
            .prepare_cached(
                "SELECT id, coverage, metrics, objects
                 FROM results JOIN runs ON runs.seq = results.run WHERE run = ?1",
            )?
            .query_row([run], |row| {
                let blobs = Blobs {
                    coverage: row.get(1)?,
                    metrics: row.get(2)?,
                    objects: row.get(3)?,
                };
                Ok((row.get::<_, String>(0)?, blobs))
            })
            .optional()?;
        found
            .map(|(id, blobs)| {
                let read = blobs.read();
                read.map_err(|(kind, why)| StoreError::damaged(kind.name(), id, why))
            })
            .transpose()
    }

    /// Mean processor time a robot-step of the latest finished runs of a method and a kind of
    /// engine, nanoseconds, where there are any.
    ///
    /// # Errors
    /// When the database fails.
    pub fn recent_cost(&self, method: &str, step_cost: u32) -> Result<Option<f64>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached(
                "SELECT avg(cost) FROM (
                     SELECT results.cpu_ns_per_robot_step AS cost
                     FROM runs JOIN results ON results.run = runs.seq
                     WHERE runs.method = ?1 AND runs.step_cost = ?2
                     ORDER BY runs.seq DESC LIMIT 20)",
            )?
            .query_row((method, step_cost), |row| row.get(0))?)
    }

    /// Stores what a run found and makes it done, as one; before that its last state, if there is
    /// one to keep, so that whoever sees that it is done can extend it. Returns whether the run was
    /// still wanted: a run that was cancelled or deleted meanwhile stays so, and nothing is stored.
    ///
    /// # Errors
    /// When the database fails; nothing is stored then.
    pub fn finish(
        &self,
        run: RunKey,
        finished: &Finished,
        last: Option<Last<'_>>,
    ) -> Result<bool, StoreError> {
        let blobs = Blobs::of(&finished.findings);
        if let Some(Last { id, snapshot }) = last {
            self.finals().keep(id, &blobs, snapshot);
        }
        let result = serde_json::to_string(&finished.result)
            .map_err(|error| StoreError::unreadable("result", error))?;
        if finished.is_quick() {
            done(
                &mut self.unsynced_connection(),
                run,
                finished,
                &blobs,
                &result,
            )
        } else {
            done(&mut self.connection(), run, finished, &blobs, &result)
        }
    }
}

fn done(
    connection: &mut Connection,
    run: RunKey,
    finished: &Finished,
    blobs: &Blobs,
    result: &str,
) -> Result<bool, StoreError> {
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
    let digest = Sha256::digest(result);
    transaction
            .prepare_cached(
                "INSERT INTO results (run, result, result_sha256, coverage, metrics, objects, cpu_ns_per_robot_step)
                 VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
            )?
            .execute(params![
                run,
                result,
                &digest[..],
                blobs.coverage,
                blobs.metrics,
                blobs.objects,
                finished.cpu_ns_per_robot_step
            ])?;
    transaction.commit()?;
    Ok(true)
}
