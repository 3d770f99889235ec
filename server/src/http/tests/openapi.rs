//! The OpenAPI document: that it is the one that is checked in, that every route is in it, and that
//! answers are as it says.

use std::collections::BTreeSet;
use std::path::Path;

use super::*;
use crate::http::openapi;
use crate::http::router::routes;
use crate::http::routes::Described;

fn described() -> Vec<Described> {
    routes().into_parts().0
}

#[test]
fn the_document_is_the_one_that_is_checked_in() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../api/openapi.json");
    let right = openapi::text(&described());
    if std::env::var_os("EVSWARM_REWRITE").is_some() {
        std::fs::write(&path, right).unwrap();
        return;
    }
    let told = std::fs::read_to_string(&path).unwrap();
    assert!(
        told == right,
        "api/openapi.json differs from what the routes say of themselves; rewrite it with \
         EVSWARM_REWRITE=1 cargo test --release -p server openapi"
    );
}

/// Files of this folder by name, without their tests.
fn sources() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/http");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    let read = |path: &std::path::PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let text = text.split("#[cfg(test)]").next().unwrap().to_owned();
        (path.file_name().unwrap().to_str().unwrap().to_owned(), text)
    };
    files.iter().map(read).collect()
}

#[test]
fn what_is_taken_and_what_is_answered_have_schemas_of_their_own() {
    let document = openapi::document(&described());
    let schemas = &document["components"]["schemas"];
    // A field with a default may be left out by clients, but never is by the server.
    assert_eq!(schemas["Fork"].get("required"), None);
    let required = schemas["RunSummary"]["required"].as_array().unwrap();
    assert!(required.contains(&json!("label")) && required.contains(&json!("result")));
    assert_eq!(schemas["Problem"]["required"].as_array().unwrap().len(), 4);
    let types = |posts: bool| {
        let mut names = BTreeSet::new();
        for methods in document["paths"].as_object().unwrap().values() {
            for operation in methods.as_object().unwrap().values() {
                let part = if posts { "requestBody" } else { "responses" };
                for reference in operation[part].to_string().split("schemas/").skip(1) {
                    names.insert(reference.split('"').next().unwrap().to_owned());
                }
            }
        }
        names
    };
    let both: Vec<String> = types(true).intersection(&types(false)).cloned().collect();
    // Documents that people write are shown as they are taken.
    assert_eq!(both, ["Arena", "JobSpec"]);
}

#[test]
fn no_route_comes_without_a_description() {
    // Only `Routes` hands anything to axum's router, and it takes a description with each route.
    for (name, text) in sources() {
        if name == "routes.rs" {
            continue;
        }
        for way in [
            ".route(",
            ".route_service(",
            ".nest(",
            ".nest_service(",
            "fallback_service(",
            "Router::new(",
            "axum::routing",
        ] {
            assert!(
                !text.contains(way),
                "{name} adds routes by {way:?}: use Routes, so that they are described"
            );
        }
    }
    let mut seen = BTreeSet::new();
    let mut ids = BTreeSet::new();
    for Described {
        method,
        path,
        operation,
    } in described()
    {
        assert!(seen.insert(format!("{method} {path}")), "{method} {path}");
        assert!(ids.insert(operation.id.clone()), "{}", operation.id);
        assert!(!operation.answers.is_empty(), "{method} {path}");
        let is_json_without_shape = |answer: &crate::http::operation::Answer| {
            matches!(answer.body, Some(("application/json", None)))
        };
        assert!(
            !operation.answers.iter().any(is_json_without_shape),
            "{method} {path} answers JSON and does not say of what shape"
        );
    }
    for path in [
        "GET /v1/runs/{id}/coverage.png",
        "GET /v1/runs/{id}/coverage.npy",
        "GET /v1/runs/{id}/curve.csv",
        "GET /v1/arenas/{name}.svg",
        "POST /v1/jobs",
    ] {
        assert!(seen.contains(path), "{path}");
    }
}

/// The schema of an answer, if the document has this one.
fn documented<'a>(document: &'a Value, operation: &'a Value, answer: &Answer) -> Option<&'a Value> {
    let response = &operation["responses"][answer.status.to_string()];
    let response = match response["$ref"].as_str() {
        Some(reference) => document.pointer(&reference[1..])?,
        None => response,
    };
    let content = response.get("content");
    match answer.headers.get(CONTENT_TYPE) {
        Some(media_type) => content?.get(media_type.to_str().unwrap()),
        None => content.is_none().then_some(response),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_described_route_is_there_and_answers_as_described() {
    let service = Service::start(None);
    let job = service.job(&job(1, 1)).await;
    service.wait_until(&job, "done").await;
    let run = service.runs(&job).await[0]["id"].clone();
    let document: Value = service.get("/openapi.json").await.json();
    let mut described = described();
    // What deletes comes last, so that there is something to ask for.
    described.sort_by_key(|route| {
        let is_delete = route.method == "DELETE";
        let wholes = ["/v1/runs/{id}", "/v1/jobs/{id}"];
        let is_last = is_delete.then(|| wholes.iter().position(|path| *path == route.path));
        (is_last, is_delete, route.method != "GET")
    });
    for known in [true, false] {
        for Described { method, path, .. } in &described {
            if path.ends_with("/events") && known {
                continue;
            }
            let id = match (known, path.starts_with("/v1/jobs")) {
                (true, true) => "1",
                (true, false) => run.as_str().unwrap(),
                (false, _) => "77",
            };
            let name = if known { "maze" } else { "nowhere" };
            let code = if known { "damaged" } else { "undamaged" };
            let place = path
                .replace("{id}", id)
                .replace("{name}", name)
                .replace("{code}", code);
            // A stream that would not end, but for a run that is not there.
            let place = place.replace("/v1/events", "/v1/events?run=77");
            let method_name = method.as_str().to_lowercase();
            let operation = &document["paths"][path][&method_name];
            let takes = operation.get("requestBody").is_some();
            let mut asked = request(method.as_str(), &place);
            if takes {
                asked = asked.header(CONTENT_TYPE, "application/json");
            }
            let answer = service.send(asked, if takes { "{" } else { "" }).await;
            assert_ne!(answer.status, 405, "{method} {place}");
            let body = String::from_utf8_lossy(&answer.body).into_owned();
            assert!(
                documented(&document, operation, &answer).is_some(),
                "{method} {place}: {} {:?} is not in the document: {body:.300}",
                answer.status,
                answer.headers.get(CONTENT_TYPE)
            );
            if answer.status == 404 {
                // The job is not of chapter 5, and its run does not record itself.
                let lacks = ["/report", "/recording"]
                    .iter()
                    .any(|part| path.contains(part));
                assert!(!known || lacks, "{method} {place}: {body:.300}");
                let code = answer.json()["code"].clone();
                let is_problem = path.starts_with("/problems/");
                assert_ne!(code == "route-not-found", !is_problem, "{method} {place}");
            }
        }
    }
}
