//! What a run has covered, while it runs and after: the curve, and visits in every format.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::rejection::PathRejection;
use axum::extract::{FromRequestParts, Path};
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE, ETAG, IF_NONE_MATCH};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use swarm::run::CurveRow;

use super::App;
use super::refusal::Refusal;
use super::request::number;
use super::runs::{found, resolved};
use crate::artifacts::{
    coverage_csv, coverage_json, coverage_png, coverage_svg, curve_csv, metrics_csv, metrics_json,
    objects_csv, objects_json, pushed, robots_csv, visits_npy,
};
use crate::documents::ResolvedRun;
use crate::scheduler::View;
use crate::store::{Findings, RunState, RunView};

/// Most rows that a thinned curve may have.
const MAX_POINTS: i64 = 10_000;

const JSON: &str = "application/json";
const CSV: &str = "text/csv; charset=utf-8";
const NPY: &str = "application/octet-stream";

/// What every route here is asked with.
pub struct Asked {
    app: App,
    id: String,
    headers: HeaderMap,
}

impl FromRequestParts<App> for Asked {
    type Rejection = PathRejection;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, PathRejection> {
        let Path(id) = Path::from_request_parts(parts, app).await?;
        Ok(Self {
            app: app.clone(),
            id,
            headers: parts.headers.clone(),
        })
    }
}

/// `GET /v1/runs/{id}/curve`: a row an epoch; with `points`, that many of them at most, evenly
/// spread, the last always there.
pub async fn curve(asked: Asked, uri: Uri) -> Result<Response, Refusal> {
    let points = number(&uri, "points", 2, MAX_POINTS)?;
    let points = points.and_then(|points| usize::try_from(points).ok());
    show(asked, JSON, move |_, _, findings| {
        json(&thinned(&findings.curve, points))
    })
    .await
}

/// `GET /v1/runs/{id}/curve.csv`.
pub async fn curve_as_csv(asked: Asked) -> Result<Response, Refusal> {
    show(asked, CSV, |_, _, findings| {
        Ok(curve_csv(&findings.curve).into())
    })
    .await
}

/// `GET /v1/runs/{id}/metrics`.
pub async fn metrics(asked: Asked) -> Result<Response, Refusal> {
    show(asked, JSON, |app, run, findings| {
        let step_s = resolved(app, run)?.step_s();
        json(&metrics_json(&findings.metrics, step_s))
    })
    .await
}

/// `GET /v1/runs/{id}/metrics.csv`.
pub async fn metrics_as_csv(asked: Asked) -> Result<Response, Refusal> {
    show(asked, CSV, |app, run, findings| {
        let step_s = resolved(app, run)?.step_s();
        Ok(metrics_csv(&findings.metrics, step_s).into())
    })
    .await
}

/// `GET /v1/runs/{id}/objects`: movable objects over time.
pub async fn objects(asked: Asked) -> Result<Response, Refusal> {
    show(asked, JSON, |app, run, findings| {
        let spec = resolved(app, run)?;
        json(&objects_json(spec.arena(), &findings.tracks, spec.step_s()))
    })
    .await
}

/// `GET /v1/runs/{id}/objects.csv`.
pub async fn objects_as_csv(asked: Asked) -> Result<Response, Refusal> {
    show(asked, CSV, |_, _, findings| {
        Ok(objects_csv(&findings.tracks).into())
    })
    .await
}

/// `GET /v1/runs/{id}/robots.csv`: what each robot did.
pub async fn robots_as_csv(asked: Asked) -> Result<Response, Refusal> {
    show(asked, CSV, |_, _, findings| {
        Ok(robots_csv(&findings.metrics).into())
    })
    .await
}

/// `GET /v1/runs/{id}/coverage`.
pub async fn visits_as_json(asked: Asked) -> Result<Response, Refusal> {
    show(asked, JSON, |app, run, findings| {
        let grid = Grid::new(app, run, &findings.visits)?;
        let mask = grid.mask(app).unwrap_or_default();
        json(&coverage_json(grid.spec.arena(), &grid.counts, &mask))
    })
    .await
}

