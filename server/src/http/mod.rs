//! The HTTP service: routes over store and scheduler. Handlers only translate; whatever may block
//! or compute runs on threads made for that.

mod arenas;
mod coverage;
mod guard;
mod jobs;
mod page;
mod pictures;
mod refusal;
mod report;
mod request;
mod runs;
mod serve;
mod summary;
#[cfg(test)]
mod tests;
mod views;

use std::sync::Arc;

use axum::extract::{DefaultBodyLimit, State};
use axum::http::{Method, StatusCode, Uri};
use axum::routing::{get, post};
use axum::{Json, Router, middleware};
use serde_json::{Value, json};

use crate::scheduler::Scheduler;
use crate::store::Store;
use guard::Gate;
use pictures::Pictures;
use refusal::Refusal;
pub use serve::{ServeOptions, serve};

/// What handlers share.
#[derive(Clone)]
struct App {
    store: Arc<Store>,
    scheduler: Arc<Scheduler>,
    pictures: Arc<Pictures>,
}

impl App {
    /// Does what blocks on a thread made for that.
    async fn blocking<T: Send + 'static>(
        &self,
        task: impl FnOnce(&App) -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        let app = self.clone();
        tokio::task::spawn_blocking(move || task(&app))
            .await
            .unwrap_or_else(|error| Err(Refusal::internal(&error)))
    }
}

/// Every route, behind the gate.
fn router(store: Arc<Store>, scheduler: Arc<Scheduler>, token: Option<&str>) -> Router {
    let app = App {
        store,
        scheduler,
        pictures: Arc::default(),
    };
    let v1 = Router::new()
        .route("/jobs", get(jobs::list).post(jobs::create))
        .route("/jobs/{id}", get(jobs::show).delete(jobs::delete))
        .route("/jobs/{id}/runs", get(jobs::runs))
        .route("/jobs/{id}/summary", get(summary::as_json))
        .route("/jobs/{id}/summary.csv", get(summary::as_csv))
        .route("/jobs/{id}/summary.md", get(summary::as_markdown))
        .route("/jobs/{id}/report", get(report::claims))
        .route("/jobs/{id}/report.html", get(report::html))
        .route("/jobs/{id}/report.md", get(report::markdown))
        .route("/jobs/{id}/report.csv", get(report::csv))
        .route("/jobs/{id}/cancel", post(jobs::cancel))
        .route("/jobs/{id}/retry", post(jobs::retry))
        .route("/jobs/{id}/pause", post(jobs::pause))
        .route("/jobs/{id}/resume", post(jobs::resume))
        .route("/runs/{id}", get(runs::show))
        .route("/runs/{id}/spec", get(runs::spec))
        .route("/runs/{id}/result", get(runs::result))
        .route("/runs/{id}/memory", get(runs::memory))
        .route("/runs/{id}/channels", get(runs::channels))
        .route("/runs/{id}/cancel", post(runs::cancel))
        .route("/runs/{id}/curve", get(coverage::curve))
        .route("/runs/{id}/curve.csv", get(coverage::curve_as_csv))
        .route("/runs/{id}/metrics", get(coverage::metrics))
        .route("/runs/{id}/metrics.csv", get(coverage::metrics_as_csv))
        .route("/runs/{id}/objects", get(coverage::objects))
        .route("/runs/{id}/objects.csv", get(coverage::objects_as_csv))
        .route("/runs/{id}/robots.csv", get(coverage::robots_as_csv))
        .route("/runs/{id}/coverage", get(coverage::visits_as_json))
        .route("/runs/{id}/coverage.png", get(coverage::visits_as_png))
        .route("/runs/{id}/coverage.svg", get(coverage::visits_as_svg))
        .route("/runs/{id}/coverage.csv", get(coverage::visits_as_csv))
        .route("/runs/{id}/coverage.npy", get(coverage::visits_as_npy))
        .route("/runs/{id}/dwell.npy", get(coverage::dwell_as_npy))
        .route("/arenas", get(arenas::list).post(arenas::create))
        .route("/arenas/{name}", get(arenas::show).delete(arenas::delete))
        .route(
            "/controllers",
            get(async || Json(crate::documents::controllers())),
        )
        .route(
            "/templates",
            get(async || Json(json!({ "items": crate::documents::templates() }))),
        );
    Router::new()
        .route("/", get(page::html))
        .route("/page.css", get(page::css))
        .route("/page.js", get(page::js))
        .route("/chart.js", get(page::chart))
        .route(
            "/health/livez",
            get(async || Json(json!({ "status": "ok" }))),
        )
        .route("/health/readyz", get(readyz))
        .nest("/v1", v1)
        .fallback(async |uri: Uri| Refusal::not_found("page", uri.path()))
        .method_not_allowed_fallback(async |method: Method| {
            let detail = format!("{method} is not possible here");
            Refusal::new(StatusCode::METHOD_NOT_ALLOWED, detail)
        })
        .layer(DefaultBodyLimit::max(request::MAX_BODY_BYTES))
        .layer(middleware::from_fn_with_state(
            Gate::new(token),
            guard::guard,
        ))
        .with_state(app)
}

/// `GET /health/readyz`: whether the database answers.
async fn readyz(State(app): State<App>) -> Result<Json<Value>, Refusal> {
    app.blocking(|app| {
        app.store.ping()?;
        Ok(Json(json!({ "status": "ok" })))
    })
    .await
}
