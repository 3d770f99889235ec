//! The OpenAPI 3.1 document, made of what the routes say of themselves and of the types that they
//! answer with: `/openapi.json`, and `api/openapi.json` in the sources.

use std::collections::BTreeMap;

use api::{Problem, ProblemCode};
use axum::http::Method;
use schemars::SchemaGenerator;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

use super::operation::{Answer, EVENTS, Operation, Shape};
use super::routes::Described;
use crate::documents::schemas::{self, plain};

const SCHEMAS: &str = "#/components/schemas/";

/// What operations are grouped by, in order: the group, what it is about, how its paths begin.
const GROUPS: [(&str, &str, &[&str]); 7] = [
    (
        "jobs",
        "Experiments: many runs",
        &["/v1/jobs", "/v1/events"],
    ),
    ("runs", "Single runs, and what they find", &["/v1/runs"]),
    ("arenas", "Where robots move", &["/v1/arenas"]),
    ("catalog", "What jobs can be made of", &["/v1/"]),
    (
        "operations",
        "Whether the server lives, and how it does",
        &["/health", "/readyz", "/metrics"],
    ),
    ("problems", "What problems mean", &["/problems"]),
    ("documents", "This contract, and the page", &["/"]),
];

/// The document as text.
pub fn text(described: &[Described]) -> String {
    // Strings, numbers and lists: JSON can hold all of them.
    let mut text = serde_json::to_string_pretty(&document(described)).unwrap_or_default();
    text.push('\n');
    text
}

/// The document.
pub fn document(described: &[Described]) -> Value {
    let settings = SchemaSettings::draft2020_12().with(|it| {
        it.definitions_path = "/components/schemas".into();
        it.meta_schema = None;
    });
    let mut parts = Parts {
        schemas: settings.clone().for_serialize().into_generator(),
        taken: settings.for_deserialize().into_generator(),
        responses: BTreeMap::new(),
    };
    let mut paths: BTreeMap<&str, Map<String, Value>> = BTreeMap::new();
    for route in described {
        let method = route.method.as_str().to_lowercase();
        let told = operation(route, &mut parts);
        paths.entry(&route.path).or_default().insert(method, told);
    }
    let problem = Shape::of::<Problem>();
    let problem_schema = parts.schema(problem);
    let mut responses: Map<String, Value> = parts
        .responses
        .iter()
        .map(|(name, codes)| (name.clone(), problem_response(codes, &problem_schema)))
        .collect();
    responses.insert(
        "NotModified".into(),
        json!({
            "description": "The client has this answer: `If-None-Match` names its tag.",
            "headers": { "ETag": header("ETag"), "Cache-Control": header("CacheControl") },
        }),
    );
    responses.insert(
        "AddressTooLong".into(),
        json!({ "description": "The address is longer than 64 KiB. Without a body." }),
    );
    // Types that no answer refers to, but whoever reads streams needs.
    parts.schema(Shape::of::<api::events::Event>());
    // No type is both taken and answered with, so that each has one schema.
    let mut definitions = parts.taken.take_definitions(true);
    definitions.extend(parts.schemas.take_definitions(true));
    for (_, schema) in &mut definitions {
        tidy(schema);
    }
    definitions.extend(schemas::definitions(SCHEMAS));
    let tags: Vec<Value> = GROUPS
        .iter()
        .map(|(name, about, _)| json!({ "name": name, "description": about }))
        .collect();
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "evswarm",
            "version": env!("CARGO_PKG_VERSION"),
            "summary": "Simulations of e-puck robots that learn on board",
            "description": ABOUT,
            "license": {
                "name": "MIT OR Apache-2.0",
                "identifier": "MIT OR Apache-2.0",
            },
        },
        "servers": [{ "url": "/" }],
        "tags": tags,
        "paths": paths,
        "components": {
            "schemas": definitions,
            "responses": responses,
            "headers": headers(),
            "securitySchemes": {
                "token": {
                    "type": "http",
                    "scheme": "bearer",
                    "description": "Only where the server was started with tokens.",
                },
            },
        },
    })
}

const ABOUT: &str = "Names, units and limits are those of the README. Problems are \
    `application/problem+json` with a stable `code`, told under `/problems/{code}`. A method that a \
    path does not have is answered with 405 and `Allow`, an unknown path with 404. Every answer to \
    `GET` but streams has an `ETag` and can be asked for in part. `HEAD` answers as `GET` does, \
    without a body.";

