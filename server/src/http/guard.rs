//! Who may ask, and how much at a time: the outermost layer of every route.
//!
//! Without a token only programs of this machine get through, and no page of another site that a
//! browser of this machine shows: neither by its own requests nor by a name rebound to loopback.

use std::net::IpAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use api::ProblemCode;
use axum::extract::{MatchedPath, Request, State};
use axum::http::header::{
    AUTHORIZATION, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, ORIGIN, WWW_AUTHENTICATE,
};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use tokio::sync::Semaphore;
use tracing::Instrument;

use super::access::{Failures, Right, Tokens};
use super::body::Bodies;
use super::connections::Connection;
use super::metrics::Metrics;
use super::refusal::Refusal;
use super::request_id;
use super::{contract, health, page, problems};

/// Requests answered at a time.
const MAX_CONCURRENT: usize = 128;
/// Longest time for an answer.
const TIMEOUT: Duration = Duration::from_secs(60);
/// What a browser that opens an answer by itself may do with it: show it, as it is.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// When to try again after too many wrong tokens.
const AFTER_FAILURES_S: u32 = 60;

/// The rules of one listening server.
#[derive(Clone)]
pub struct Gate {
    tokens: Arc<Tokens>,
    failures: Arc<Failures>,
    places: Arc<Semaphore>,
    bodies: Bodies,
    metrics: Arc<Metrics>,
}

impl Gate {
    /// The gate of a server, with its tokens if it has any.
    pub fn new(tokens: Tokens, metrics: Arc<Metrics>) -> Self {
        Self {
            tokens: Arc::new(tokens),
            failures: Arc::default(),
            places: Arc::new(Semaphore::new(MAX_CONCURRENT)),
            bodies: Bodies::default(),
            metrics,
        }
    }

    fn check(&self, request: &Request) -> Result<(), Refusal> {
        let headers = request.headers();
        let host = headers
            .get(HOST)
            .and_then(|value| value.to_str().ok())
            .or_else(|| request.uri().authority().map(Authority::as_str));
        let Some(host) = host else {
            return Err(Refusal::new(
                ProblemCode::InvalidHeader,
                "the header Host is missing",
            ));
        };
        if self.tokens.is_empty() && !is_loopback(host) {
            let detail = "this server answers to localhost and loopback addresses only";
            return Err(Refusal::new(ProblemCode::ForeignHost, detail));
        }
        let is_read = [Method::GET, Method::HEAD].contains(request.method());
        if !is_read && !is_same_origin(headers, host) {
            let detail = "requests that change something may not come from pages of other sites";
            return Err(Refusal::new(ProblemCode::ForeignOrigin, detail));
        }
        if self.tokens.is_empty() || is_open(request.uri().path()) {
            return Ok(());
        }
        // Documents that are looked at before they are posted change nothing.
        let changes = !is_read && !request.uri().path().starts_with("/v1/checks/");
        match bearer(headers).and_then(|secret| self.tokens.right(secret)) {
            Some(Right::Write) => Ok(()),
            Some(Right::Read) if !changes => Ok(()),
            Some(Right::Read) => {
                let detail = "this token allows to read, not to change anything";
                Err(Refusal::new(ProblemCode::ReadOnlyToken, detail))
            }
            None => Err(self.without_token(request)),
        }
    }

    fn without_token(&self, request: &Request) -> Refusal {
        let connection = request.extensions().get::<Arc<Connection>>();
        // Who sends none has not tried one.
        let is_wrong = request.headers().contains_key(AUTHORIZATION);
        let counts = |from: &&Arc<Connection>| is_wrong && self.failures.count(from.address());
        if connection.filter(counts).is_some() {
            let detail = "too many wrong tokens came from this address";
            return Refusal::new(ProblemCode::TooManyAttempts, detail)
                .retry_after_s(AFTER_FAILURES_S);
        }
        let detail = "send the header Authorization: Bearer, with a token of this server";
        Refusal::new(ProblemCode::TokenNeeded, detail)
    }
}

