//! Every route of the service, and the layers around all of them.

use std::sync::Arc;

use api::ProblemCode;
use axum::extract::DefaultBodyLimit;
use axum::http::{Method, Uri};
use axum::{Router, middleware};

use tokio::sync::Semaphore;

use crate::events::Hub;
use crate::findings::Assembler;
use crate::recording::{Maker, Settings};
use crate::scheduler::Scheduler;
use crate::store::{RunView, Store};
use crate::turns::Turns;

use super::access::Tokens;
use super::answers::{self, Answers};
use super::app::App;
use super::guard::{self, Gate};
use super::metrics::Metrics;
use super::refusal::Refusal;
use super::routes::Routes;
use super::{
    arenas, asked_recordings, catalog, channels, checkpoints, checks, comparison, compression,
    conditional, contract, control, events, explain, exports, files, health, job_findings, jobs,
    learning, openapi, page, problems, recordings, runs, scrape, watching, workers,
};

/// Every route, and what each does.
pub fn routes() -> Routes {
    let v1 = Routes::new()
        .merge(jobs::routes())
        .merge(control::routes())
        .merge(checkpoints::routes())
        .merge(job_findings::routes())
        .merge(comparison::routes())
        .merge(exports::routes())
        .merge(runs::routes())
        .merge(channels::routes())
        .merge(events::routes())
        .merge(files::routes())
        .merge(watching::routes())
        .merge(learning::routes())
        .merge(recordings::routes())
        .merge(asked_recordings::routes())
        .merge(explain::routes())
        .merge(arenas::routes())
        .merge(checks::routes())
        .merge(catalog::routes())
        .merge(workers::routes());
    Routes::new()
        .merge(page::routes())
        .merge(health::routes())
        .merge(problems::routes())
        .merge(contract::routes())
        .merge(scrape::routes())
        .below("/v1", v1)
}

/// Who makes recordings afterwards.
fn recordings(store: &Arc<Store>, scheduler: &Arc<Scheduler>, findings: &Arc<Assembler>) -> Maker {
    let config = scheduler.config();
    let settings = Settings {
        limits: config.recordings,
        run_memory_bytes: config.run_memory_bytes,
    };
    let findings = Arc::clone(findings);
    let spec_of = move |run: &RunView| {
        findings
            .resolved_at_once(run)
            .map_err(|error| error.to_string())
    };
    Maker::start(Arc::clone(store), Box::new(spec_of), settings)
}

/// The service: every route, behind the gate.
pub fn router(store: Arc<Store>, scheduler: Arc<Scheduler>, tokens: Tokens) -> Router {
    let (described, router) = routes().into_parts();
    let metrics = Arc::new(Metrics::new(scheduler.counters()));
    let findings = Arc::new(Assembler::new(Arc::clone(&store), Arc::clone(&scheduler)));
    let app = App {
        recordings: Arc::new(recordings(&store, &scheduler, &findings)),
        findings,
        events: Hub::start(Arc::clone(&store), Arc::clone(&scheduler)),
        turns: Turns::default(),
        pooling: Turns::default(),
        exports: exports::places(),
        lengths: Arc::default(),
        viewers: Arc::new(Semaphore::new(watching::MAX_VIEWERS)),
        opened: Arc::new(Semaphore::new(learning::MAX_OPENED)),
        metrics: Arc::clone(&metrics),
        openapi: openapi::text(&described).into(),
        store,
        scheduler,
    };
    router
        .fallback(async |uri: Uri| {
            Refusal::not_found(ProblemCode::RouteNotFound, "page", uri.path())
        })
        .method_not_allowed_fallback(async |method: Method| {
            let detail = format!("{method} is not possible here");
            Refusal::new(ProblemCode::MethodNotAllowed, detail)
        })
        // Bodies come within the limits of the gate.
        .layer(DefaultBodyLimit::disable())
        .layer(middleware::from_fn(conditional::conditional))
        .layer(middleware::from_fn_with_state(
            Answers::default(),
            answers::bounded,
        ))
        .layer(compression::layer())
        .layer(middleware::map_response(compression::weaken_tag))
        .layer(middleware::from_fn_with_state(
            Gate::new(tokens, metrics),
            guard::guard,
        ))
        .with_state(app)
}
