//! What a method of a route does, in the terms of the OpenAPI document that is made of it: a route
//! cannot be added without one.

use api::ProblemCode::{self, *};
use axum::http::Method;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Value, json};

use super::query::Parameter;

/// Media type of most answers.
pub const JSON: &str = "application/json";
/// Media type of a stream of events.
pub const EVENTS: &str = "text/event-stream";

/// Makes the schema of a type.
pub type SchemaOf = fn(&mut SchemaGenerator) -> Schema;

/// The shape of a JSON document.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Of a type.
    Type(SchemaOf),
    /// Of one of the documents that people write: `RunSpec`, `JobSpec`, `Arena`.
    Document(&'static str),
    /// Of any kind.
    Any,
}

impl Shape {
    /// The shape of a type.
    pub const fn of<T: JsonSchema>() -> Self {
        Self::Type(SchemaGenerator::subschema_for::<T>)
    }
}

/// An answer other than a problem.
#[derive(Clone, Debug)]
pub struct Answer {
    /// HTTP status.
    pub status: u16,
    /// What it says.
    pub about: &'static str,
    /// Its media type and, of JSON, its shape; `None` of an empty one.
    pub body: Option<(&'static str, Option<Shape>)>,
    /// Whether the header `Location` says where what was made is.
    pub has_location: bool,
}

/// A header of a request.
#[derive(Clone, Debug)]
pub struct Header {
    /// Its name.
    pub name: &'static str,
    /// What it does.
    pub about: &'static str,
    /// Schema of its value.
    pub schema: Value,
}

/// What a method of a route does.
#[derive(Clone, Debug)]
pub struct Operation {
    /// Name for programs that are made from the document.
    pub id: String,
    /// What it does, in a few words.
    pub about: String,
    /// More on it.
    pub details: String,
    /// Parameters of the query; all others are refused.
    pub query: &'static [Parameter],
    /// Headers that it reads.
    pub headers: Vec<Header>,
    /// JSON that it takes.
    pub body: Option<Shape>,
    /// Whether it takes bytes that are no JSON.
    pub takes_bytes: bool,
    /// What it answers when it does what was asked for.
    pub answers: Vec<Answer>,
    /// Problems of its own; see [`Operation::problems`] for all.
    pub refuses: Vec<ProblemCode>,
    /// Whether it needs no token, also where the server has some.
    pub is_open: bool,
    /// Whether the answer is sent as it is made, so that it has no tag and no parts.
    pub is_streamed: bool,
    /// Whether it is answered however many other requests there are.
    pub is_ungated: bool,
}

impl Operation {
    /// An operation of this name that does this.
    pub fn new(id: impl Into<String>, about: impl Into<String>) -> Self {
        Self {
            id: id.into(),
            about: about.into(),
            details: String::new(),
            query: &[],
            headers: Vec::new(),
            body: None,
            takes_bytes: false,
            answers: Vec::new(),
            refuses: Vec::new(),
            is_open: false,
            is_streamed: false,
            is_ungated: false,
        }
    }

    /// With more on it.
    #[must_use]
    pub fn details(mut self, details: impl Into<String>) -> Self {
        self.details = details.into();
        self
    }

    /// With parameters of the query.
    #[must_use]
    pub fn query(mut self, query: &'static [Parameter]) -> Self {
        self.query = query;
        self
    }

    /// With a header that it reads.
    #[must_use]
    pub fn header(mut self, name: &'static str, about: &'static str, schema: Value) -> Self {
        self.headers.push(Header {
            name,
            about,
            schema,
        });
        self
    }

    /// Takes a JSON body of this shape.
    #[must_use]
    pub fn takes(mut self, shape: Shape) -> Self {
        self.body = Some(shape);
        self
    }

    /// Takes bytes.
    #[must_use]
    pub fn takes_bytes(mut self) -> Self {
        self.takes_bytes = true;
        self
    }

    /// Answers 200 with the JSON of this type.
    #[must_use]
    pub fn shows<T: JsonSchema>(self, about: &'static str) -> Self {
        self.answers(200, about, JSON, Some(Shape::of::<T>()))
    }

    /// Answers so.
    #[must_use]
    pub fn answers(
        mut self,
        status: u16,
        about: &'static str,
        media_type: &'static str,
        shape: Option<Shape>,
    ) -> Self {
        self.answers.push(Answer {
            status,
            about,
            body: Some((media_type, shape)),
            has_location: false,
        });
        self
    }

    /// Answers with what was made, the header `Location` saying where it is.
    #[must_use]
    pub fn creates<T: JsonSchema>(mut self, status: u16, about: &'static str) -> Self {
        self.answers.push(Answer {
            status,
            about,
            body: Some((JSON, Some(Shape::of::<T>()))),
            has_location: true,
        });
        self
    }

    /// Answers 204 without a body.
    #[must_use]
    pub fn answers_nothing(mut self, about: &'static str) -> Self {
        self.answers.push(Answer {
            status: 204,
            about,
            body: None,
            has_location: false,
        });
        self
    }

    /// May answer with these problems, beside those that follow from method and path.
    #[must_use]
    pub fn refuses(mut self, problems: &[ProblemCode]) -> Self {
        self.refuses.extend(problems);
        self
    }

    /// Needs no token.
    #[must_use]
    pub fn open(mut self) -> Self {
        self.is_open = true;
        self
    }

    /// Is answered however many other requests there are, and needs no token.
    #[must_use]
    pub fn ungated(mut self) -> Self {
        self.is_ungated = true;
        self.open()
    }

    /// Sends its answer as it is made: it has no tag and cannot be asked for in part.
    #[must_use]
    pub fn streamed(mut self) -> Self {
        self.is_streamed = true;
        self
    }

    /// Every problem that may be answered, by status: its own, and those of the gate, of the path's
    /// id and of the body.
    pub fn problems(&self, method: &Method, path: &str) -> Vec<ProblemCode> {
        let mut all = vec![InvalidRequest, InvalidHeader, InvalidQuery, ForeignHost];
        all.extend([BodyTooSlow, BodyTooLarge, Internal]);
        if !self.is_open {
            all.extend([TokenNeeded, TooManyAttempts]);
        }
        if !self.is_ungated {
            all.extend([Overloaded, AnswerTooSlow]);
        }
        if *method == Method::GET {
            if !self.is_streamed {
                all.push(RangeNotSatisfiable);
            }
        } else {
            all.extend([ForeignOrigin, ReadOnlyToken, StoreFull]);
        }
        if self.body.is_some() {
            all.extend([NotSaidToBeJson, InvalidJson, InvalidDocument]);
        }
        if self.takes_bytes {
            all.push(NotSaidToBeBytes);
        }
        if path.starts_with("/v1/jobs/{id}") {
            all.extend([JobNotFound, Damaged]);
        }
        if path.starts_with("/v1/runs/{id}") {
            all.extend([RunNotFound, Damaged]);
        }
        all.extend(&self.refuses);
        ProblemCode::ALL
            .iter()
            .copied()
            .filter(|code| all.contains(code))
            .collect()
    }
}

/// The end of a route as a part of a name: `coverage.png` is `CoveragePng`.
pub fn camel(end: &str) -> String {
    let words = end.split(['.', '/', '-', '_']);
    words
        .filter_map(|word| {
            let first = word.chars().next()?.to_ascii_uppercase();
            Some(format!("{first}{}", &word[first.len_utf8()..]))
        })
        .collect()
}

/// Schema of the header `Idempotency-Key`.
pub fn key_schema(max_bytes: usize) -> Value {
    json!({ "type": "string", "pattern": format!("^[ -~]{{1,{max_bytes}}}$") })
}
