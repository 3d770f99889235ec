//! The query of a request: only parameters that the route has, each once.

use std::collections::BTreeMap;

use api::{ProblemCode, State};
use axum::extract::{FromRequestParts, MatchedPath, Request};
use axum::http::Method;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::App;
use super::refusal::Refusal;

/// Parameters of the routes that have any, for `GET`.
const PARAMETERS: [(&str, &[&str]); 8] = [
    ("/v1/jobs", &["limit", "cursor", "state", "q", "order"]),
    ("/v1/jobs/{id}/runs", &["limit", "cursor"]),
    (
        "/v1/runs",
        &["limit", "cursor", "job", "state", "method", "arena"],
    ),
    ("/v1/runs/{id}/curve", &["points"]),
    ("/v1/jobs/{id}/comparison", &["measure", "by"]),
    ("/v1/jobs/{id}/comparison.csv", &["measure", "by"]),
    ("/v1/jobs/{id}/comparison.md", &["measure", "by"]),
    (
        "/v1/jobs/{id}/curves",
        &["measure", "x", "by", "points", "runs"],
    ),
];
/// Items of a page unless it says how many.
const DEFAULT_PAGE: u32 = 50;
const MAX_PAGE: u32 = 200;
/// Longest text that is looked for.
const MAX_TEXT_BYTES: usize = 200;

/// What was asked for, by parameter.
#[derive(Debug)]
pub struct Query(BTreeMap<String, String>);

/// Which page of a list is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Page {
    /// Most items.
    pub limit: u32,
    /// Where it starts, as an earlier page said.
    pub cursor: Option<i64>,
}

impl Query {
    /// The query of a request to a route.
    ///
    /// # Errors
    /// A parameter that the route does not have, or one that is given twice.
    fn new(query: &str, known: &[&str]) -> Result<Self, Refusal> {
        let mut values = BTreeMap::new();
        for (name, value) in form_urlencoded::parse(query.as_bytes()) {
            if !known.contains(&&*name) {
                let name: String = name.chars().take(80).collect();
                let known = match known {
                    [] => "has none".to_owned(),
                    known => format!("has {}", known.join(", ")),
                };
                return Err(wrong(format!(
                    "there is no query parameter {name:?} here; the route {known}"
                )));
            }
            if values
                .insert(name.clone().into_owned(), value.into_owned())
                .is_some()
            {
                return Err(wrong(format!("{name} is given twice")));
            }
        }
        Ok(Self(values))
    }

    fn of(parts: &Parts) -> Result<Self, Refusal> {
        let route = parts.extensions.get::<MatchedPath>();
        let route = route.map_or("", MatchedPath::as_str);
        let reads = [Method::GET, Method::HEAD].contains(&parts.method);
        let known = PARAMETERS
            .iter()
            .find(|(of, _)| reads && *of == route)
            .map_or(&[] as &[&str], |(_, known)| known);
        Self::new(parts.uri.query().unwrap_or_default(), known)
    }

    /// The parameters `limit` and `cursor`.
    ///
    /// # Errors
    /// Either cannot be used.
    pub fn page(&self) -> Result<Page, Refusal> {
        let limit = self.number("limit", 1, i64::from(MAX_PAGE))?;
        let cursor = self.0.get("cursor").map(|text| match text.parse() {
            Ok(cursor) if cursor >= 0 => Ok(cursor),
            _ => Err(wrong("cursor is not one that an earlier page gave")),
        });
        Ok(Page {
            limit: limit
                .and_then(|limit| limit.try_into().ok())
                .unwrap_or(DEFAULT_PAGE),
            cursor: cursor.transpose()?,
        })
    }

    /// A whole number.
    ///
    /// # Errors
    /// It is no number from `min` to `max`.
    pub fn number(&self, name: &str, min: i64, max: i64) -> Result<Option<i64>, Refusal> {
        let Some(text) = self.0.get(name) else {
            return Ok(None);
        };
        match text.parse() {
            Ok(number) if (min..=max).contains(&number) => Ok(Some(number)),
            _ => Err(wrong(format!(
                "{name} is a whole number from {min} to {max}"
            ))),
        }
    }

    /// A text.
    ///
    /// # Errors
    /// It is empty or too long.
    pub fn text(&self, name: &str) -> Result<Option<String>, Refusal> {
        match self.0.get(name) {
            Some(text) if (1..=MAX_TEXT_BYTES).contains(&text.len()) => Ok(Some(text.clone())),
            Some(_) => Err(wrong(format!("{name} has 1 to {MAX_TEXT_BYTES} bytes"))),
            None => Ok(None),
        }
    }

    /// One of some words.
    ///
    /// # Errors
    /// It is another.
    pub fn one_of<T: Copy>(&self, name: &str, all: &[(&str, T)]) -> Result<Option<T>, Refusal> {
        let Some(text) = self.0.get(name) else {
            return Ok(None);
        };
        match all.iter().find(|(word, _)| word == text) {
            Some((_, value)) => Ok(Some(*value)),
            None => {
                let words: Vec<&str> = all.iter().map(|(word, _)| *word).collect();
                Err(wrong(format!("{name} is one of {}", words.join(", "))))
            }
        }
    }

    /// The parameter `state`.
    ///
    /// # Errors
    /// It is no state.
    pub fn state(&self) -> Result<Option<State>, Refusal> {
        self.one_of("state", &State::ALL.map(|state| (state.name(), state)))
    }
}

fn wrong(detail: impl Into<String>) -> Refusal {
    Refusal::new(ProblemCode::InvalidQuery, detail)
}

impl FromRequestParts<App> for Query {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, Refusal> {
        Self::of(parts)
    }
}

/// Refuses parameters that the route does not have, also where the handler reads none.
pub async fn check(request: Request, next: Next) -> Response {
    let (parts, body) = request.into_parts();
    match Query::of(&parts) {
        Ok(_) => next.run(Request::from_parts(parts, body)).await,
        Err(refusal) => refusal.into_response(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn pages_are_read_or_refused() {
        let read = |text: &str| Query::new(text, &["limit", "cursor"]).ok()?.page().ok();
        let page = |limit, cursor| Some(Page { limit, cursor });
        assert_eq!(read(""), page(50, None));
        assert_eq!(read("cursor=7&limit=3"), page(3, Some(7)));
        assert_eq!(read("curso%72=7"), page(50, Some(7)));
        for wrong in [
            "limit=0",
            "limit=201",
            "limit=x",
            "limit=",
            "limit",
            "cursor=-1",
            "cursor=1e3",
            "limit=1&limit=2",
            "lmit=3",
        ] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn texts_are_decoded_and_words_are_known() {
        let query = Query::new("q=a+%26%C3%A9&state=done", &["q", "state"]).unwrap();
        assert_eq!(query.text("q").unwrap().unwrap(), "a &é");
        assert_eq!(query.state().unwrap(), Some(State::Done));
        assert!(
            Query::new("state=dead", &["state"])
                .unwrap()
                .state()
                .is_err()
        );
        assert!(Query::new("q=", &["q"]).unwrap().text("q").is_err());
    }
}
