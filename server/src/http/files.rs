//! `/v1/runs/{id}/...`: what a run has found, in every format of the table of a run's files.

use axum::Router;
use axum::extract::State;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE, ETAG};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Serialize;

use super::App;
use super::conditional::is_known;
use super::extract::FoundRun;
use super::query::Query;
use super::refusal::Refusal;
use crate::artifacts::{Maker, RUN_FILES, RunFile};
use crate::store::RunView;

/// Most rows that a thinned curve may have.
const MAX_POINTS: i64 = 10_000;

/// A route for each file that is made of findings.
pub fn routes() -> Router<App> {
    let files = RUN_FILES
        .iter()
        .filter(|file| matches!(file.maker, Maker::Findings(_)));
    files.filter_map(|file| Some((file.route?, file))).fold(
        Router::new(),
        |router, (route, file)| {
            let show =
                move |State(app): State<App>, FoundRun(run), query: Query, headers: HeaderMap| {
                    show(app, run, file, query, headers)
                };
            router.route(&format!("/runs/{{id}}/{route}"), get(show))
        },
    )
}

/// Answers with a file as it is at this moment; one that the client has is not made again.
async fn show(
    app: App,
    run: RunView,
    file: &'static RunFile,
    query: Query,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    let points = query.number("points", 2, MAX_POINTS)?;
    let points = points.and_then(|points| usize::try_from(points).ok());
    app.blocking(move |app| {
        let header = |tag: &str| HeaderValue::try_from(format!("\"{tag}\""));
        let has = |tag: &str| header(tag).is_ok_and(|tag| is_known(&headers, &tag));
        let answer = app.findings.file(&run, file, points, has)?;
        let tag = header(&answer.tag).map_err(|error| Refusal::internal(&error))?;
        let caching = [
            (ETAG, tag),
            (CACHE_CONTROL, HeaderValue::from_static("no-cache")),
        ];
        Ok(match answer.body {
            Some(body) => (caching, [(CONTENT_TYPE, file.media_type)], body).into_response(),
            None => (StatusCode::NOT_MODIFIED, caching).into_response(),
        })
    })
    .await
}

/// A file as the page links to it.
#[derive(Serialize)]
struct Link {
    route: &'static str,
    needs_result: bool,
    needs_objects: bool,
    needs_findings: bool,
}

/// `/files.js`: the files that the page links to, those that are not for programs alone.
pub fn script() -> String {
    let is_json_alone = |file: &RunFile| {
        file.media_type == "application/json" && matches!(file.maker, Maker::Findings(_))
    };
    let links = RUN_FILES.iter().filter(|file| !is_json_alone(file));
    let links: Vec<Link> = links
        .filter_map(|file| {
            Some(Link {
                route: file.route?,
                needs_result: matches!(file.maker, Maker::Result),
                needs_objects: file.needs_objects,
                needs_findings: !matches!(file.maker, Maker::Spec),
            })
        })
        .collect();
    // Strings and truth values: JSON can hold all of them.
    let links = serde_json::to_string(&links).unwrap_or_default();
    format!("// A run's files, from the server's own table.\nexport const FILES = {links};\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_links_to_files_but_not_to_what_it_shows_itself() {
        let script = script();
        for route in ["spec", "result", "curve.csv", "coverage.npy"] {
            assert!(
                script.contains(&format!("\"route\":\"{route}\"")),
                "{script}"
            );
        }
        assert!(!script.contains("\"route\":\"curve\""), "{script}");
    }
}
