//! Changes of state, numbered in the order in which they were stored. Triggers keep the list, in
//! the transaction of each change; see `migrations/9_events.sql`.

use std::collections::BTreeSet;

use api::State;
use rusqlite::params;

use super::keys::{JobKey, RunKey};
use super::{Store, StoreError, from_sql, to_sql};

/// Most changes of one look.
const MOST: u32 = 500;
/// Most pairs of run and job of one look at whom changes concern.
const MOST_CONCERNED: usize = 2_000;

/// Of which changes somebody wants to hear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// Of all.
    All,
    /// Of a job's runs, and of what its owner wants.
    Job(JobKey),
    /// Of a run.
    Run(RunKey),
}

/// A change of a run's state, or that a job is gone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// Its number: later changes have higher ones.
    pub id: u64,
    /// What has changed.
    pub what: Changed,
}

/// What has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Changed {
    /// A run's state.
    Run {
        /// Its id.
        run: String,
        /// Its place in the job that is listened to; 0 where a run is, or where all are.
        ordinal: u64,
        /// What it became.
        state: State,
    },
    /// A job was deleted: told of all alone.
    JobGone(JobKey),
}

/// What has changed since a number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// In order.
    pub items: Vec<Change>,
    /// The number to ask from next time.
    pub after: u64,
    /// Changes since that number may be gone from the list: look at the present state instead.
    pub is_incomplete: bool,
    /// There may be more right now.
    pub is_cut: bool,
}

impl Store {
    /// Number of the newest change of any run; 0 before the first.
    ///
    /// # Errors
    /// When the database fails.
    pub fn newest_change(&self) -> Result<u64, StoreError> {
        Ok(self
            .reader()
            .prepare_cached("SELECT coalesce(max(id), 0) FROM changes")?
            .query_row([], |row| row.get(0).map(from_sql))?)
    }

    /// The runs and jobs that changes from the one number, without it, to the other are of, with
    /// every job of those runs; `None` for too many.
    ///
    /// # Errors
    /// When the database fails.
    pub fn concerned(&self, after: u64, to: u64) -> Result<Option<BTreeSet<Subject>>, StoreError> {
        let reader = self.reader();
        let mut pairs = reader.prepare_cached(
            "SELECT changes.run, coalesce(changes.job, job_runs.job)
             FROM changes LEFT JOIN job_runs ON job_runs.run = changes.run
             WHERE changes.id > ?1 AND changes.id <= ?2 LIMIT ?3",
        )?;
        let most = to_sql(MOST_CONCERNED as u64);
        let mut rows = pairs.query(params![to_sql(after), to_sql(to), most])?;
        let (mut concerned, mut count) = (BTreeSet::new(), 0);
        while let Some(row) = rows.next()? {
            count += 1;
            concerned.extend(row.get::<_, Option<RunKey>>(0)?.map(Subject::Run));
            concerned.extend(row.get::<_, Option<JobKey>>(1)?.map(Subject::Job));
        }
        Ok((count < MOST_CONCERNED).then_some(concerned))
    }

