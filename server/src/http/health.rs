//! `/health/...`: whether the process lives and whether it can do its work. Answered without a place
//! among the other requests, as whoever asks may end the process when no answer comes.

use std::time::Duration;

use api::Health;
use api::ProblemCode::NotReady;
use axum::Json;
use axum::extract::State;

use super::App;
use super::operation::Operation;
use super::refusal::Refusal;
use super::routes::Routes;
use crate::store::StoreError;

/// Where it is told that the process lives.
const LIVE: [(&str, &str); 2] = [("/health/livez", "getLivez"), ("/healthz", "getHealthz")];
/// Where it is told that it can do its work.
const READY: [(&str, &str); 2] = [
    ("/health/readyz", "getHealthReadyz"),
    ("/readyz", "getReadyz"),
];
/// Longest time that the database may take to answer.
const DATABASE_TIME: Duration = Duration::from_secs(1);

pub fn routes() -> Routes {
    let mut routes = Routes::new();
    for (path, id) in LIVE {
        let told = Operation::new(id, "Whether the process lives");
        routes = routes.get(path, livez, told.shows::<Health>("It does.").ungated());
    }
    for (path, id) in READY {
        let told = Operation::new(id, "Whether the server can do its work")
            .details("Whether its database answers soon, and there is room.");
        let told = told
            .shows::<Health>("It can.")
            .refuses(&[NotReady])
            .ungated();
        routes = routes.get(path, readyz, told);
    }
    routes
}

/// Whether this is a path of this file.
pub fn is_health(path: &str) -> bool {
    LIVE.iter().chain(&READY).any(|(known, _)| *known == path)
}

/// `GET /health/livez`: touches nothing else.
async fn livez() -> Json<Health> {
    ok()
}

/// `GET /health/readyz`: whether the database answers soon, and there is room.
async fn readyz(State(app): State<App>) -> Result<Json<Health>, Refusal> {
    let not_ready = |detail: &str| Refusal::new(NotReady, detail).retry_after_s(1);
    let ping = app.blocking(|app| Ok(app.store.ping()));
    match tokio::time::timeout(DATABASE_TIME, ping).await {
        Ok(Ok(Ok(()))) => Ok(ok()),
        Ok(Ok(Err(error @ StoreError::Full(_)))) => Err(not_ready(&error.to_string())),
        Ok(Ok(Err(error))) => {
            tracing::error!(%error, "the database does not answer");
            Err(not_ready(
                "the database does not answer; the server's log says why",
            ))
        }
        Ok(Err(refusal)) => Err(refusal),
        Err(_) => Err(not_ready("the database takes too long to answer")),
    }
}

fn ok() -> Json<Health> {
    Json(Health {
        status: "ok".to_owned(),
    })
}