/// `GET /v1/runs/{id}/coverage.csv`.
pub async fn visits_as_csv(asked: Asked) -> Result<Response, Refusal> {
    show(asked, CSV, |app, run, findings| {
        let grid = Grid::new(app, run, &findings.visits)?;
        Ok(coverage_csv(&grid.counts, grid.spec.arena().squares()[0]).into())
    })
    .await
}

/// `GET /v1/runs/{id}/coverage.npy`.
pub async fn visits_as_npy(asked: Asked) -> Result<Response, Refusal> {
    show(asked, NPY, |app, run, findings| {
        Ok(Grid::new(app, run, &findings.visits)?.npy())
    })
    .await
}

/// `GET /v1/runs/{id}/dwell.npy`: steps spent a square.
pub async fn dwell_as_npy(asked: Asked) -> Result<Response, Refusal> {
    show(asked, NPY, |app, run, findings| {
        Ok(Grid::new(app, run, &findings.dwell)?.npy())
    })
    .await
}

/// `GET /v1/runs/{id}/coverage.png`.
pub async fn visits_as_png(asked: Asked) -> Result<Response, Refusal> {
    show(asked, "image/png", |app, run, findings| {
        let grid = Grid::new(app, run, &findings.visits)?;
        let objects = pushed(&grid.spec, &findings.tracks);
        Ok(app.pictures.png(&run.id, &grid.counts, &objects, || {
            let mask = grid.mask(app);
            coverage_png(grid.spec.arena(), &grid.counts, mask.as_deref(), &objects)
        }))
    })
    .await
}

/// `GET /v1/runs/{id}/coverage.svg`.
pub async fn visits_as_svg(asked: Asked) -> Result<Response, Refusal> {
    show(asked, "image/svg+xml", |app, run, findings| {
        let grid = Grid::new(app, run, &findings.visits)?;
        let (mask, objects) = (grid.mask(app), pushed(&grid.spec, &findings.tracks));
        let svg = coverage_svg(grid.spec.arena(), &grid.counts, mask.as_deref(), &objects);
        Ok(svg.into())
    })
    .await
}

/// Counts on the squares of a run's arena.
struct Grid {
    spec: ResolvedRun,
    counts: Vec<u32>,
}

impl Grid {
    /// These counts; zeros for a run that has none yet.
    fn new(app: &App, run: &RunView, counts: &[u32]) -> Result<Self, Refusal> {
        let spec = resolved(app, run)?;
        let squares = arenas::Squares::of(spec.arena()).count();
        let counts = match counts {
            [] => vec![0; squares],
            counts => counts.to_vec(),
        };
        Ok(Self { spec, counts })
    }

    fn npy(&self) -> Bytes {
        visits_npy(&self.counts, self.spec.arena().squares()).into()
    }

    fn mask(&self, app: &App) -> Option<Arc<[bool]>> {
        app.pictures
            .mask(self.spec.arena(), self.spec.body_radius_m())
    }
}

/// Answers with what a run has covered at this moment, or with 304 when the client has that.
async fn show(
    Asked { app, id, headers }: Asked,
    media_type: &'static str,
    render: impl FnOnce(&App, &RunView, &Findings) -> Result<Bytes, Refusal> + Send + 'static,
) -> Result<Response, Refusal> {
    app.blocking(move |app| {
        let run = found(app, &id)?;
        let live = app
            .scheduler
            .view(run.seq)
            .filter(|_| run.state == RunState::Running);
        let mut caching = HeaderMap::new();
        caching.insert(CACHE_CONTROL, HeaderValue::from_static("no-cache"));
        if let Some(tag) = tag(&run, live.as_deref()) {
            let tag = HeaderValue::try_from(tag).map_err(|error| Refusal::internal(&error))?;
            let is_known = headers.get(IF_NONE_MATCH) == Some(&tag);
            caching.insert(ETAG, tag);
            if is_known {
                return Ok((StatusCode::NOT_MODIFIED, caching).into_response());
            }
        }
        let body = match &live {
            Some(live) => render(app, &run, &live.findings)?,
            None => render(app, &run, &stored(app, &run)?)?,
        };
        Ok((caching, [(CONTENT_TYPE, media_type)], body).into_response())
    })
    .await
}