    /// Changes since a number, in order.
    ///
    /// # Errors
    /// When the database fails.
    pub fn changes(&self, subject: Subject, after: u64) -> Result<Changes, StoreError> {
        let reader = self.reader();
        let (oldest, newest): (i64, i64) = reader
            .prepare_cached("SELECT coalesce(min(id), 1), coalesce(max(id), 0) FROM changes")?
            .query_row([], |row| Ok((row.get(0)?, row.get(1)?)))?;
        let (oldest, newest) = (from_sql(oldest), from_sql(newest));
        if after + 1 < oldest || after > newest {
            // Numbers above the newest are of another database.
            return Ok(Changes {
                after: newest,
                is_incomplete: true,
                ..Changes::default()
            });
        }
        let read = |row: &rusqlite::Row<'_>| {
            Ok(Row {
                id: from_sql(row.get(0)?),
                run: row.get(1)?,
                ordinal: from_sql(row.get(2)?),
                state: row.get(3)?,
                job: row.get(4)?,
            })
        };
        let found: Vec<Row> = match subject {
            Subject::All => reader
                .prepare_cached(
                    "SELECT changes.id, runs.id, 0, changes.state, changes.job
                     FROM changes LEFT JOIN runs ON runs.seq = changes.run
                     WHERE changes.id > ?1 AND changes.id <= ?2
                        AND (runs.id IS NOT NULL
                            OR (changes.job IS NOT NULL AND changes.state = 'gone'))
                     ORDER BY changes.id LIMIT ?3",
                )?
                .query_map(params![to_sql(after), to_sql(newest), MOST], read)?
                .collect::<Result<_, _>>()?,
            Subject::Job(job) => reader
                .prepare_cached(
                    "SELECT changes.id, runs.id, job_runs.ordinal, changes.state, NULL
                     FROM changes
                        JOIN job_runs ON job_runs.run = changes.run AND job_runs.job = ?1
                        JOIN runs ON runs.seq = changes.run
                     WHERE changes.id > ?2 AND changes.id <= ?3 ORDER BY changes.id LIMIT ?4",
                )?
                .query_map(params![job, to_sql(after), to_sql(newest), MOST], read)?
                .collect::<Result<_, _>>()?,
            Subject::Run(run) => reader
                .prepare_cached(
                    "SELECT changes.id, runs.id, 0, changes.state, NULL
                     FROM changes JOIN runs ON runs.seq = changes.run
                     WHERE changes.run = ?1 AND changes.id > ?2 AND changes.id <= ?3
                     ORDER BY changes.id LIMIT ?4",
                )?
                .query_map(params![run, to_sql(after), to_sql(newest), MOST], read)?
                .collect::<Result<_, _>>()?,
        };
        let is_cut = found.len() == MOST as usize;
        let items = found
            .into_iter()
            .map(Row::change)
            .collect::<Result<Vec<_>, StoreError>>()?;
        let last = items.last().map(|change| change.id);
        Ok(Changes {
            after: last.filter(|_| is_cut).unwrap_or(newest),
            items,
            is_incomplete: false,
            is_cut,
        })
    }
}

/// A row of the list.
struct Row {
    id: u64,
    run: Option<String>,
    ordinal: u64,
    state: String,
    job: Option<JobKey>,
}

