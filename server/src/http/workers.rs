//! `/v1/workers`: the threads that step runs, and what each is at.

use api::{Worker, Workers};
use axum::Json;
use axum::extract::State;

use super::App;
use super::operation::Operation;
use super::refusal::Refusal;
use super::routes::Routes;
use crate::findings::views;

pub fn routes() -> Routes {
    Routes::new().get(
        "/workers",
        workers,
        Operation::new(
            "listWorkers",
            "The threads that step runs, and what each is at",
        )
        .shows::<Workers>("All of them."),
    )
}

/// `GET /v1/workers`.
async fn workers(State(app): State<App>) -> Result<Json<Workers>, Refusal> {
    app.blocking(|app| {
        let busy = app.scheduler.busy();
        let mut items = Vec::with_capacity(busy.len());
        for busy in &busy {
            // A run that was deleted this moment is on its way out.
            let run = app.store.run_by_key(busy.run)?;
            items.push(Worker {
                run: run.as_ref().map(|run| run.id.clone()),
                job_id: run.as_ref().map(|run| run.job.to_string()),
                seconds: busy.seconds,
                progress: busy.view.as_deref().map(views::live_progress),
            });
        }
        Ok(Json(Workers {
            threads: app.scheduler.worker_count() as u64,
            queued: app.scheduler.queued() as u64,
            items,
        }))
    })
    .await
}
