//! The query of a request: only parameters that the route has, each once.

use std::collections::BTreeMap;

use api::{ProblemCode, State};
use axum::extract::{FromRequestParts, Request};
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use percent_encoding::percent_decode_str;
use serde_json::{Value, json};

use super::refusal::Refusal;
use super::request::number;

/// Items of a page unless it says how many.
const DEFAULT_PAGE: u32 = 50;
const MAX_PAGE: u32 = 200;
/// Longest text that is looked for.
const MAX_TEXT_BYTES: usize = 200;

/// A parameter that a route has.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// What it does.
    pub about: &'static str,
    /// What it may be.
    pub domain: Domain,
}

/// What a parameter may be.
#[derive(Clone, Copy, Debug)]
pub enum Domain {
    /// A whole number.
    Whole {
        /// Smallest.
        min: i64,
        /// Largest.
        max: i64,
        /// What it is when it is not given, where that is a number.
        default: Option<i64>,
    },
    /// A text of one byte to so many.
    Text(usize),
    /// One of these words; the first unless another is given, where `true`.
    Word(&'static [&'static str], bool),
}

impl Parameter {
    /// A parameter that is a whole number.
    pub const fn whole(name: &'static str, range: (i64, i64), about: &'static str) -> Self {
        let (min, max) = range;
        let default = None;
        let domain = Domain::Whole { min, max, default };
        Self {
            name,
            about,
            domain,
        }
    }

    /// A parameter that is a text.
    pub const fn text(name: &'static str, about: &'static str) -> Self {
        let domain = Domain::Text(MAX_TEXT_BYTES);
        Self {
            name,
            about,
            domain,
        }
    }

    /// The same, of at most so many bytes.
    #[must_use]
    pub const fn up_to(mut self, bytes: usize) -> Self {
        if let Domain::Text(_) = self.domain {
            self.domain = Domain::Text(bytes);
        }
        self
    }

    /// A parameter that is one of some words, the first of them unless it says otherwise.
    pub const fn word(
        name: &'static str,
        words: &'static [&'static str],
        about: &'static str,
    ) -> Self {
        let domain = Domain::Word(words, true);
        Self {
            name,
            about,
            domain,
        }
    }

    /// The same, which is the given number unless it says otherwise.
    #[must_use]
    pub const fn or(mut self, number: i64) -> Self {
        if let Domain::Whole { min, max, .. } = self.domain {
            let default = Some(number);
            self.domain = Domain::Whole { min, max, default };
        }
        self
    }

    /// Its JSON Schema.
    pub fn schema(&self) -> Value {
        match self.domain {
            Domain::Whole { min, max, default } => {
                let mut schema = json!({ "type": "integer", "minimum": min, "maximum": max });
                if let Some(default) = default {
                    schema["default"] = json!(default);
                }
                schema
            }
            Domain::Text(most) => {
                json!({ "type": "string", "minLength": 1, "maxLength": most })
            }
            Domain::Word(words, true) => {
                json!({ "type": "string", "enum": words, "default": words.first() })
            }
            Domain::Word(words, false) => json!({ "type": "string", "enum": words }),
        }
    }
}

/// Most items of a page.
pub const LIMIT: Parameter =
    Parameter::whole("limit", (1, MAX_PAGE as i64), "Most items of the page.")
        .or(DEFAULT_PAGE as i64);
/// Where a page begins.
pub const CURSOR: Parameter = Parameter::whole(
    "cursor",
    (0, i64::MAX),
    "Where the page begins: `next` of the page before.",
);
/// The order of a list.
pub const ORDER: Parameter = Parameter::word("order", &["newest", "oldest"], "Which come first.");
/// Jobs or runs in one state.
pub const STATE: Parameter = Parameter {
    name: "state",
    about: "Only those in this state.",
    domain: Domain::Word(&State::NAMES, false),
};

