//! `/v1/jobs/{id}/runs.csv`, `.parquet`, `curves.parquet`, `metrics.parquet`: sent as they are made,
//! so that no table has to fit into memory. Whoever stops reading ends the work.

use std::io::{self, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

use api::ProblemCode;
use axum::body::Body;
use axum::extract::State;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::http::{HeaderName, HeaderValue};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use futures_util::stream::{self, StreamExt};
use tokio::runtime::Handle;
use tokio::sync::{Semaphore, mpsc};

use super::App;
use super::extract::FoundJob;
use super::operation::{Operation, camel};
use super::refusal::Refusal;
use super::routes::Routes;
use crate::exports::{self, ExportError, Table};
use crate::store::JobView;
use crate::tables::Form;

/// Tables that are made at a time; each holds some tens of megabytes.
pub const AT_A_TIME: usize = 4;
/// Bytes that are sent at once, and how many such parts may wait for the client.
const PART_BYTES: usize = 64 << 10;
const PARTS: usize = 4;
/// Longest time for a table, and that a client may take for a part.
const LONGEST: Duration = Duration::from_secs(15 * 60);
const PART_TIME: Duration = Duration::from_secs(60);

pub fn routes() -> Routes {
    Table::ALL
        .into_iter()
        .fold(Routes::new(), |routes, (table, form)| {
            let show = move |State(app): State<App>, FoundJob(job)| show(app, job, table, form);
            let end = format!("{}.{}", table.name(), form.suffix());
            let told = Operation::new(
                format!("getJob{}", camel(&end)),
                format!("What a job's runs found, as a table: {}", table.name()),
            );
            let told = told
                .details("Columns are told in docs/exports.md. Sent as it is made.")
                .answers(200, "The table.", form.media_type(), None)
                .streamed()
                .refuses(&[ProblemCode::TableTooLong]);
            routes.get(&format!("/jobs/{{id}}/{end}"), show, told)
        })
}

async fn show(app: App, job: JobView, table: Table, form: Form) -> Result<Response, Refusal> {
    let Ok(place) = Arc::clone(&app.exports).try_acquire_owned() else {
        let detail = format!("{AT_A_TIME} tables are being made; try again later");
        return Err(Refusal::new(ProblemCode::Overloaded, detail).retry_after_s(5));
    };
    let name = format!("job-{}-{}.{}", job.seq, table.name(), form.suffix());
    let job = app
        .blocking(move |app| {
            exports::check(&app.store, &job, table)?;
            Ok(job)
        })
        .await?;
    let (sender, receiver) = mpsc::channel(PARTS);
    let handle = Handle::current();
    tokio::task::spawn_blocking(move || {
        let _place = place;
        let mut out = Parts::new(sender, handle);
        let made = exports::write(&app.store, &job, table, form, &mut out);
        match made.and_then(|()| Ok(out.flush()?)) {
            Ok(()) => {}
            // The client is gone or too slow: there is nobody to tell.
            Err(ExportError::Write(error)) => {
                tracing::debug!(job = %job.seq, %error, "a table was not taken to its end");
                out.break_off(error);
            }
            Err(error) => {
                tracing::error!(job = %job.seq, %error, "a table breaks off");
                out.break_off(io::Error::other(error));
            }
        }
    });
    let parts = stream::unfold(receiver, async |mut receiver| {
        let part: Result<Bytes, io::Error> = receiver.recv().await?;
        Some((part, receiver))
    });
    // The layer that compresses asks once more after the end.
    let parts = parts.fuse();
    let disposition = HeaderValue::try_from(format!("attachment; filename=\"{name}\""))
        .map_err(|error| Refusal::internal(&error))?;
    let headers: [(HeaderName, HeaderValue); 2] = [
        (CONTENT_TYPE, HeaderValue::from_static(form.media_type())),
        (CONTENT_DISPOSITION, disposition),
    ];
    Ok((headers, Body::from_stream(parts)).into_response())
}

/// A table's place among those that are made at a time.
pub fn places() -> Arc<Semaphore> {
    Arc::new(Semaphore::new(AT_A_TIME))
}

/// Writes to a client, from a thread that may block.
struct Parts {
    sender: mpsc::Sender<Result<Bytes, io::Error>>,
    handle: Handle,
    part: Vec<u8>,
    end: Instant,
}

impl Parts {
    fn new(sender: mpsc::Sender<Result<Bytes, io::Error>>, handle: Handle) -> Self {
        Self {
            sender,
            handle,
            part: Vec::with_capacity(PART_BYTES),
            end: Instant::now() + LONGEST,
        }
    }

    fn send(&self, part: Result<Bytes, io::Error>) -> io::Result<()> {
        let left = self.end.saturating_duration_since(Instant::now());
        let sent = self.sender.send_timeout(part, PART_TIME.min(left));
        self.handle
            .block_on(sent)
            .map_err(|error| io::Error::new(io::ErrorKind::BrokenPipe, error.to_string()))
    }

    /// Lets the client see that what it has is not all.
    fn break_off(self, error: io::Error) {
        drop(self.send(Err(error)));
    }
}

impl Write for Parts {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.part.extend_from_slice(bytes);
        if self.part.len() >= PART_BYTES {
            self.flush()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.part.is_empty() {
            return Ok(());
        }
        let part = std::mem::replace(&mut self.part, Vec::with_capacity(PART_BYTES));
        self.send(Ok(part.into()))
    }
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