/// Lets a request through, or refuses it.
pub async fn guard(State(gate): State<Gate>, request: Request, next: Next) -> Response {
    let start = Instant::now();
    let id = request_id::of(request.headers());
    let method = request.method().clone();
    let path = request.uri().path().to_owned();
    let route = request.extensions().get::<MatchedPath>().cloned();
    let span = tracing::info_span!("request", id);
    let answered = async {
        admitted(&gate, request, next)
            .await
            .unwrap_or_else(IntoResponse::into_response)
    };
    let answered = request_id::scope(id.clone(), answered);
    let mut response = answered.instrument(span.clone()).await;
    let status = response.status();
    let seconds = start.elapsed().as_secs_f64();
    // Paths that no route has are counted together: there is no end of them.
    let route = route.as_ref().map_or("none", MatchedPath::as_str);
    gate.metrics.answered(&method, route, status, seconds);
    span.in_scope(|| {
        tracing::debug!(%method, path, status = status.as_u16(), seconds, "answered");
    });
    let headers = response.headers_mut();
    headers.insert(request_id::HEADER, request_id::header(&id));
    if status == StatusCode::UNAUTHORIZED {
        headers.insert(WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
    }
    headers
        .entry(CONTENT_SECURITY_POLICY)
        .or_insert(HeaderValue::from_static(POLICY));
    headers.insert(
        HeaderName::from_static("x-content-type-options"),
        HeaderValue::from_static("nosniff"),
    );
    response
}

/// The answer to a request that may ask: whether the server lives is told at once, everything else
/// takes a place when its body is there.
async fn admitted(gate: &Gate, request: Request, next: Next) -> Result<Response, Refusal> {
    gate.check(&request)?;
    if health::is_health(request.uri().path()) {
        return Ok(next.run(request).await);
    }
    let (request, _room) = gate.bodies.read(request).await?;
    let Ok(_place) = gate.places.try_acquire() else {
        let detail = "too many requests at a time";
        return Err(later(ProblemCode::Overloaded, detail));
    };
    if is_submission(&request) {
        // A job is stored however long that takes, so its id is told.
        return Ok(as_problem(next.run(request).await));
    }
    let answer = tokio::time::timeout(TIMEOUT, next.run(request)).await;
    answer.map(as_problem).map_err(|_| {
        let detail = "the answer took too long";
        later(ProblemCode::AnswerTooSlow, detail)
    })
}

/// Whether a route tells nothing of jobs, so that no token is needed.
fn is_open(path: &str) -> bool {
    page::is_asset(path)
        || health::is_health(path)
        || problems::is_problem(path)
        || contract::is_contract(path)
}

fn is_submission(request: &Request) -> bool {
    request.method() == Method::POST && request.uri().path() == "/v1/jobs"
}

fn later(code: ProblemCode, detail: &str) -> Refusal {
    Refusal::new(code, detail).retry_after_s(1)
}

/// What axum itself refuses, such as a path that is not UTF-8, in the form of all other refusals.
fn as_problem(response: Response) -> Response {
    let status = response.status();
    let is_problem = response.headers().get(CONTENT_TYPE).is_some_and(|value| {
        value
            .as_bytes()
            .starts_with(api::Problem::MEDIA_TYPE.as_bytes())
    });
    if is_problem || !(status.is_client_error() || status.is_server_error()) {
        return response;
    }
    let code = match status {
        StatusCode::PAYLOAD_TOO_LARGE => ProblemCode::BodyTooLarge,
        status if status.is_server_error() => ProblemCode::Internal,
        _ => ProblemCode::InvalidRequest,
    };
    Refusal::new(code, "the request cannot be understood").into_response()
}

/// Whether a host, with or without a port, names this machine alone.
fn is_loopback(host: &str) -> bool {
    let Ok(authority) = host.parse::<Authority>() else {
        return false;
    };
    let name = authority.host();
    let address = name
        .strip_prefix('[')
        .and_then(|name| name.strip_suffix(']'))
        .unwrap_or(name);
    name.eq_ignore_ascii_case("localhost")
        || address
            .parse::<IpAddr>()
            .is_ok_and(|address| address.is_loopback())
}

/// Whether the request comes from no page, or from one that this server sent.
fn is_same_origin(headers: &HeaderMap, host: &str) -> bool {
    let Some(origin) = headers.get(ORIGIN) else {
        return true;
    };
    let origin = origin.to_str().unwrap_or_default();
    let site = origin
        .strip_prefix("http://")
        .or_else(|| origin.strip_prefix("https://"));
    site.is_some_and(|site| site.eq_ignore_ascii_case(host))
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    let (scheme, token) = headers.get(AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    scheme
        .eq_ignore_ascii_case("bearer")
        .then_some(token.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loopback_is_known_by_name_and_address() {
        for host in [
            "localhost",
            "LOCALHOST:80",
            "127.0.0.1:8080",
            "127.3.2.1",
            "[::1]:9",
            "[::1]",
        ] {
            assert!(is_loopback(host), "{host}");
        }
        let others = [
            "",
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.evil.example:80",
        ];
        for host in
            others
                .into_iter()
                .chain(["10.0.0.1", "0.0.0.0", "a b", "[::2]", "user@evil.example"])
        {
            assert!(!is_loopback(host), "{host}");
        }
    }
}
