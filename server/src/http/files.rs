//! `/v1/runs/{id}/...`: what a run has found, in every format of the table of a run's files.

use api::ProblemCode::FindingsNotKept;
use axum::extract::State;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE, ETAG};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use super::App;
use super::conditional::is_known;
use super::extract::RunId;
use super::operation::{Operation, Shape, camel};
use super::query::{Parameter, Query};
use super::refusal::Refusal;
use super::routes::Routes;
use crate::artifacts::{Maker, RUN_FILES, RunFile};

const POINTS: Parameter = Parameter::whole(
    "points",
    (2, 10_000),
    "Most rows, evenly spread, the last always there; all unless it says otherwise.",
);

/// A route for each file that is made of findings.
pub fn routes() -> Routes {
    let files = RUN_FILES
        .iter()
        .filter(|file| matches!(file.maker, Maker::Findings(_)));
    files.filter_map(|file| Some((file.route?, file))).fold(
        Routes::new(),
        |routes, (route, file)| {
            let is_thinned = route == "curve";
            let show = async move |State(app): State<App>, id: RunId, query: Query, headers| {
                let points = if is_thinned {
                    query.number(&POINTS)?
                } else {
                    None
                };
                show(app, id, file, points, headers).await
            };
            let told = Operation::new(format!("getRun{}", camel(route)), file.about())
                .details("Of a run that is under way: what it has found so far.")
                .query(if is_thinned { &[POINTS] } else { &[] })
                .answers(
                    200,
                    "The file.",
                    file.media_type,
                    file.shape.map(Shape::Type),
                )
                .refuses(&[FindingsNotKept]);
            routes.get(&format!("/runs/{{id}}/{route}"), show, told)
        },
    )
}

/// Answers with a file as it is at this moment; one that the client has is not made again.
async fn show(
    app: App,
    id: RunId,
    file: &'static RunFile,
    points: Option<i64>,
    headers: HeaderMap,
) -> Result<Response, Refusal> {
    let points = points.and_then(|points| usize::try_from(points).ok());
    app.with_run(id, move |app, run| {
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
    let is_linked =
        |file: &&RunFile| !is_json_alone(file) && !matches!(file.maker, Maker::Recording);
    let links = RUN_FILES.iter().filter(is_linked);
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
