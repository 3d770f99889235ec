//! `/v1/runs/{id}/explain`: why a run did what it did, found in the background by stepping it again.

use std::time::{Duration, Instant};

use api::ProblemCode::{NoResult, NotRepeatable, RecordingsFull};
use api::explanation::{Explanation, ExplanationPending};
use axum::Json;
use axum::extract::State;
use axum::http::header::RETRY_AFTER;
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};

use super::App;
use super::extract::FoundRun;
use super::operation::{JSON, Operation, Shape};
use super::refusal::Refusal;
use super::routes::Routes;
use crate::recording::Explained;

/// How long an answer waits for one that is nearly there.
const PATIENCE: Duration = Duration::from_secs(2);
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(50);

pub fn routes() -> Routes {
    Routes::new().get(
        "/runs/{id}/explain",
        explain,
        Operation::new(
            "explainRun",
            "Why a run did what it did, in words and figures",
        )
        .details(
            "Where robots stayed, how, in which states, by which actions and scores. The run \
                 is stepped again for it, once; ask again while that goes on.",
        )
        .shows::<Explanation>("The explanation.")
        .answers(
            202,
            "It is being found, or waits for what is before it.",
            JSON,
            Some(Shape::of::<ExplanationPending>()),
        )
        .refuses(&[RecordingsFull, NotRepeatable, NoResult]),
    )
}

/// `GET /v1/runs/{id}/explain`.
async fn explain(State(app): State<App>, FoundRun(run): FoundRun) -> Result<Response, Refusal> {
    let spec = app
        .blocking({
            let run = run.clone();
            move |app| Ok(app.findings.resolved(&run)?)
        })
        .await?;
    let robot_steps = spec.robot_steps();
    let end = Instant::now() + PATIENCE;
    loop {
        let (run, spec) = (run.clone(), spec.clone());
        let explained = app
            .blocking(move |app| Ok(app.recordings.explained(&run, &spec)?))
            .await?;
        match explained {
            Explained::Known(explanation) => return Ok(Json(*explanation).into_response()),
            Explained::Failed(reason) => return Err(Refusal::damaged(&reason)),
            Explained::Pending(progress) if Instant::now() >= end => {
                let pending = ExplanationPending {
                    robot_steps,
                    progress,
                };
                let retry = [(RETRY_AFTER, HeaderValue::from(1))];
                return Ok((StatusCode::ACCEPTED, retry, Json(pending)).into_response());
            }
            Explained::Pending(_) => tokio::time::sleep(LOOK).await,
        }
    }
}