impl Row {
    fn change(self) -> Result<Change, StoreError> {
        let what = match (self.run, self.job) {
            (Some(run), _) => Changed::Run {
                run,
                ordinal: self.ordinal,
                state: State::from_name(&self.state)
                    .ok_or_else(|| StoreError::unreadable("run state", &self.state))?,
            },
            (None, Some(job)) => Changed::JobGone(job),
            (None, None) => return Err(StoreError::unreadable("change", &self.state)),
        };
        Ok(Change { id: self.id, what })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    /// Runs without jobs, as the triggers see them; each statement changes the state of one.
    fn change(store: &Store, run: i64, state: &str) {
        let connection = store.connection();
        let reason = (state == "failed").then_some("for a test");
        connection
            .execute(
                "INSERT INTO runs (seq, id, seed, arena, method, epochs_total, robot_steps_total, spec)
                 VALUES (?1, 'run ' || ?1, 1, 'easy', 'im', 1, 1, '{}') ON CONFLICT DO NOTHING",
                [run],
            )
            .unwrap();
        connection
            .execute(
                "UPDATE runs SET state = ?2, reason = ?3 WHERE seq = ?1",
                params![run, state, reason],
            )
            .unwrap();
    }

    #[test]
    fn changes_come_in_order_to_those_whom_they_concern() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path()).unwrap();
        assert_eq!(store.newest_change().unwrap(), 0);
        for (run, state) in [
            (1, "running"),
            (2, "running"),
            (1, "running"),
            (1, "failed"),
        ] {
            change(&store, run, state);
        }
        let subject = Subject::Run(RunKey(1));
        let all = store.changes(subject, 0).unwrap();
        let states: Vec<State> = all
            .items
            .iter()
            .filter_map(|change| match change.what {
                Changed::Run { state, .. } => Some(state),
                Changed::JobGone(_) => None,
            })
            .collect();
        // What stays as it is is no change.
        assert_eq!(states, [State::Running, State::Failed]);
        assert_eq!(
            (all.after, all.is_incomplete, all.is_cut),
            (3, false, false)
        );
        let rest = store.changes(subject, all.items[0].id).unwrap();
        assert_eq!(rest.items, all.items[1..]);
        assert_eq!(store.changes(subject, 3).unwrap().items, []);
        // A number of another database.
        assert!(store.changes(subject, 4).unwrap().is_incomplete);
    }

    #[test]
    fn that_a_job_is_gone_is_told_of_all_alone() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path()).unwrap();
        change(&store, 1, "running");
        let sql = "INSERT INTO jobs (seq, name, request_sha256) VALUES (7, '', '')";
        store.connection().execute(sql, []).unwrap();
        store.delete_job(JobKey(7)).unwrap();
        change(&store, 1, "done");
        let told = |subject| {
            let changes = store.changes(subject, 0).unwrap();
            let told = changes.items.into_iter().map(|change| match change.what {
                Changed::Run { run, state, .. } => format!("{run} {state}"),
                Changed::JobGone(job) => format!("{job} gone"),
            });
            told.collect::<Vec<_>>()
        };
        assert_eq!(
            told(Subject::All),
            ["run 1 running", "7 gone", "run 1 done"]
        );
        assert_eq!(
            told(Subject::Run(RunKey(1))),
            ["run 1 running", "run 1 done"]
        );
        assert_eq!(told(Subject::Job(JobKey(7))), [""; 0]);
    }

    #[test]
    fn changes_concern_a_run_and_each_job_that_has_it() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path()).unwrap();
        change(&store, 1, "running");
        change(&store, 2, "running");
        let sql = "INSERT INTO jobs (seq, name, request_sha256) VALUES (7, '', ''), (8, '', '');
            INSERT INTO job_runs (job, ordinal, run) VALUES (7, 0, 1), (8, 0, 1), (8, 1, 2)";
        store.connection().execute_batch(sql).unwrap();
        change(&store, 1, "queued");
        store
            .connection()
            .execute("UPDATE jobs SET intent = 'paused' WHERE seq = 7", [])
            .unwrap();
        let concerned = |after, to| store.concerned(after, to).unwrap().unwrap();
        let [job, other] = [7, 8].map(|key| Subject::Job(JobKey(key)));
        let [run, second] = [1, 2].map(|key| Subject::Run(RunKey(key)));
        assert_eq!(concerned(2, 3), [job, other, run].into());
        assert_eq!(concerned(3, 4), [job].into());
        assert_eq!(concerned(1, 2), [other, second].into());
        assert_eq!(concerned(4, 4), [].into());
        for _ in 0..MOST_CONCERNED / 4 {
            change(&store, 1, "running");
            change(&store, 1, "queued");
        }
        assert_eq!(store.concerned(0, u64::MAX).unwrap(), None);
    }

    #[test]
    fn many_changes_come_in_parts_and_old_ones_go() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path()).unwrap();
        for _ in 0..MOST {
            change(&store, 1, "running");
            change(&store, 1, "queued");
        }
        let subject = Subject::Run(RunKey(1));
        let (mut after, mut heard, mut looks) = (0, 0, 0);
        loop {
            let changes = store.changes(subject, after).unwrap();
            (after, heard, looks) = (changes.after, heard + changes.items.len(), looks + 1);
            if !changes.is_cut {
                break;
            }
        }
        assert_eq!((heard, after), (2 * MOST as usize, 2 * u64::from(MOST)));
        assert_eq!(looks, 3, "the last one is empty");
        // As after 100,000 more.
        store
            .connection()
            .execute(
                "INSERT INTO changes (id, run, state) VALUES (150000, 1, 'done')",
                [],
            )
            .unwrap();
        assert!(store.changes(subject, after).unwrap().is_incomplete);
        let count = "SELECT count(*) FROM changes";
        let left: i64 = store
            .reader()
            .query_row(count, [], |row| row.get(0))
            .unwrap();
        assert_eq!(left, 1);
    }
}
