//! `/v1/jobs/{id}/runs.csv`, `.parquet`, `curves.parquet`, `metrics.parquet`: sent as they are made,
//! so that no table has to fit into memory. Whoever stops reading ends the work.

use std::io;
use std::sync::Arc;

use api::ProblemCode;
use axum::extract::State;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::http::{HeaderName, HeaderValue};
use axum::response::{IntoResponse, Response};
use tokio::sync::Semaphore;

use super::App;
use super::extract::FoundJob;
use super::operation::{Operation, camel};
use super::parts::streamed;
use super::refusal::Refusal;
use super::routes::Routes;
use crate::exports::{self, ExportError, Table};
use crate::store::JobView;
use crate::tables::Form;

/// Tables that are made at a time; each holds some tens of megabytes.
pub const AT_A_TIME: usize = 4;

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
    let body = streamed(move |out| {
        let _place = place;
        let made = exports::write(&app.store, &job, table, form, out);
        made.map_err(|error| match error {
            ExportError::Write(error) => error,
            error => {
                tracing::error!(job = %job.seq, %error, "a table breaks off");
                io::Error::other(error)
            }
        })
    });
    let disposition = HeaderValue::try_from(format!("attachment; filename=\"{name}\""))
        .map_err(|error| Refusal::internal(&error))?;
    let headers: [(HeaderName, HeaderValue); 2] = [
        (CONTENT_TYPE, HeaderValue::from_static(form.media_type())),
        (CONTENT_DISPOSITION, disposition),
    ];
    Ok((headers, body).into_response())
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
