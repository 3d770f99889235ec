//! `/v1/events`, `/v1/jobs/{id}/events` and `/v1/runs/{id}/events`: server-sent events.

use std::convert::Infallible;
use std::time::Duration;

use api::ProblemCode::{self, RunNotFound, TooManyListeners};
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream::{self, Stream, StreamExt};
use serde_json::json;

use super::App;
use super::extract::{FoundJob, FoundRun};
use super::operation::{EVENTS, Operation};
use super::query::{Parameter, Query};
use super::refusal::Refusal;
use super::routes::Routes;
use crate::events::{Feed, Told};
use crate::store::{RunKey, Subject};

/// How soon a browser asks again when the connection is lost.
const RETRY: Duration = Duration::from_secs(2);
/// Time between two signs of life of a silent stream.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// Longest time of a stream; whoever listens on asks again, with the id of the last event.
const LIFE: Duration = Duration::from_secs(60 * 60);

/// Most digits of the id of an event.
const ID_DIGITS: usize = 18;

const RUN: Parameter = Parameter::text(
    "run",
    "Id of a run of which also is told what listeners to it hear.",
);

pub fn routes() -> Routes {
    Routes::new()
        .get(
            "/events",
            of_all,
            listening("listenToAll", "Events of all jobs and runs")
                .query(&[RUN])
                .refuses(&[RunNotFound]),
        )
        .get(
            "/jobs/{id}/events",
            of_job,
            listening("listenToJob", "Events of a job"),
        )
        .get(
            "/runs/{id}/events",
            of_run,
            listening("listenToRun", "Events of a run"),
        )
}

fn listening(id: &str, about: &str) -> Operation {
    Operation::new(id, about)
        .details(
            "Server-sent events. The name of an event is the `event` of the schema `Event`, its \
             data the `data`, as JSON. Every change of state and every deletion of a job comes, in \
             order, with an id (to who comes back but those of runs that are gone by then); of the \
             others a slow listener misses some. A stream of a job or a run ends when that is \
             deleted; then it is not found.",
        )
        .header(
            "Last-Event-ID",
            "Id of the last event that was heard: goes on behind it.",
            json!({ "type": "string", "pattern": "^[0-9]{1,18}$" }),
        )
        .answers(200, "A stream of at most an hour.", EVENTS, None)
        .streamed()
        .refuses(&[TooManyListeners])
}

async fn of_all(
    State(app): State<App>,
    query: Query,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    let run = match query.text(&RUN)? {
        Some(id) => {
            let run = app.blocking(move |app| app.run(&id)).await?;
            Some((run.seq, run.id))
        }
        None => None,
    };
    listen(&app, Subject::All, run, &headers)
}

async fn of_job(
    State(app): State<App>,
    FoundJob(job): FoundJob,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    listen(&app, Subject::Job(job.seq), None, &headers)
}

async fn of_run(
    State(app): State<App>,
    FoundRun(run): FoundRun,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    listen(&app, Subject::Run(run.seq), None, &headers)
}

fn listen(
    app: &App,
    subject: Subject,
    and_run: Option<(RunKey, String)>,
    headers: &HeaderMap,
) -> Result<Response, Refusal> {
    let heard = match headers.get("last-event-id") {
        None => None,
        Some(id) => Some(
            id.to_str()
                .ok()
                .filter(|id| id.len() <= ID_DIGITS && id.bytes().all(|byte| byte.is_ascii_digit()))
                .and_then(|id| id.parse().ok())
                .ok_or_else(|| {
                    Refusal::new(
                        ProblemCode::InvalidHeader,
                        "Last-Event-ID is the id of an event, a whole number",
                    )
                })?,
        ),
    };
    let feed = Feed::open(&app.events, subject, and_run, heard).map_err(|error| {
        Refusal::new(ProblemCode::TooManyListeners, error.to_string()).retry_after_s(5)
    })?;
    let life = tokio::time::sleep(LIFE);
    let events =
        Sse::new(told(feed).take_until(life)).keep_alive(KeepAlive::new().interval(KEEP_ALIVE));
    Ok(events.into_response())
}

fn told(feed: Feed) -> impl Stream<Item = Result<Event, Infallible>> + Send {
    let first = stream::once(async { Event::default().retry(RETRY) });
    let rest = stream::unfold(feed, async |mut feed| {
        let told = feed.next().await?;
        Some((stream::iter(told.into_iter().map(shown)), feed))
    });
    first.chain(rest.flatten()).map(Ok)
}

fn shown(Told { id, event }: Told) -> Event {
    // Events are strings, finite numbers and lists: JSON can hold all of them.
    let data = serde_json::to_value(&event)
        .map(|value| value["data"].to_string())
        .unwrap_or_default();
    let shown = Event::default().event(event.name()).data(data);
    match id {
        Some(id) => shown.id(id.to_string()),
        None => shown,
    }
}
