//! `/v1/runs/{id}/frames`, and the arena that they are in.

use std::time::Duration;

use api::ProblemCode::TooManyListeners;
use api::checks::Reach;
use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use futures_util::stream::{self, Stream, StreamExt};
use tokio::sync::OwnedSemaphorePermit;

use super::App;
use super::checks::rows;
use super::extract::{FoundRun, RunId};
use super::operation::{JSON, Operation, Shape};
use super::query::{Parameter, Query};
use super::refusal::Refusal;
use super::routes::Routes;
use crate::store::RunKey;
use crate::watching::{Viewer, hello, steps_of_squares, waiting};

/// Most streams of frames at once.
pub const MAX_VIEWERS: usize = 64;
/// Time between two looks whether somebody steps the run.
const LOOK_EVERY: Duration = Duration::from_millis(250);
/// Time between two signs of life of a silent stream.
const KEEP_ALIVE: Duration = Duration::from_secs(10);
/// Longest time of a stream; whoever looks on asks again.
const LIFE: Duration = Duration::from_secs(60 * 60);

const OF: Parameter = Parameter::word(
    "of",
    &["target", "training"],
    "The arena where visits count, or the one that robots train in, if that is another.",
);

pub fn routes() -> Routes {
    Routes::new()
        .get(
            "/runs/{id}/frames",
            frames,
            Operation::new("watchRun", "Where the robots of a run are, again and again")
                .details(
                    "A stream of binary messages, at most some 33 pictures a second, of any run; \
                     a slow reader misses pictures. `docs/live-frames.md` has the layout. It ends \
                     when the run does.",
                )
                .answers(
                    200,
                    "A stream of at most an hour.",
                    "application/octet-stream",
                    None,
                )
                .streamed()
                .refuses(&[TooManyListeners]),
        )
        .get(
            "/runs/{id}/arena",
            arena,
            Operation::new("getRunArena", "The arena of a run, its walls written out")
                .details("One that is generated or made of another too.")
                .query(&[OF])
                .answers(200, "The arena.", JSON, Some(Shape::Document("Arena"))),
        )
        .get(
            "/runs/{id}/reach",
            reach,
            Operation::new(
                "getRunReach",
                "What of its arena the robots of a run can reach",
            )
            .shows::<Reach>("The squares."),
        )
}

/// `GET /v1/runs/{id}/frames`.
async fn frames(State(app): State<App>, FoundRun(run): FoundRun) -> Result<Response, Refusal> {
    let place = app.viewers.clone().try_acquire_owned().map_err(|_| {
        let detail = format!("{MAX_VIEWERS} streams of frames are open already");
        Refusal::new(TooManyListeners, detail).retry_after_s(5)
    })?;
    let life = tokio::time::sleep(LIFE);
    let messages = messages(app, run.seq, place).take_until(Box::pin(life));
    let body = Body::from_stream(messages.map(Ok::<Bytes, std::convert::Infallible>));
    Ok(([(CONTENT_TYPE, "application/octet-stream")], body).into_response())
}

/// What a reader was told of what a run has covered.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Said {
    Nothing,
    /// Something, before the run was over.
    OnTheWay,
    /// All that there is to tell.
    AtTheEnd,
}

/// One stream.
struct Watching {
    app: App,
    run: RunKey,
    viewer: Option<Viewer>,
    has_begun: bool,
    /// What the reader was told of what was covered.
    said: Said,
    /// The steps in which that was covered, as messages have them.
    said_steps: Option<[u8; 8]>,
    /// Whether the reader was told that nobody steps the run.
    said_waiting: bool,
    _place: OwnedSemaphorePermit,
}

fn messages(
    app: App,
    run: RunKey,
    place: OwnedSemaphorePermit,
) -> impl Stream<Item = Bytes> + Send {
    let watching = Watching {
        app,
        run,
        viewer: None,
        has_begun: false,
        said: Said::Nothing,
        said_steps: None,
        said_waiting: false,
        _place: place,
    };
    stream::unfold(watching, async |mut watching| {
        let message = watching.next().await?;
        Some((message, watching))
    })
}

