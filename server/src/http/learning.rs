//! `/v1/runs/{id}/learnt` and `/learning`: what robots have learnt, asked of the worker that steps
//! them, else as it was kept.

use std::time::Duration;

use api::ProblemCode::{CheckpointNotKept, FindingsNotKept, NothingLearnt};
use api::State::{Cancelled, Failed};
use api::learnt::{Learning, Learnt};
use axum::Json;
use axum::extract::State;
use swarm::run::Run;

use super::App;
use super::extract::FoundRun;
use super::operation::Operation;
use super::query::{CURSOR, LIMIT, Parameter, Query};
use super::refusal::Refusal;
use super::routes::Routes;
use crate::documents::MAX_ROBOTS;
use crate::findings::FindingsError;
use crate::store::RunView;
use crate::watching::{learning, shown};

/// Most checkpoints that are opened at once for what was learnt.
pub const MAX_OPENED: usize = 1;
/// Longest time in which a run's thread answers, between two blocks of steps.
const ANSWER: Duration = Duration::from_secs(10);

const ROBOT: Parameter = Parameter::whole(
    "robot",
    (0, MAX_ROBOTS as i64 - 1),
    "Number of the robot, from 0.",
)
.or(0);

pub fn routes() -> Routes {
    Routes::new()
        .get(
            "/runs/{id}/learnt",
            of_one,
            Operation::new("getLearnt", "What a robot has learnt")
                .details(
                    "At this moment where the run is being stepped, else as its last checkpoint \
                     or its end has it.",
                )
                .query(&[ROBOT])
                .shows::<Learnt>("The robot's learner.")
                .refuses(&[NothingLearnt, FindingsNotKept, CheckpointNotKept]),
        )
        .get(
            "/runs/{id}/learning",
            of_all,
            Operation::new("getLearning", "How far the robots of a run have learnt")
                .details(
                    "Phase, clusters, fitness, and memory against its bound; a page of robots. At \
                     this moment where the run is being stepped, else as its last checkpoint or its \
                     end has it; of a run whose last state is not kept any more, what its result \
                     tells.",
                )
                .query(&[LIMIT, CURSOR])
                .shows::<Learning>("What they have learnt.")
                .refuses(&[NothingLearnt, FindingsNotKept]),
        )
}

/// `GET /v1/runs/{id}/learnt`.
async fn of_one(
    State(app): State<App>,
    FoundRun(run): FoundRun,
    query: Query,
) -> Result<Json<Learnt>, Refusal> {
    // The parameter has a default and a range that fits.
    let robot = query
        .number(&ROBOT)?
        .and_then(|robot| robot.try_into().ok());
    let robot: u32 = robot.unwrap_or(0);
    let method = run.method.clone();
    let look = move |run: &Run, is_live| shown(run, robot, is_live).map(Box::new);
    let learnt = looked(app, run, look, |_, _| None).await?;
    learnt.map(|learnt| Json(*learnt)).ok_or_else(|| {
        let detail = format!(
            "robot {robot} of this run has learnt nothing: its method ({method}) learns nothing, or \
             there is no such robot"
        );
        Refusal::new(NothingLearnt, detail)
    })
}

/// `GET /v1/runs/{id}/learning`.
async fn of_all(
    State(app): State<App>,
    FoundRun(run): FoundRun,
    query: Query,
) -> Result<Json<Learning>, Refusal> {
    let page = query.page()?;
    // Beyond the last robot there is none.
    let from = page
        .cursor
        .map_or(0, |from| from.try_into().unwrap_or(u32::MAX));
    let (id, model) = (run.id.clone(), run.result().and_then(|result| result.model));
    let method = run.method.clone();
    let look = move |run: &Run, is_live| learning(run, from, page.limit, is_live).map(Box::new);
    let kept = |app: &App, run: &RunView| {
        let learning = app.findings.learning_at_the_end(run);
        Some(learning.map(|learning| learning.map(Box::new)))
    };
    let learning = looked(app, run, look, kept).await?;
    let learning = learning.ok_or_else(|| {
        let detail = format!("robots of this run learn nothing: its method is {method}");
        Refusal::new(NothingLearnt, detail)
    })?;
    Ok(Json(Learning {
        run_id: id,
        model,
        ..*learning
    }))
}

/// What a look at the run says, told whether it is live: by the worker that holds it, else of what
/// is kept of it. Where that is not its last state any more, `else_kept` may say something.
async fn looked<T: Send + 'static>(
    app: App,
    run: RunView,
    look: impl Fn(&Run, bool) -> T + Clone + Send + 'static,
    else_kept: impl FnOnce(&App, &RunView) -> Option<Result<T, FindingsError>> + Send + 'static,
) -> Result<T, Refusal> {
    // A worker may still hold a run that was cancelled.
    let is_kept = !matches!(run.state.state(), Failed | Cancelled);
    let live = look.clone();
    let asked = is_kept
        .then(|| app.scheduler.ask(run.seq, move |run| live(run, true)))
        .flatten();
    if let Some(answer) = asked
        && let Ok(Ok(said)) = tokio::time::timeout(ANSWER, answer).await
    {
        return Ok(said);
    }
    // One is opened at a time, as it may be large.
    let place = app.opened.clone().acquire_owned().await;
    let place = place.map_err(|error| Refusal::internal(&error))?;
    app.blocking(move |app| {
        let said = match app.findings.looked(&run, |run| look(run, false)) {
            Err(FindingsError::StateNotKept) => {
                else_kept(app, &run).unwrap_or(Err(FindingsError::StateNotKept))
            }
            said => said,
        };
        drop(place);
        Ok(said?)
    })
    .await
}
