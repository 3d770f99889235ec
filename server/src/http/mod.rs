//! The HTTP service: routes over store and scheduler. Handlers only translate; whatever may block
//! or compute runs on threads made for that.

mod access;
mod app;
mod arenas;
mod body;
mod catalog;
mod comparison;
mod compression;
mod conditional;
mod connections;
mod control;
mod extract;
mod files;
mod guard;
mod health;
mod job_findings;
mod jobs;
mod listen;
mod page;
mod problems;
mod query;
mod refusal;
mod request;
mod runs;
mod serve;
#[cfg(test)]
mod tests;
mod views;

use std::sync::Arc;

use api::ProblemCode;
use axum::extract::DefaultBodyLimit;
use axum::http::{Method, Uri};
use axum::{Router, middleware};

use crate::findings::Assembler;
use crate::scheduler::Scheduler;
use crate::store::Store;
use access::Tokens;
pub use access::{Right, line as token_line};
use app::App;
use guard::Gate;
use refusal::Refusal;
pub use serve::{ServeOptions, serve};

/// Every route, behind the gate.
fn router(store: Arc<Store>, scheduler: Arc<Scheduler>, tokens: Tokens) -> Router {
    let app = App {
        findings: Arc::new(Assembler::new(Arc::clone(&store), Arc::clone(&scheduler))),
        store,
        scheduler,
    };
    let v1 = Router::new()
        .merge(jobs::routes())
        .merge(control::routes())
        .merge(job_findings::routes())
        .merge(comparison::routes())
        .merge(runs::routes())
        .merge(files::routes())
        .merge(arenas::routes())
        .merge(catalog::routes());
    Router::new()
        .merge(page::routes())
        .merge(health::routes())
        .merge(problems::routes())
        .nest("/v1", v1)
        .route_layer(middleware::from_fn(query::check))
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
        .layer(compression::layer())
        .layer(middleware::map_response(compression::weaken_tag))
        .layer(middleware::from_fn_with_state(
            Gate::new(tokens),
            guard::guard,
        ))
        .with_state(app)
}