/// A name for what the run has covered at this moment; `None` while that is not certain.
fn tag(run: &RunView, live: Option<&View>) -> Option<String> {
    let robot_steps_done = match (&run.state, live) {
        (RunState::Running, Some(live)) => live.progress.robot_steps_done,
        (RunState::Queued(position) | RunState::Paused(position), _) => position
            .as_ref()
            .map_or(0, |position| position.robot_steps_done),
        (RunState::Done, _) => {
            return Some(format!("\"{}-{}-done\"", env!("CARGO_PKG_VERSION"), run.id));
        }
        (RunState::Running | RunState::Failed { .. } | RunState::Cancelled, _) => return None,
    };
    Some(format!(
        "\"{}-{}-{robot_steps_done}\"",
        env!("CARGO_PKG_VERSION"),
        run.id
    ))
}

/// What a run that no worker holds has covered; nothing when it has not started.
fn stored(app: &App, run: &RunView) -> Result<Findings, Refusal> {
    if matches!(run.state, RunState::Failed { .. } | RunState::Cancelled) {
        let state = run.state.state();
        return Err(Refusal::conflict(format!(
            "the run is {state}; what it covered is not kept"
        )));
    }
    // A run that has ended since it was looked up is found here too.
    if let Some(findings) = app.store.findings(run.seq)? {
        return Ok(findings);
    }
    match app.store.checkpoints().findings(&run.id) {
        Ok(findings) => Ok(findings.unwrap_or_default()),
        Err(error) => {
            tracing::warn!(run = run.id, %error, "the findings of a stopped run cannot be read");
            Ok(Findings::default())
        }
    }
}

/// At most `points` rows, evenly spread, the last always there.
fn thinned(curve: &[CurveRow], points: Option<usize>) -> Vec<api::CurveRow> {
    let shown = |row: &CurveRow| {
        let CurveRow {
            epoch,
            p1,
            p2,
            p5,
            p10,
        } = *row;
        api::CurveRow {
            epoch,
            p1,
            p2,
            p5,
            p10,
        }
    };
    match points {
        Some(points) if points >= 2 && points < curve.len() => (0..points)
            .map(|point| shown(&curve[point * (curve.len() - 1) / (points - 1)]))
            .collect(),
        _ => curve.iter().map(shown).collect(),
    }
}

fn json(document: &impl serde::Serialize) -> Result<Bytes, Refusal> {
    Ok(serde_json::to_vec(document)
        .map_err(|error| Refusal::internal(&error))?
        .into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_curve_keeps_both_ends() {
        let row = |epoch| CurveRow {
            epoch,
            p1: epoch,
            p2: 0,
            p5: 0,
            p10: 0,
        };
        let curve: Vec<_> = (1..=1_000).map(row).collect();
        for points in [2, 3, 7, 999] {
            let thin = thinned(&curve, Some(points));
            assert_eq!(thin.len(), points);
            assert_eq!((thin[0].epoch, thin[points - 1].epoch), (1, 1_000));
            assert!(thin.windows(2).all(|pair| pair[0].epoch < pair[1].epoch));
        }
        assert_eq!(thinned(&curve, Some(1_000)).len(), 1_000);
        assert_eq!(thinned(&curve, None).len(), 1_000);
        assert!(thinned(&[], Some(5)).is_empty());
    }
}
