//! Errors as RFC 9457 `application/problem+json`, with every wrong field.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ProblemCode;

/// A field that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FieldError {
    /// JSON pointer (RFC 6901) into the document that was sent.
    pub pointer: String,
    /// Why it was refused.
    pub message: String,
    /// What is allowed.
    pub allowed: String,
}

impl FieldError {
    /// A field error.
    pub fn new(
        pointer: impl Into<String>,
        message: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self {
            pointer: pointer.into(),
            message: message.into(),
            allowed: allowed.into(),
        }
    }
}

impl std::fmt::Display for FieldError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let pointer = if self.pointer.is_empty() {
            "(document)"
        } else {
            &self.pointer
        };
        write!(f, "{pointer}: {}", self.message)?;
        if !self.allowed.is_empty() {
            write!(f, " (allowed: {})", self.allowed)?;
        }
        Ok(())
    }
}

/// A problem document.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Problem {
    /// URI reference of the kind of problem.
    #[serde(rename = "type")]
    pub kind: String,
    /// The same for programs: one of those under `/problems`.
    pub code: String,
    /// What kind of problem, in a few words.
    pub title: String,
    /// HTTP status.
    pub status: u16,
    /// What happened here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
    /// Every wrong field.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<FieldError>,
    /// Id of the request, as in `x-request-id` and in the server's log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub request_id: Option<String>,
}

impl Problem {
    /// Media type of a problem document.
    pub const MEDIA_TYPE: &'static str = "application/problem+json";

    /// A problem of this code.
    pub fn new(code: ProblemCode) -> Self {
        Self {
            kind: code.uri().to_owned(),
            code: code.code().to_owned(),
            title: code.title().to_owned(),
            status: code.status(),
            detail: None,
            errors: Vec::new(),
            request_id: None,
        }
    }

    /// With a sentence on what happened here.
    #[must_use]
    pub fn with_detail(mut self, detail: impl Into<String>) -> Self {
        self.detail = Some(detail.into());
        self
    }

    /// With every wrong field.
    #[must_use]
    pub fn with_errors(mut self, errors: Vec<FieldError>) -> Self {
        self.errors = errors;
        self
    }
}

/// What a kind of problem means: `GET /problems/{code}`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ProblemMeaning {
    /// URI reference of the kind of problem.
    #[serde(rename = "type")]
    pub kind: String,
    /// The same for programs.
    pub code: String,
    /// HTTP status.
    pub status: u16,
    /// What kind of problem, in a few words.
    pub title: String,
    /// What it means and what to do.
    pub meaning: String,
}

impl From<ProblemCode> for ProblemMeaning {
    fn from(code: ProblemCode) -> Self {
        Self {
            kind: code.uri().to_owned(),
            code: code.code().to_owned(),
            status: code.status(),
            title: code.title().to_owned(),
            meaning: code.meaning().to_owned(),
        }
    }
}

/// `GET /problems`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ProblemList {
    /// All of them, by status.
    pub items: Vec<ProblemMeaning>,
}
