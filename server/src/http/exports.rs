//! `/v1/jobs/{id}/runs.csv`, `.parquet`, `curves.parquet`, `metrics.parquet`: sent as they are made,
//! so that no table has to fit into memory. Whoever stops reading ends the work.

use std::io::{self, Write};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use api::ProblemCode;
use axum::extract::State;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE, RANGE};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use tokio::sync::Semaphore;

use super::App;
use super::extract::FoundJob;
use super::operation::{Operation, camel};
use super::partial::{Window, not_modified, part, tagged};
use super::parts::streamed;
use super::refusal::Refusal;
use super::routes::Routes;
use super::turns::MANY_RUNS;
use crate::exports::{self, ExportError, Table};
use crate::store::JobView;
use crate::tables::Form;

/// Tables that are made at a time; each holds some tens of megabytes.
pub const AT_A_TIME: usize = 4;
/// Longest time that a table is made for its length alone.
const COUNTING: Duration = Duration::from_secs(8);

pub fn routes() -> Routes {
    Table::ALL
        .into_iter()
        .fold(Routes::new(), |routes, (table, form)| {
            let show = move |State(app): State<App>, FoundJob(job), asked: HeaderMap| {
                show(app, job, table, form, asked)
            };
            let end = format!("{}.{}", table.name(), form.suffix());
            let told = Operation::new(
                format!("getJob{}", camel(&end)),
                format!("What a job's runs found, as a table: {}", table.name()),
            );
            let told = told
                .details(
                    "Columns are told in docs/exports.md. Sent as it is made: while runs of the job \
                     are under way it has no tag and no parts.",
                )
                .answers(200, "The table.", form.media_type(), None)
                .refuses(&[ProblemCode::TableTooLong]);
            routes.get(&format!("/jobs/{{id}}/{end}"), show, told)
        })
}

/// Answers with a table, or a part of it. While runs of the job are under way no two tables of it are
/// equal, so that it has no tag then.
async fn show(
    app: App,
    job: JobView,
    table: Table,
    form: Form,
    asked: HeaderMap,
) -> Result<Response, Refusal> {
    let name = format!("job-{}-{}.{}", job.seq, table.name(), form.suffix());
    let disposition = HeaderValue::try_from(format!("attachment; filename=\"{name}\""))
        .map_err(|error| Refusal::internal(&error))?;
    let (job, tag) = app
        .blocking(move |app| {
            // The tag is one of all of the job's runs.
            let _turn = app.turn_to_pool(&job, MANY_RUNS)?;
            exports::check(&app.store, &job, table)?;
            let tag = exports::tag(&app.store, &job, table, form)?;
            Ok((job, tag))
        })
        .await?;
    let tag = tag.map(|tag| HeaderValue::try_from(format!("\"{tag}\"")));
    let tag = tag.transpose().map_err(|error| Refusal::internal(&error))?;
    if let Some(known) = tag.as_ref().and_then(|tag| not_modified(&asked, tag)) {
        return Ok(known);
    }
    let Ok(place) = Arc::clone(&app.exports).try_acquire_owned() else {
        let detail = format!("{AT_A_TIME} tables are being made; try again later");
        return Err(Refusal::new(ProblemCode::Overloaded, detail).retry_after_s(5));
    };
    let made = Made {
        job,
        table,
        form,
        tag: tag.clone(),
    };
    let (mut status, mut headers, mut range) = (StatusCode::OK, HeaderMap::new(), None);
    if let Some(tag) = tag {
        headers = tagged(&tag);
        if asked.contains_key(RANGE) {
            let counted = made.clone();
            let length = app.blocking(move |app| Ok(counted.length(app))).await?;
            if let Some(length) = length {
                match part(&asked, &tag, length) {
                    Ok(part) => {
                        (status, headers, range) = (part.status, part.headers, Some(part.range));
                    }
                    Err(refused) => return Ok(*refused),
                }
            }
        }
    }
    let body = streamed(move |out| {
        let _place = place;
        made.write(&app, out, range).map(drop)
    });
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(form.media_type()));
    headers.insert(CONTENT_DISPOSITION, disposition);
    Ok((status, headers, body).into_response())
}

/// A table that is made for an answer.
#[derive(Clone)]
struct Made {
    job: JobView,
    table: Table,
    form: Form,
    tag: Option<HeaderValue>,
}

impl Made {
    /// Its bytes, found by making it unless they are known; `None` where that takes too long, or
    /// fails: then the part that is asked for is not sent, but all of it, as it would be.
    fn length(&self, app: &App) -> Option<u64> {
        let tag = self.tag.as_ref()?;
        if let Some(length) = app.lengths.get(tag) {
            return Some(length);
        }
        let patience = Patience(Instant::now() + COUNTING);
        self.write(app, patience, None).ok()
    }

    /// Writes it, or these bytes of it; returns how many there are up to the end of what is written.
    fn write(
        &self,
        app: &App,
        out: impl Write + Send,
        range: Option<Range<u64>>,
    ) -> io::Result<u64> {
        let is_whole = range.is_none();
        let mut out = Window::new(out, range);
        let written = exports::write(&app.store, &self.job, self.table, self.form, &mut out);
        match written {
            Ok(()) => {}
            Err(ExportError::Write(_)) if out.is_over() => {}
            Err(ExportError::Write(error)) => return Err(error),
            Err(error) => {
                tracing::error!(job = %self.job.seq, %error, "a table breaks off");
                return Err(io::Error::other(error));
            }
        }
        if let Some(tag) = &self.tag {
            let now = exports::tag(&app.store, &self.job, self.table, self.form);
            let now = now.map_err(io::Error::other)?;
            if now.is_none_or(|now| tag.as_bytes() != format!("\"{now}\"").as_bytes()) {
                return Err(io::Error::other("the job changed while its table was made"));
            }
            if is_whole {
                app.lengths.put(tag, out.written);
            }
        }
        out.flush()?;
        Ok(out.written)
    }
}

/// Takes whatever is written, up to this moment.
struct Patience(Instant);

impl Write for Patience {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match Instant::now() < self.0 {
            true => Ok(bytes.len()),
            false => Err(io::ErrorKind::TimedOut.into()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A table's place among those that are made at a time.
pub fn places() -> Arc<Semaphore> {
    Arc::new(Semaphore::new(AT_A_TIME))
}

impl From<ExportError> for Refusal {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::TooLong(_) => Self::new(ProblemCode::TableTooLong, error.to_string()),
            ExportError::Write(error) => Self::internal(&error),
            ExportError::Store(error) => error.into(),
        }
    }
}
