//! `/metrics`: what the server does, for Prometheus, as OpenMetrics text.

use axum::extract::State;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};

use super::App;
use super::operation::Operation;
use super::refusal::Refusal;
use super::routes::Routes;

const OPEN_METRICS: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

pub fn routes() -> Routes {
    Routes::new().get(
        "/metrics",
        metrics,
        Operation::new("getMetrics", "What the server does, for Prometheus")
            .details("docs/operations/README.md lists the names.")
            .answers(200, "OpenMetrics text.", OPEN_METRICS, None),
    )
}

/// `GET /metrics`.
async fn metrics(State(app): State<App>) -> Result<Response, Refusal> {
    app.blocking(|app| {
        let text = app.metrics.text(&app.store, &app.scheduler)?;
        Ok(([(CONTENT_TYPE, OPEN_METRICS)], text).into_response())
    })
    .await
}
