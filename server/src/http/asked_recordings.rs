//! `/v1/runs/{id}/recordings`: those that there are of a run, and those that are asked for
//! afterwards, for which the run is stepped again.

use api::ProblemCode::{
    self, NoResult, NotRepeatable, RecordingBeingMade, RecordingNotFound, RecordingsFull,
};
use api::recording::{
    AskRecording, RecordingList, RecordingSlice, RecordingState, RecordingSummary,
};
use axum::Json;
use axum::body::Bytes;
use axum::extract::{FromRequestParts, Path, State};
use axum::http::header::LOCATION;
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};

use super::App;
use super::extract::RunId;
use super::operation::{Operation, Shape};
use super::query::Query;
use super::recordings::{MCAP, MEDIA_TYPE, SLICE, as_mcap, cut, table, whole};
use super::refusal::Refusal;
use super::request::{number, said_to_be_json};
use super::routes::Routes;
use crate::recording::{AskError, Paths, Wish, live_state};
use crate::store::RunView;
use crate::tables::Form;

/// Name of the recording that a run's own spec asks for.
const LIVE: &str = "live";

pub fn routes() -> Routes {
    let recording = |id: &str, about: &str| Operation::new(id, about).refuses(&[RecordingNotFound]);
    let form = |form: Form| {
        let about = "A recording, a row for each moment and robot";
        recording(&format!("getRunRecordingAs{form:?}"), about)
            .answers(200, "The table.", form.media_type(), None)
            .streamed()
    };
    Routes::new()
        .get(
            "/runs/{id}/recordings",
            list,
            Operation::new("listRecordings", "The recordings that there are of a run")
                .shows::<RecordingList>("They, and those that are still to be made."),
        )
        .post(
            "/runs/{id}/recordings",
            ask,
            Operation::new("askRecording", "Record a stretch of a run afterwards")
                .details(
                    "The run is stepped again in the background, from a checkpoint that was kept \
                     or from its beginning. The recording is what a live one would have been, \
                     byte for byte. One that was asked for before is given back.",
                )
                .takes(Shape::of::<AskRecording>())
                .creates::<RecordingSummary>(201, "It is to be made.")
                .shows::<RecordingSummary>("It was asked for before.")
                .refuses(&[RecordingsFull, NotRepeatable]),
        )
        .get(
            "/runs/{id}/recordings/{name}",
            show,
            recording("getRunRecording", "A recording, as its file")
                .details("`live` is what the run recorded of itself, as its spec asks for.")
                .query(SLICE)
                .answers(200, "The recording.", MEDIA_TYPE, None),
        )
        .also_read_as(
            "/runs/{id}/recordings/{name}.json",
            recording("getRunRecordingSlice", "A slice of a recording")
                .query(SLICE)
                .shows::<RecordingSlice>("The slice."),
        )
        .also_read_as(
            "/runs/{id}/recordings/{name}.mcap",
            recording("getRunRecordingAsMcap", "A recording, as MCAP")
                .answers(200, "The file.", MCAP, None)
                .streamed(),
        )
        .also_read_as("/runs/{id}/recordings/{name}.csv", form(Form::Csv))
        .also_read_as("/runs/{id}/recordings/{name}.parquet", form(Form::Parquet))
        .delete(
            "/runs/{id}/recordings/{name}",
            delete,
            Operation::new("deleteRecording", "Delete a recording, or give it up")
                .answers_nothing("It is deleted.")
                .refuses(&[RecordingNotFound, RecordingBeingMade]),
        )
}

/// The run and the name of a recording in the path.
struct Named {
    run: RunView,
    name: String,
}

impl FromRequestParts<App> for Named {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Refusal> {
        let path = Path::from_request_parts(parts, app).await;
        let Path((id, name)): Path<(String, String)> =
            path.map_err(|_| Refusal::new(ProblemCode::InvalidRequest, "the path cannot be read"))?;
        app.blocking(move |app| app.run(&id).map(|run| Self { run, name }))
            .await
    }
}

fn not_found(name: &str) -> Refusal {
    Refusal::not_found(RecordingNotFound, "recording", name)
}

