//! What jobs found as tables with columns of fixed names, types and order, whatever the job:
//! `runs` (a row a run), `curves` and `metrics` (rows of its finished runs). docs/exports.md lists
//! the columns.

mod identity;
mod measures;
mod over_time;
mod spec;

use std::io::{self, Write};

use crate::store::{JobView, RunView, Store, StoreError};
use crate::tables::{Column, Form};

pub use over_time::metrics_of_run;

/// Most rows of a table.
const MOST_ROWS: u64 = 50_000_000;
/// Most rows of metrics that a run has, for an estimate before they are read.
const METRICS_ROWS: u64 = 400;
/// Runs that are read at once.
const PAGE: u32 = 200;

/// A table of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Its runs, each with its spec and what it found.
    Runs,
    /// Coverage after each epoch of its finished runs.
    Curves,
    /// Swarm metrics over time of its finished runs.
    Metrics,
}

/// Why there is no table, or not all of it.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// It would be too long.
    #[error("the table may have {0} rows; at most {MOST_ROWS} are given at once")]
    TooLong(u64),
    /// Nobody takes it any more, or it cannot be written.
    #[error("the table cannot be written: {0}")]
    Write(#[from] io::Error),
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl Table {
    /// Every table with the forms that it comes in.
    pub const ALL: [(Self, Form); 4] = [
        (Self::Runs, Form::Csv),
        (Self::Runs, Form::Parquet),
        (Self::Curves, Form::Parquet),
        (Self::Metrics, Form::Parquet),
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Runs => "runs",
            Self::Curves => "curves",
            Self::Metrics => "metrics",
        }
    }

    /// Its columns.
    pub fn columns(self) -> Vec<Column> {
        let mut columns: Vec<Column> = identity::columns().collect();
        match self {
            Self::Runs => {
                columns.extend(spec::columns());
                columns.extend(measures::columns());
            }
            Self::Curves => columns.extend(over_time::curve_columns()),
            Self::Metrics => columns.extend(over_time::metrics_columns()),
        }
        columns
    }
}

/// Whether a table is short enough.
///
/// # Errors
/// `TooLong` when it is not, `Store`.
pub fn check(store: &Store, job: &JobView, table: Table) -> Result<(), ExportError> {
    let rows = match table {
        Table::Runs => job.counts.total,
        Table::Curves => store.epochs_done(job.seq)?,
        Table::Metrics => job.counts.done.saturating_mul(METRICS_ROWS),
    };
    if rows > MOST_ROWS {
        return Err(ExportError::TooLong(rows));
    }
    Ok(())
}

/// What names the bytes of a table: equal tags, equal bytes. `None` while runs of the job are under
/// way.
///
/// # Errors
/// `Store`.
pub fn tag(
    store: &Store,
    job: &JobView,
    table: Table,
    form: Form,
) -> Result<Option<String>, StoreError> {
    let Some(digest) = store.ended_runs_sha256(job.seq)? else {
        return Ok(None);
    };
    let digits = hex::encode(&digest[..16]);
    let version = env!("CARGO_PKG_VERSION");
    let (name, suffix) = (table.name(), form.suffix());
    Ok(Some(format!("{version}-{digits}-{name}.{suffix}")))
}

/// Writes a table; a few runs are held at a time, and the database between two writes never.
///
/// # Errors
/// `Write` when nobody takes it, `Store`.
pub fn write(
    store: &Store,
    job: &JobView,
    table: Table,
    form: Form,
    out: impl Write + Send,
) -> Result<(), ExportError> {
    let mut rows = form.begin(&table.columns(), out)?;
    let mut from = 0;
    loop {
        let page = store.runs(job.seq, from, PAGE)?;
        let Some(last) = page.last() else { break };
        from = last.ordinal + 1;
        for run in &page {
            let mut row = identity::cells(run);
            let own = row.len();
            match table {
                Table::Runs => {
                    row.extend(spec::cells(store.spec(run.seq)?.as_deref()));
                    row.extend(measures::cells(run.result(), run.cpu_ns_per_robot_step));
                    rows.add(&row)?;
                }
                Table::Curves => {
                    for epoch in finished(store, run)?.iter().flat_map(|found| &found.curve) {
                        row.truncate(own);
                        row.extend(over_time::curve_cells(epoch));
                        rows.add(&row)?;
                    }
                }
                Table::Metrics => {
                    let Some(found) = finished(store, run)? else {
                        continue;
                    };
                    let step_s = spec::step_s(store.spec(run.seq)?.as_deref());
                    for moment in &found.metrics.rows {
                        row.truncate(own);
                        let reachable = found.metrics.reachable;
                        row.extend(over_time::metrics_cells(moment, reachable, step_s));
                        rows.add(&row)?;
                    }
                }
            }
        }
    }
    rows.end()?;
    Ok(())
}

/// What a run found, if it is done. A run that was deleted meanwhile has nothing any more.
fn finished(store: &Store, run: &RunView) -> Result<Option<crate::store::Findings>, StoreError> {
    match run.result() {
        Some(_) => store.findings(run.seq),
        None => Ok(None),
    }
}

#[cfg(test)]
mod tests;