/// What is gathered on the way.
struct Parts {
    /// Of what is answered: fields that are always there are required.
    schemas: SchemaGenerator,
    /// Of bodies that are taken: fields that have a default are not.
    taken: SchemaGenerator,
    /// Answers with problems by name.
    responses: BTreeMap<String, Vec<ProblemCode>>,
}

impl Parts {
    fn schema(&mut self, shape: Shape) -> Value {
        shown(shape, &mut self.schemas)
    }

    /// A reference to the answer with one of these problems, which have the same status.
    fn problem(&mut self, codes: &[ProblemCode]) -> Value {
        let names: Vec<&str> = codes.iter().map(|code| code.code()).collect();
        let name = names.join(".");
        let reference = json!({ "$ref": format!("#/components/responses/{name}") });
        self.responses.insert(name, codes.to_vec());
        reference
    }
}

fn shown(shape: Shape, schemas: &mut SchemaGenerator) -> Value {
    match shape {
        Shape::Type(schema) => {
            let mut schema = schema(schemas).to_value();
            tidy(&mut schema);
            schema
        }
        Shape::Document(name) => json!({ "$ref": format!("{SCHEMAS}{name}") }),
        Shape::Any => json!({}),
    }
}

fn operation(route: &Described, parts: &mut Parts) -> Value {
    let Described {
        method,
        path,
        operation,
    } = route;
    let mut responses = Map::new();
    let is_whole = *method == Method::GET && !operation.is_streamed;
    for told in &operation.answers {
        responses.insert(told.status.to_string(), answer(told, is_whole, parts));
    }
    if is_whole {
        let not_modified = json!({ "$ref": "#/components/responses/NotModified" });
        responses.insert("304".into(), not_modified);
        if let Some(whole) = responses.get("200").cloned() {
            responses.insert("206".into(), part(whole));
        }
    }
    let problems = operation.problems(method, path);
    for codes in problems.chunk_by(|one, next| one.status() == next.status()) {
        let status = codes[0].status().to_string();
        responses.insert(status, parts.problem(codes));
    }
    responses.insert(
        "414".into(),
        json!({ "$ref": "#/components/responses/AddressTooLong" }),
    );
    let group = GROUPS
        .iter()
        .find(|(_, _, begins)| begins.iter().any(|begin| path.starts_with(begin)))
        .map_or("documents", |(name, ..)| name);
    let mut told = json!({
        "operationId": operation.id,
        "tags": [group],
        "summary": operation.about,
        "parameters": parameters(path, operation, is_whole),
        "responses": responses,
        "security": if operation.is_open { json!([]) } else { json!([{}, { "token": [] }]) },
    });
    if !operation.details.is_empty() {
        told["description"] = json!(operation.details);
    }
    if let Some(shape) = operation.body {
        told["requestBody"] = json!({
            "required": true,
            "content": { "application/json": { "schema": shown(shape, &mut parts.taken) } },
        });
    }
    if operation.takes_bytes {
        told["requestBody"] = json!({
            "required": true,
            "content": { "application/octet-stream": {} },
        });
    }
    told
}

fn answer(answer: &Answer, is_whole: bool, parts: &mut Parts) -> Value {
    let mut told = json!({ "description": answer.about });
    let mut headers = Map::new();
    if answer.has_location {
        headers.insert("Location".into(), header("Location"));
    }
    if let Some((media_type, shape)) = answer.body {
        let content = match shape {
            Some(shape) => json!({ "schema": parts.schema(shape) }),
            None if media_type == EVENTS => json!({
                "schema": { "type": "string" },
                "x-events": { "$ref": format!("{SCHEMAS}Event") },
            }),
            None if is_text(media_type) => json!({ "schema": { "type": "string" } }),
            // Bytes: without a schema, as OpenAPI 3.1 wants it.
            None => json!({}),
        };
        told["content"] = json!({ media_type: content });
        if is_whole {
            headers.insert("ETag".into(), header("ETag"));
            headers.insert("Cache-Control".into(), header("CacheControl"));
            headers.insert("Accept-Ranges".into(), header("AcceptRanges"));
        }
    }
    if !headers.is_empty() {
        told["headers"] = Value::Object(headers);
    }
    told
}

/// The answer to a request with `Range`, from the answer to one without.
fn part(mut whole: Value) -> Value {
    whole["description"] = json!("The bytes that `Range` asks for.");
    whole["headers"]["Content-Range"] = header("ContentRange");
    if let Some(content) = whole["content"].as_object_mut() {
        // A part of a document has no shape.
        for (_, content) in content {
            *content = json!({});
        }
    }
    whole
}