impl Watching {
    /// The next message; `None` when there will be none.
    async fn next(&mut self) -> Option<Bytes> {
        if !std::mem::replace(&mut self.has_begun, true) {
            return Some(hello());
        }
        let silent = tokio::time::sleep(KEEP_ALIVE);
        tokio::pin!(silent);
        loop {
            let Some(viewer) = &mut self.viewer else {
                if self.app.scheduler.is_stopping() {
                    return None;
                }
                self.viewer = self.app.scheduler.look(self.run);
                if self.viewer.is_some() {
                    (self.said_waiting, self.said) = (false, Said::OnTheWay);
                    continue;
                }
                let covered = self.kept().await?;
                if let Some(covered) = covered.filter(|covered| self.is_news(covered)) {
                    return Some(covered);
                }
                if self.said == Said::AtTheEnd {
                    return None;
                }
                if !std::mem::replace(&mut self.said_waiting, true) {
                    return Some(waiting());
                }
                tokio::select! {
                    () = tokio::time::sleep(LOOK_EVERY) => continue,
                    () = &mut silent => return Some(hello()),
                }
            };
            tokio::select! {
                shown = viewer.next() => match shown {
                    Some(message) => {
                        self.is_news(&message);
                        return Some(message);
                    }
                    // The worker has let the run go.
                    None => self.viewer = None,
                },
                () = &mut silent => return Some(hello()),
            }
        }
    }

    /// Whether a message is not of squares that were shown already; those that it is of are then.
    fn is_news(&mut self, message: &Bytes) -> bool {
        let steps = steps_of_squares(message);
        steps.is_none() || std::mem::replace(&mut self.said_steps, steps) != steps
    }

    /// What the run has covered, once before it is over and once then; `None` when it is gone.
    async fn kept(&mut self) -> Option<Option<Bytes>> {
        let (run, said) = (self.run, self.said);
        let found = self.app.blocking(move |app| {
            let Some(run) = app.store.run_by_key(run)? else {
                return Ok(None);
            };
            let is_over = run.state.state().is_final();
            let is_asked = said == Said::Nothing || is_over && said != Said::AtTheEnd;
            // What failed or was cancelled has kept nothing.
            let covered = is_asked.then(|| app.findings.covered(&run).ok()).flatten();
            Ok(Some((covered, is_over)))
        });
        let (covered, is_over) = found.await.ok().flatten()?;
        self.said = match is_over {
            true => Said::AtTheEnd,
            false => Said::OnTheWay,
        };
        Some(covered)
    }
}

/// `GET /v1/runs/{id}/arena`.
async fn arena(State(app): State<App>, id: RunId, query: Query) -> Result<Response, Refusal> {
    let trains = query.word(&OF)? == Some("training");
    app.with_run(id, move |app, run| {
        let spec = app.findings.resolved(&run)?.run_spec();
        let training = spec.controller.training.as_ref().filter(|_| trains);
        let arena = training.map_or(&spec.arena, |training| &training.arena);
        let text = super::arenas::text(arena)?;
        Ok(([(CONTENT_TYPE, JSON)], text).into_response())
    })
    .await
}

/// `GET /v1/runs/{id}/reach`.
async fn reach(State(app): State<App>, id: RunId) -> Result<Json<Reach>, Refusal> {
    app.with_run(id, move |app, run| {
        let spec = app.findings.resolved(&run)?;
        let mask = app.findings.mask(spec.arena(), spec.body_radius_m());
        let mask = mask.as_deref().unwrap_or_default();
        Ok(Json(Reach {
            // An arena has at most 1,000,000 squares.
            reachable: mask.iter().filter(|&&within| within).count() as u32,
            reachable_rows: rows(mask, spec.arena()),
        }))
    })
    .await
}