/// Where the recording of a name is.
fn paths(app: &App, run: &RunView, name: &str) -> Result<Paths, Refusal> {
    if name == LIVE {
        return Ok(app.store.recordings().live(&run.id));
    }
    Ok(wish(app, run, name)?.paths(&app.store.recordings().of(&run.id)))
}

/// The recording of a number that was asked for.
fn wish(app: &App, run: &RunView, name: &str) -> Result<Wish, Refusal> {
    let wish = number(name).and_then(|number| app.recordings.wish(&run.id, number));
    wish.ok_or_else(|| not_found(name))
}

/// `GET /v1/runs/{id}/recordings`.
async fn list(State(app): State<App>, id: RunId) -> Result<Json<RecordingList>, Refusal> {
    app.with_run(id, move |app, run| {
        let spec = app.findings.resolved(&run)?;
        let items = app.recordings.list(&run, &spec);
        Ok(Json(RecordingList { items }))
    })
    .await
}

/// `POST /v1/runs/{id}/recordings`.
async fn ask(
    State(app): State<App>,
    id: RunId,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Response, Refusal> {
    said_to_be_json(&headers)?;
    app.with_run(id, move |app, run| {
        let document = app.read(&body)?;
        let spec = app.findings.resolved(&run)?;
        let (wish, is_new) = app.recordings.ask(&run, &spec, &document)?;
        let shown = Json(app.recordings.summary(&run.id, &wish));
        let location = format!("/v1/runs/{}/recordings/{}", run.id, wish.number);
        let status = match is_new {
            true => StatusCode::CREATED,
            false => StatusCode::OK,
        };
        Ok((status, [(LOCATION, location)], shown).into_response())
    })
    .await
}

/// `GET /v1/runs/{id}/recordings/{name}`, with the end of the name for the format.
async fn show(
    State(app): State<App>,
    Named { run, name }: Named,
    query: Query,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    let (name, form) = match name.split_once('.') {
        Some((name, form)) => (name.to_owned(), Some(form.to_owned())),
        None => (name, None),
    };
    let (run, paths) = app
        .blocking(move |app| {
            let paths = paths(app, &run, &name)?;
            Ok((run, paths))
        })
        .await?;
    match form.as_deref() {
        None => whole(app, paths, run, "recording", headers).await,
        Some("json") => Ok(cut(app, paths, run, query).await?.into_response()),
        Some("mcap") => as_mcap(app, paths, run, "recording").await,
        Some("csv") => table(app, paths, run, "recording", Form::Csv).await,
        Some("parquet") => table(app, paths, run, "recording", Form::Parquet).await,
        Some(form) => Err(not_found(form)),
    }
}

/// `DELETE /v1/runs/{id}/recordings/{name}`.
async fn delete(State(app): State<App>, Named { run, name }: Named) -> Result<StatusCode, Refusal> {
    app.blocking(move |app| {
        if name == LIVE {
            let paths = app.store.recordings().live(&run.id);
            let opened = paths.open().map_err(|error| Refusal::internal(&error))?;
            let (_, stage) = opened.ok_or_else(|| not_found(&name))?;
            if live_state(&run, stage) == RecordingState::Recording {
                let detail = "the run is still to record more of itself";
                return Err(Refusal::new(RecordingBeingMade, detail));
            }
            paths.remove_bytes();
            return Ok(StatusCode::NO_CONTENT);
        }
        let wish = wish(app, &run, &name)?;
        app.recordings.delete(&run.id, &wish);
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

impl From<AskError> for Refusal {
    fn from(error: AskError) -> Self {
        let detail = error.to_string();
        match error {
            AskError::Invalid(errors) => Self::fields(errors),
            AskError::TooManyWait => Self::new(RecordingsFull, detail).retry_after_s(30),
            AskError::TooMany => Self::new(RecordingsFull, detail),
            AskError::NotRepeatable(_) => Self::new(NotRepeatable, detail),
            AskError::NotDone(_) => Self::new(NoResult, detail),
            AskError::Origin(_) => Self::damaged(&detail),
            AskError::Io(error) => Self::internal(&error),
        }
    }
}
