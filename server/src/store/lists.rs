//! Lists over all jobs and over all runs, filtered, from a key on.

use api::State;
use rusqlite::params;

use super::jobs::{self, JobView};
use super::keys::{JobKey, RunKey};
use super::runs::{self, RunView};
use super::{Store, StoreError};

/// Jobs that are looked at for one page, however few of them are wanted: each is a sum over runs.
const LOOKED_AT: u32 = 500;

/// Which jobs are wanted, and in what order.
#[derive(Clone, Debug, Default)]
pub struct JobFilter {
    /// In this state.
    pub state: Option<State>,
    /// With these letters in their name, large or small.
    pub name_has: Option<String>,
    /// Oldest first, instead of newest first.
    pub oldest_first: bool,
}

/// Which runs are wanted.
#[derive(Clone, Debug, Default)]
pub struct RunFilter {
    /// Of this job.
    pub job: Option<JobKey>,
    /// In this state.
    pub state: Option<State>,
    /// Of this method.
    pub method: Option<String>,
    /// In the arena of this name.
    pub arena: Option<String>,
    /// Oldest first, instead of newest first.
    pub oldest_first: bool,
}

/// A page of a list.
#[derive(Clone, Debug, PartialEq)]
pub struct Page<T, K> {
    /// What is wanted of it.
    pub items: Vec<T>,
    /// Where the next page begins; `None` when nothing is left.
    pub next: Option<K>,
}

/// Jobs of each kind that have a mark.
const MARKED: u32 = 500;

/// What changes when a job does, but for the progress of its runs that are being stepped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobMark {
    /// Key.
    pub seq: JobKey,
    /// Equal for jobs that are shown alike.
    pub text: String,
}

impl Store {
    /// Marks of the newest 500 jobs and, of older ones, of the newest 500 that are not over.
    ///
    /// # Errors
    /// When the database fails.
    pub fn job_marks(&self) -> Result<Vec<JobMark>, StoreError> {
        Ok(self
            .reader()
            .prepare_cached(&format!(
                "WITH newest AS ({columns} ORDER BY seq DESC LIMIT ?1),
                 older AS ({columns} AND seq < (SELECT min(seq) FROM newest) AND seq IN (
                        SELECT job FROM job_totals
                        WHERE state IN ('queued', 'running', 'paused') AND runs > 0)
                    ORDER BY seq DESC LIMIT ?1)
                 SELECT seq, concat(intent, ' ', priority, (
                    SELECT group_concat(concat(' ', state, ' ', runs, ' ', work_done, ' ', work_total), '')
                    FROM job_totals WHERE job = seq))
                 FROM (SELECT * FROM newest UNION ALL SELECT * FROM older)",
                columns = jobs::COLUMNS
            ))?
            .query_map([MARKED], |row| {
                Ok(JobMark {
                    seq: row.get(0)?,
                    text: row.get(1)?,
                })
            })?
            .collect::<Result<_, _>>()?)
    }

    /// At most `limit` jobs after the one of this key. A page may hold fewer although there are
    /// more: only so many are looked at.
    ///
    /// # Errors
    /// When the database fails.
    pub fn list_jobs(
        &self,
        filter: &JobFilter,
        after: Option<JobKey>,
        limit: u32,
    ) -> Result<Page<JobView, JobKey>, StoreError> {
        let connection = self.reader();
        let (order, start) = match filter.oldest_first {
            true => ("seq > ?1 AND {} ORDER BY seq", JobKey::default()),
            false => ("seq < ?1 AND {} ORDER BY seq DESC", JobKey::MAX),
        };
        let named = "(?2 IS NULL OR instr(lower(name), lower(?2)) > 0)";
        let heads = connection
            .prepare_cached(&format!(
                "{} AND {} LIMIT ?3",
                jobs::COLUMNS,
                order.replace("{}", named)
            ))?
            .query_map(
                params![after.unwrap_or(start), filter.name_has, LOOKED_AT + 1],
                jobs::head,
            )?
            .collect::<Result<Vec<_>, _>>()?;
        let (mut items, mut last) = (Vec::new(), None);
        for (place, head) in heads.into_iter().enumerate() {
            if items.len() == limit as usize || place == LOOKED_AT as usize {
                return Ok(Page { items, next: last });
            }
            let job = jobs::view(&connection, head)?;
            last = Some(job.seq);
            let state = job.intent.job_state(&job.counts);
            if filter.state.is_none_or(|wanted| wanted == state) {
                items.push(job);
            }
        }
        Ok(Page { items, next: None })
    }

    /// At most `limit` runs after the one of this key, each in the first job that has it, or in the
    /// one that is wanted.
    ///
    /// # Errors
    /// When the database fails or holds what cannot be read.
    pub fn list_runs(
        &self,
        filter: &RunFilter,
        after: Option<RunKey>,
        limit: u32,
    ) -> Result<Page<RunView, RunKey>, StoreError> {
        let (way, order, start) = match filter.oldest_first {
            true => (">", "", 0),
            false => ("<", "DESC", i64::MAX),
        };
        // Only what is wanted is asked for: the runs of a state have an index.
        let wanted = [
            (filter.state.is_some(), " AND state = ?2"),
            (filter.method.is_some(), " AND method = ?3"),
            (filter.arena.is_some(), " AND arena = ?4"),
            (
                filter.job.is_some(),
                " AND runs.seq IN (SELECT run FROM job_runs WHERE job = ?5)",
            ),
        ];
        let wanted: String = wanted
            .iter()
            .filter_map(|(is_wanted, condition)| is_wanted.then_some(*condition))
            .collect();
        let mut items = self
            .reader()
            .prepare_cached(&format!(
                "{} WHERE {} AND runs.seq {way} ?1{wanted}
                    AND (job, ordinal) = (SELECT job, ordinal FROM job_runs of
                        WHERE of.run = runs.seq AND (?5 IS NULL OR of.job = ?5)
                        ORDER BY job, ordinal LIMIT 1)
                 ORDER BY runs.seq {order} LIMIT ?6",
                runs::VIEW,
                runs::VISIBLE
            ))?
            .query_map(
                params![
                    after.map_or(start, |after| after.0),
                    filter.state.map(State::name),
                    filter.method,
                    filter.arena,
                    filter.job,
                    limit + 1
                ],
                |row| Ok(runs::view(row)),
            )?
            .collect::<Result<Vec<_>, _>>()?
            .into_iter()
            .collect::<Result<Vec<RunView>, _>>()?;
        let more = items.len() > limit as usize;
        items.truncate(limit as usize);
        let next = items.last().filter(|_| more).map(|run| run.seq);
        Ok(Page { items, next })
    }
}
