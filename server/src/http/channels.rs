//! `/v1/runs/{id}/channels`: what local programs can open of a run, asked for and closed while it is
//! under way.

use std::time::{Duration, Instant};

use api::ProblemCode::{AlreadyEnded, TooManyListeners};
use api::channels::{AskedChannels, ChannelDescription};
use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};

use super::App;
use super::extract::RunId;
use super::operation::{Operation, Shape};
use super::refusal::Refusal;
use super::request::said_to_be_json;
use super::routes::Routes;
use crate::channels::{ChannelSet, Desk, Extent, Fate, MAX_ASKED_RUNS, describe};
use crate::documents::asked_channels;
use crate::store::RunView;

/// Longest time that a request waits for the run's thread to open what was asked for.
const WAIT: Duration = Duration::from_secs(1);
/// Time between two looks whether it has.
const LOOK: Duration = Duration::from_millis(5);

pub fn routes() -> Routes {
    Routes::new()
        .get(
            "/runs/{id}/channels",
            show,
            Operation::new(
                "getRunChannels",
                "How local programs can watch or steer the run",
            )
            .details("Every channel that the run has or may have, open or not.")
            .shows::<Vec<ChannelDescription>>(
                "What is needed to open each in shared memory, and whether it is open.",
            ),
        )
        .post(
            "/runs/{id}/channels",
            ask,
            Operation::new(
                "openRunChannels",
                "Open channels of a run while it is under way",
            )
            .details(
                "In place of what was asked for before; those of the spec stay. It takes effect \
                     within a second, or when a worker takes up the run, and changes neither spec \
                     nor results. What was asked for is forgotten when the run ends and when the \
                     server does. At most 256 runs have such channels at once.",
            )
            .takes(Shape::of::<AskedChannels>())
            .shows::<Vec<ChannelDescription>>("All channels, as they are then.")
            .refuses(&[AlreadyEnded, TooManyListeners]),
        )
        .delete(
            "/runs/{id}/channels",
            close,
            Operation::new(
                "closeRunChannels",
                "Close what was asked for of a run's channels",
            )
            .details("Those of the spec stay open.")
            .answers_nothing("They are closed, or will be within a second."),
        )
}

/// `GET /v1/runs/{id}/channels`.
async fn show(State(app): State<App>, id: RunId) -> Result<Json<Vec<ChannelDescription>>, Refusal> {
    app.with_run(id, move |app, run| described(app, &run)).await
}

/// `POST /v1/runs/{id}/channels`.
async fn ask(
    State(app): State<App>,
    id: RunId,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Json<Vec<ChannelDescription>>, Refusal> {
    said_to_be_json(&headers)?;
    app.with_run(id, move |app, run| {
        let document = app.read(&body)?;
        let set = asked_channels(&document).map_err(Refusal::fields)?;
        let state = run.state.state();
        if state.is_final() {
            let detail = format!("the run is {state}: nothing of it can be watched");
            return Err(Refusal::new(AlreadyEnded, detail));
        }
        let desks = app.scheduler.desks();
        let asked = desks.ask(&run.id, set).or_else(|_| {
            forget_ended(app)?;
            desks.ask(&run.id, set).map_err(|_| {
                let detail = format!("{MAX_ASKED_RUNS} runs have such channels already");
                Refusal::new(TooManyListeners, detail).retry_after_s(5)
            })
        })?;
        if state == api::State::Running {
            await_opening(&asked, set);
        }
        described(app, &run)
    })
    .await
}

/// `DELETE /v1/runs/{id}/channels`.
async fn close(State(app): State<App>, id: RunId) -> Result<StatusCode, Refusal> {
    app.with_run(id, move |app, run| {
        // Asking for nothing is never too much.
        drop(app.scheduler.desks().ask(&run.id, ChannelSet::default()));
        Ok(StatusCode::NO_CONTENT)
    })
    .await
}

fn described(app: &App, run: &RunView) -> Result<Json<Vec<ChannelDescription>>, Refusal> {
    let spec = app.findings.resolved(run)?;
    // What was asked of a run that has ended is not worth telling.
    let is_under_way = !run.state.state().is_final();
    let desk = is_under_way.then(|| app.scheduler.desks().find(&run.id));
    let channels = describe(
        app.scheduler.channels(),
        &run.id,
        Extent::of(&spec.run_spec()),
        ChannelSet::of_spec(spec.channels()),
        desk.flatten().as_deref(),
    );
    Ok(Json(channels.map_err(|error| Refusal::internal(&error))?))
}

/// Forgets what was asked of runs that have ended, or are gone.
fn forget_ended(app: &App) -> Result<(), Refusal> {
    for id in app.scheduler.desks().asked() {
        let run = app.store.run(&id)?;
        if run.is_none_or(|run| run.state.state().is_final()) {
            app.scheduler.desks().forget(&id);
        }
    }
    Ok(())
}

/// Waits a little until each channel is open, or is known not to be.
fn await_opening(desk: &Desk, set: ChannelSet) {
    let wanted = [
        ("frames", set.frames),
        ("coverage", set.coverage),
        ("metrics", set.metrics),
        ("status", set.status),
        ("lossless", set.lossless.is_some()),
    ];
    let since = Instant::now();
    loop {
        let fates = desk.fates();
        let is_settled = wanted.iter().all(|(name, is_wanted)| {
            let fate: Option<&Fate> = fates.get(name);
            fate.is_some() == *is_wanted || !is_wanted
        });
        if is_settled || since.elapsed() >= WAIT {
            return;
        }
        std::thread::sleep(LOOK);
    }
}