fn is_text(media_type: &str) -> bool {
    media_type.starts_with("text/") || media_type == "image/svg+xml"
}

fn parameters(path: &str, operation: &Operation, is_whole: bool) -> Vec<Value> {
    let mut told: Vec<Value> = path
        .split('{')
        .skip(1)
        .filter_map(|rest| Some(path_parameter(path, rest.split_once('}')?.0)))
        .collect();
    for parameter in operation.query {
        told.push(json!({
            "name": parameter.name, "in": "query", "required": false,
            "description": parameter.about, "schema": parameter.schema(),
        }));
    }
    for header in &operation.headers {
        told.push(json!({
            "name": header.name, "in": "header", "required": false,
            "description": header.about, "schema": header.schema,
        }));
    }
    if is_whole {
        for (name, about) in [
            (
                "If-None-Match",
                "Tags of answers that the client has: where one is this answer's, 304 is answered.",
            ),
            (
                "Range",
                "`bytes=first-last`, `bytes=first-` or `bytes=-count`: 206 with these bytes. \
                 Several ranges at once are answered with all.",
            ),
        ] {
            told.push(json!({
                "name": name, "in": "header", "required": false, "description": about,
                "schema": { "type": "string" },
            }));
        }
    }
    told
}

fn path_parameter(path: &str, name: &str) -> Value {
    let (about, schema) = match name {
        "id" if path.starts_with("/v1/jobs") => (
            "Id of a job.",
            json!({ "type": "string", "pattern": "^[0-9]{1,18}$", "example": "1" }),
        ),
        "id" => (
            "Id of a run: SHA-256 of its spec, its arenas and the version of results, in hex.",
            json!({ "type": "string", "pattern": "^[0-9a-f]{64}$" }),
        ),
        "code" => ("Code of a problem.", json!({ "type": "string" })),
        _ => ("A name.", json!({ "type": "string", "minLength": 1 })),
    };
    json!({
        "name": name, "in": "path", "required": true, "description": about, "schema": schema,
    })
}

fn problem_response(codes: &[ProblemCode], problem: &Value) -> Value {
    let told: Vec<String> = codes
        .iter()
        .map(|code| format!("`{}`: {}", code.code(), code.meaning()))
        .collect();
    let names: Vec<&str> = codes.iter().map(|code| code.code()).collect();
    let status = codes.first().map_or(500, |code| code.status());
    let mut response = json!({
        "description": told.join("\n\n"),
        "content": { Problem::MEDIA_TYPE: { "schema": { "allOf": [
            problem,
            { "properties": { "status": { "const": status }, "code": { "enum": names } } },
        ] } } },
    });
    match status {
        401 => response["headers"] = json!({ "WWW-Authenticate": header("WwwAuthenticate") }),
        416 => response["headers"] = json!({ "Content-Range": header("ContentRange") }),
        429 | 503 | 507 => response["headers"] = json!({ "Retry-After": header("RetryAfter") }),
        _ if codes.contains(&ProblemCode::KeyUnderWay) => {
            response["headers"] = json!({ "Retry-After": header("RetryAfter") });
        }
        _ => {}
    }
    response
}

fn header(name: &str) -> Value {
    json!({ "$ref": format!("#/components/headers/{name}") })
}

fn headers() -> Value {
    let told = |about: &str| json!({ "description": about, "schema": { "type": "string" } });
    json!({
        "ETag": told("Tag of the answer, for `If-None-Match`."),
        "CacheControl": told("`no-cache`: may be kept, and is asked for again by its tag."),
        "AcceptRanges": told("`bytes`: parts can be asked for by `Range`."),
        "ContentRange": told("Which bytes these are, and how many there are in all."),
        "Location": told("Where what was made is."),
        "WwwAuthenticate": told("`Bearer`."),
        "RetryAfter": {
            "description": "Seconds after which to try again.",
            "schema": { "type": "integer", "minimum": 0 },
        },
    })
}

/// Puts right what comes from Rust: line ends and links in descriptions, names of number types.
fn tidy(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            if let Some(Value::String(text)) = map.get_mut("description") {
                *text = plain(text);
            }
            let is_rust = |format: &Value| {
                let format = format.as_str().unwrap_or_default();
                format.starts_with("uint") || format.starts_with("int")
            };
            if map.get("format").is_some_and(is_rust) {
                map.remove("format");
            }
            map.values_mut().for_each(tidy);
        }
        Value::Array(list) => list.iter_mut().for_each(tidy),
        _ => {}
    }
}