/// What was asked for, by parameter.
#[derive(Clone, Debug)]
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
    fn new(query: &str, known: &[Parameter]) -> Result<Self, Refusal> {
        let mut values = BTreeMap::new();
        // Read as it is below, other bytes would be taken for another character.
        if percent_decode_str(query).decode_utf8().is_err() {
            return Err(wrong("the query is not UTF-8"));
        }
        for (name, value) in form_urlencoded::parse(query.as_bytes()) {
            if !known.iter().any(|known| known.name == name) {
                let name: String = name.chars().take(80).collect();
                let names: Vec<&str> = known.iter().map(|known| known.name).collect();
                let has = match names.as_slice() {
                    [] => "has none".to_owned(),
                    names => format!("has {}", names.join(", ")),
                };
                return Err(wrong(format!(
                    "there is no query parameter {name:?} here; the route {has}"
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

    /// The parameters `limit` and `cursor`.
    ///
    /// # Errors
    /// Either cannot be used.
    pub fn page(&self) -> Result<Page, Refusal> {
        let limit = self.number(&LIMIT)?;
        Ok(Page {
            limit: limit
                .and_then(|limit| limit.try_into().ok())
                .unwrap_or(DEFAULT_PAGE),
            cursor: self.number(&CURSOR)?,
        })
    }

    /// A whole number.
    ///
    /// # Errors
    /// It is none in the range of the parameter.
    pub fn number(&self, parameter: &Parameter) -> Result<Option<i64>, Refusal> {
        let name = parameter.name;
        let Domain::Whole { min, max, default } = parameter.domain else {
            return Err(Refusal::internal(&format!("{name} is no number")));
        };
        let Some(text) = self.0.get(name) else {
            return Ok(default);
        };
        match number(text) {
            Some(number) if (min..=max).contains(&number) => Ok(Some(number)),
            _ => Err(wrong(format!(
                "{name} is a whole number from {min} to {max}"
            ))),
        }
    }

    /// A text.
    ///
    /// # Errors
    /// It is empty or too long.
    pub fn text(&self, parameter: &Parameter) -> Result<Option<String>, Refusal> {
        let name = parameter.name;
        let Domain::Text(most) = parameter.domain else {
            return Err(Refusal::internal(&format!("{name} is no text")));
        };
        match self.0.get(name) {
            Some(text) if (1..=most).contains(&text.len()) => Ok(Some(text.clone())),
            Some(_) => Err(wrong(format!("{name} has 1 to {most} bytes"))),
            None => Ok(None),
        }
    }

    /// One of the parameter's words.
    ///
    /// # Errors
    /// It is another.
    pub fn word(&self, parameter: &Parameter) -> Result<Option<&'static str>, Refusal> {
        let name = parameter.name;
        let Domain::Word(words, has_default) = parameter.domain else {
            return Err(Refusal::internal(&format!("{name} is no word")));
        };
        match self.0.get(name) {
            None => Ok(words.first().copied().filter(|_| has_default)),
            Some(text) => match words.iter().find(|word| *word == text) {
                Some(word) => Ok(Some(word)),
                None => Err(wrong(format!("{name} is one of {}", words.join(", ")))),
            },
        }
    }

    /// The parameter `state`.
    ///
    /// # Errors
    /// It is no state.
    pub fn state(&self) -> Result<Option<State>, Refusal> {
        Ok(self.word(&STATE)?.and_then(State::from_name))
    }
}

fn wrong(detail: impl Into<String>) -> Refusal {
    Refusal::new(ProblemCode::InvalidQuery, detail)
}

impl<S: Sync> FromRequestParts<S> for Query {
    type Rejection = Refusal;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Refusal> {
        let query = parts.extensions.get::<Self>().cloned();
        query.ok_or_else(|| Refusal::internal(&"the route's query was not read"))
    }
}

/// Reads the query of a request to a route with these parameters; refuses all others, also where
/// the handler reads none.
pub async fn check(known: &'static [Parameter], mut request: Request, next: Next) -> Response {
    match Query::new(request.uri().query().unwrap_or_default(), known) {
        Ok(query) => {
            request.extensions_mut().insert(query);
            next.run(request).await
        }
        Err(refusal) => refusal.into_response(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn pages_are_read_or_refused() {
        let read = |text: &str| Query::new(text, &[LIMIT, CURSOR]).ok()?.page().ok();
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
            "limit=%2B3",
            "limit=03",
        ] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn texts_are_decoded_and_words_are_known() {
        const Q: Parameter = Parameter::text("q", "Words.");
        const KNOWN: [Parameter; 3] = [Q, STATE, ORDER];
        let query = Query::new("q=a+%26%C3%A9&state=done", &KNOWN).unwrap();
        assert_eq!(query.text(&Q).unwrap().unwrap(), "a &é");
        assert_eq!(query.word(&ORDER).unwrap(), Some("newest"));
        assert_eq!(query.state().unwrap(), Some(State::Done));
        let read = |text: &str| Query::new(text, &KNOWN).unwrap();
        assert!(read("state=dead").state().is_err());
        assert!(read("q=").text(&Q).is_err());
        assert!(read("order=").word(&ORDER).is_err());
        for not_utf8 in ["q=%ff", "q=a&%C3=b", "q=%C3&q=%A9"] {
            assert!(Query::new(not_utf8, &KNOWN).is_err(), "{not_utf8}");
        }
        assert_eq!(read("q=%").text(&Q).unwrap().unwrap(), "%");
        assert_eq!(read("").state().unwrap(), None);
    }
}
