//! `/v1/runs/{id}/recording`: what was recorded while the run was stepped, as its file, in slices,
//! and in other formats.

use std::fs::File;
use std::io::{self, Write};
use std::sync::Arc;

use api::ProblemCode::{self, RecordingNotFound};
use api::recording::RecordingSlice;
use axum::Json;
use axum::extract::State;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::http::{HeaderMap, HeaderValue};
use axum::response::{IntoResponse, Response};
use recording::Reader;
use swarm::spec::Method;
use tokio::sync::OwnedSemaphorePermit;

use super::App;
use super::extract::FoundRun;
use super::operation::Operation;
use super::partial;
use super::parts::streamed;
use super::query::{Parameter, Query};
use super::refusal::Refusal;
use super::routes::Routes;
use crate::explain::NOT_STEPPED_AGAIN;
use crate::recording::{Paths, SliceError, SliceQuery, Stage, slice, write_mcap, write_rows};
use crate::store::RunView;
use crate::tables::Form;

/// What a recording is sent as.
pub const MEDIA_TYPE: &str = "application/octet-stream";
/// What MCAP is sent as.
pub const MCAP: &str = "application/x-mcap";
/// Most robots that a slice names.
const MOST_ROBOTS: usize = 1_000;

const FROM_STEP: Parameter = Parameter::whole(
    "from_step",
    (0, i64::MAX),
    "First step, counted over all phases; the first that is recorded unless it is given.",
);
const STEPS: Parameter = Parameter::whole("steps", (1, i64::MAX), "How many steps from there.");
const EVERY: Parameter = Parameter::whole(
    "every",
    (1, i64::MAX),
    "Only steps 0, n, 2n, ... of each epoch; of more than an epoch, the beginnings of epochs.",
)
.or(1);
const ROBOTS: Parameter = Parameter::text(
    "robots",
    "Numbers of robots, separated by commas, a thousand at most; the first hundred that are recorded \
     unless it is given.",
)
.up_to(8_000);
/// Parameters of a slice.
pub const SLICE: &[Parameter] = &[FROM_STEP, STEPS, EVERY, ROBOTS];

pub fn routes() -> Routes {
    let routes = Routes::new()
        .get(
            "/runs/{id}/recording",
            file,
            Operation::new("getRecording", "What the run recorded of itself, as a file")
                .details(
                    "Where its spec says `record`. The format is told in docs/recordings.md. Of a \
                     run under way, what there is so far.",
                )
                .answers(200, "The recording.", MEDIA_TYPE, None)
                .refuses(&[RecordingNotFound]),
        )
        .get(
            "/runs/{id}/recording.json",
            json,
            Operation::new("getRecordingSlice", "A slice of what the run recorded")
                .details(
                    "At most 10,000 moments and 100,000 poses; `next_step` says where to go on.",
                )
                .query(SLICE)
                .shows::<RecordingSlice>("The slice.")
                .refuses(&[RecordingNotFound]),
        );
    let routes = routes.get(
        "/runs/{id}/recording.mcap",
        mcap,
        Operation::new("getRecordingAsMcap", "What the run recorded, as MCAP")
            .details("Poses, signals of each robot, and the arena as a scene; schemas are inside.")
            .answers(200, "The file.", MCAP, None)
            .streamed()
            .refuses(&[RecordingNotFound]),
    );
    [Form::Csv, Form::Parquet]
        .into_iter()
        .fold(routes, |routes, form| {
            let show = move |State(app): State<App>, FoundRun(run)| async move {
                table(app.clone(), live(&app, &run), run, "recording", form).await
            };
            let path = format!("/runs/{{id}}/recording.{}", form.suffix());
            let told = Operation::new(
                format!("getRecordingAs{form:?}"),
                "What the run recorded, a row for each moment and robot",
            );
            let told = told
                .answers(200, "The table.", form.media_type(), None)
                .streamed()
                .refuses(&[RecordingNotFound]);
            routes.get(&path, show, told)
        })
}

fn live(app: &App, run: &RunView) -> Paths {
    app.store.recordings().live(&run.id)
}

/// `GET /v1/runs/{id}/recording`.
async fn file(
    State(app): State<App>,
    FoundRun(run): FoundRun,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    let paths = live(&app, &run);
    whole(app, paths, run, "recording", headers).await
}

/// `GET /v1/runs/{id}/recording.json`.
async fn json(
    State(app): State<App>,
    FoundRun(run): FoundRun,
    query: Query,
) -> Result<Json<RecordingSlice>, Refusal> {
    let paths = live(&app, &run);
    cut(app, paths, run, query).await
}

/// `GET /v1/runs/{id}/recording.mcap`.
async fn mcap(State(app): State<App>, FoundRun(run): FoundRun) -> Result<Response, Refusal> {
    let paths = live(&app, &run);
    as_mcap(app, paths, run, "recording").await
}

