//! `/v1/runs/{id}/...`: what a run has found, in every format of the table of a run's files.

use axum::Router;
use axum::extract::State;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE, ETAG, IF_NONE_MATCH};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Serialize;

use super::App;
use super::extract::FoundRun;
use super::refusal::Refusal;
use super::request::number;
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
                move |State(app): State<App>, FoundRun(run), uri: Uri, headers: HeaderMap| {
                    show(app, run, file, uri, headers)
                };
            router.route(&format!("/runs/{{id}}/{route}"), get(show))
        },
    )
}

/// Answers with a file as it is at this moment, or with 304 when the client has that.
async fn show(
    app: App,
    run: RunView,
    file: &'static RunFile,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    let points = match file.route {
        Some("curve") => number(&uri, "points", 2, MAX_POINTS)?,
        _ => None,
    };
    let points = points.and_then(|points| usize::try_from(points).ok());
    app.blocking(move |app| {
        let is_known = |tag: &str| is_known(&headers, tag);
        let answer = app.findings.file(&run, file, points, is_known)?;
        let mut caching = HeaderMap::new();
        caching.insert(CACHE_CONTROL, HeaderValue::from_static("no-cache"));
        let tag = HeaderValue::try_from(format!("\"{}\"", answer.tag));
        caching.insert(ETAG, tag.map_err(|error| Refusal::internal(&error))?);
        Ok(match answer.body {
            Some(body) => (caching, [(CONTENT_TYPE, file.media_type)], body).into_response(),
            None => (StatusCode::NOT_MODIFIED, caching).into_response(),
        })
    })
    .await
}

/// Whether the header `If-None-Match` names this tag, or every one.
fn is_known(headers: &HeaderMap, tag: &str) -> bool {
    let tags = headers.get_all(IF_NONE_MATCH).iter();
    tags.filter_map(|tags| tags.to_str().ok())
        .flat_map(|tags| tags.split(','))
        .map(|known| known.trim().trim_start_matches("W/"))
        .any(|known| known == "*" || known.trim_matches('"') == tag)
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
    fn tags_are_found_in_lists_weak_or_not() {
        let known = |value: &'static str| {
            let headers = [(IF_NONE_MATCH, HeaderValue::from_static(value))];
            is_known(&headers.into_iter().collect(), "a-1")
        };
        for value in ["\"a-1\"", "W/\"a-1\"", "\"b\", \"a-1\"", "*"] {
            assert!(known(value), "{value}");
        }
        for value in ["", "\"a-2\"", "\"a\""] {
            assert!(!known(value), "{value}");
        }
        assert!(!is_known(&HeaderMap::new(), "a-1"));
    }

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
