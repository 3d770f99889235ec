//! Jobs that have ended: since when, and how much they take.

use rusqlite::OptionalExtension;

use super::keys::JobKey;
use super::{Store, StoreError, from_sql};

/// A job of which nothing waits or runs.
#[derive(Clone, Debug, PartialEq)]
pub struct EndedJob {
    /// Key.
    pub seq: JobKey,
    /// Its name.
    pub name: String,
    /// Days since it was first seen to have ended.
    pub days: f64,
    /// Its runs.
    pub runs: u64,
    /// Bytes of what they found; runs of several jobs count in each.
    pub bytes: u64,
}

/// Whether a job `jobs` has ended.
const ENDED: &str = "unfinished IS NULL AND NOT EXISTS (SELECT 1 FROM job_totals
    WHERE job = jobs.seq AND runs > 0 AND state IN ('queued', 'running', 'paused'))";

impl Store {
    /// The jobs that have ended, those that did so first before others. Those that are seen to have
    /// ended for the first time ended now.
    ///
    /// # Errors
    /// When the database fails.
    pub fn ended_jobs(&self) -> Result<Vec<EndedJob>, StoreError> {
        {
            let connection = self.connection();
            connection.execute(
                &format!(
                    "UPDATE jobs SET ended_at = NULL WHERE ended_at IS NOT NULL AND NOT ({ENDED})"
                ),
                [],
            )?;
            connection.execute(
                &format!(
                    "UPDATE jobs SET ended_at = julianday('now') WHERE ended_at IS NULL AND {ENDED}"
                ),
                [],
            )?;
        }
        Ok(self
            .reader()
            .prepare_cached(
                "SELECT seq, name, max(julianday('now') - ended_at, 0.0),
                    (SELECT count(*) FROM job_runs WHERE job = jobs.seq),
                    (SELECT coalesce(sum(length(spec) + coalesce(length(result), 0)
                        + coalesce(length(coverage), 0) + coalesce(length(metrics), 0)
                        + coalesce(length(objects), 0)), 0)
                     FROM job_runs JOIN runs ON runs.seq = job_runs.run
                        LEFT JOIN results ON results.run = runs.seq WHERE job = jobs.seq)
                 FROM jobs WHERE ended_at IS NOT NULL ORDER BY ended_at, seq",
            )?
            .query_map([], |row| {
                Ok(EndedJob {
                    seq: row.get(0)?,
                    name: row.get(1)?,
                    days: row.get(2)?,
                    runs: from_sql(row.get(3)?),
                    bytes: from_sql(row.get(4)?),
                })
            })?
            .collect::<Result<_, _>>()?)
    }

    /// Whether a job has ended; one that is gone has not.
    ///
    /// # Errors
    /// When the database fails.
    pub fn has_ended(&self, job: JobKey) -> Result<bool, StoreError> {
        Ok(self
            .connection()
            .prepare_cached(&format!("SELECT 1 FROM jobs WHERE seq = ?1 AND {ENDED}"))?
            .query_row([job], |_| Ok(()))
            .optional()?
            .is_some())
    }

    /// Every run by its state.
    ///
    /// # Errors
    /// When the database fails.
    pub fn run_counts(&self) -> Result<Vec<(String, u64)>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached("SELECT state, count(*) FROM runs GROUP BY state")?
            .query_map([], |row| Ok((row.get(0)?, from_sql(row.get(1)?))))?
            .collect::<Result<_, _>>()?)
    }

    /// Bytes of the data directory, by what they are of.
    pub fn sizes(&self) -> Vec<(&'static str, u64)> {
        let file = |name: &str| {
            let meta = std::fs::metadata(self.dir.join(name));
            meta.map_or(0, |meta| meta.len())
        };
        let folder = |name: &str| {
            let entries = std::fs::read_dir(self.dir.join(name)).into_iter().flatten();
            let sizes = entries.filter_map(|entry| Some(entry.ok()?.metadata().ok()?.len()));
            sizes.sum()
        };
        vec![
            ("database", file(super::DATABASE)),
            ("log", file(&format!("{}-wal", super::DATABASE))),
            ("checkpoints", folder(super::CHECKPOINTS)),
            ("origins", folder(super::ORIGINS)),
            ("finals", self.finals().bytes()),
        ]
    }

    /// Bytes that are left where the data directory is; 0 where that cannot be told.
    pub fn room_bytes(&self) -> u64 {
        rustix::fs::statvfs(&self.dir).map_or(0, |stat| stat.f_bavail.saturating_mul(stat.f_frsize))
    }
}