/// The file of a recording, or the part of it that is asked for.
pub async fn whole(
    app: App,
    paths: Paths,
    run: RunView,
    name: &'static str,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    let place = place(&app)?;
    app.blocking(move |_| {
        // What there is already of a recording stays as it is.
        let (file, stage) = open(&paths, &run)?;
        let (kind, name) = (format!("{stage:?}"), format!("{name}.evrec"));
        partial::file(file, &kind, (MEDIA_TYPE, &name), &headers, place)
    })
    .await
}

/// A slice of a recording.
pub async fn cut(
    app: App,
    paths: Paths,
    run: RunView,
    query: Query,
) -> Result<Json<RecordingSlice>, Refusal> {
    let number = |parameter: &Parameter| -> Result<Option<u64>, Refusal> {
        let number = query.number(parameter)?;
        Ok(number.and_then(|number| u64::try_from(number).ok()))
    };
    let wanted = SliceQuery {
        from_step: number(&FROM_STEP)?,
        steps: number(&STEPS)?,
        every: number(&EVERY)?,
        robots: query.text(&ROBOTS)?.map(|text| robots(&text)).transpose()?,
    };
    app.blocking(move |_| {
        let (mut reader, stage) = read(&paths, &run)?;
        slice(&mut reader, stage, &wanted)
            .map(Json)
            .map_err(|error| match error {
                SliceError::NotRecorded(_) => {
                    Refusal::new(ProblemCode::InvalidQuery, error.to_string())
                }
                SliceError::Recording(error) => Refusal::damaged(&error),
            })
    })
    .await
}

fn robots(text: &str) -> Result<Vec<u32>, Refusal> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|one| one.trim().parse()).collect();
    match numbers {
        Ok(numbers) if numbers.len() <= MOST_ROBOTS => Ok(numbers),
        _ => Err(Refusal::new(
            ProblemCode::InvalidQuery,
            format!("robots are at most {MOST_ROBOTS} numbers separated by commas"),
        )),
    }
}

/// A recording as a table.
pub async fn table(
    app: App,
    paths: Paths,
    run: RunView,
    name: &'static str,
    form: Form,
) -> Result<Response, Refusal> {
    let suffix = form.suffix();
    let made = move |reader: &mut Reader<File>, out: &mut (dyn Write + Send)| {
        write_rows(reader, form, out)
    };
    convert(app, paths, run, (name, suffix, form.media_type()), made).await
}

/// A recording as MCAP.
pub async fn as_mcap(
    app: App,
    paths: Paths,
    run: RunView,
    name: &'static str,
) -> Result<Response, Refusal> {
    let made = |reader: &mut Reader<File>, out: &mut (dyn Write + Send)| write_mcap(reader, out);
    convert(app, paths, run, (name, "mcap", MCAP), made).await
}

/// A recording in another format, made while it is sent.
pub async fn convert(
    app: App,
    paths: Paths,
    run: RunView,
    (name, suffix, media_type): (&'static str, &'static str, &'static str),
    make: impl FnOnce(&mut Reader<File>, &mut (dyn Write + Send)) -> io::Result<()> + Send + 'static,
) -> Result<Response, Refusal> {
    let place = place(&app)?;
    let (mut reader, _) = app.blocking(move |_| read(&paths, &run)).await?;
    let disposition = format!("attachment; filename=\"{name}.{suffix}\"");
    let disposition =
        HeaderValue::try_from(disposition).map_err(|error| Refusal::internal(&error))?;
    let headers = [
        (CONTENT_TYPE, HeaderValue::from_static(media_type)),
        (CONTENT_DISPOSITION, disposition),
    ];
    let body = streamed(move |out| {
        let _place = place;
        make(&mut reader, out)
    });
    Ok((headers, body).into_response())
}

/// A place among the answers that are made while they are sent.
fn place(app: &App) -> Result<OwnedSemaphorePermit, Refusal> {
    let place = Arc::clone(&app.exports).try_acquire_owned();
    place.map_err(|_| {
        let detail = "too many files are being sent; try again later";
        Refusal::new(ProblemCode::Overloaded, detail).retry_after_s(5)
    })
}

fn open(paths: &Paths, run: &RunView) -> Result<(File, Stage), Refusal> {
    let opened = paths.open().map_err(|error| Refusal::internal(&error))?;
    opened.ok_or_else(|| {
        let what = format!("the run {} has no such recording", run.id);
        let detail = if run.method == Method::External.name() {
            format!("{what}: {NOT_STEPPED_AGAIN}")
        } else {
            format!("{what}; POST /v1/runs/{}/recordings makes one", run.id)
        };
        Refusal::new(RecordingNotFound, detail)
    })
}

fn read(paths: &Paths, run: &RunView) -> Result<(Reader<File>, Stage), Refusal> {
    let (file, stage) = open(paths, run)?;
    let reader = Reader::open(file);
    let reader = reader.map_err(|error| Refusal::damaged(&error))?;
    Ok((reader, stage))
}
