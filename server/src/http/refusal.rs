//! Everything that a route can refuse with, as `application/problem+json`.

use api::{FieldError, Problem, ProblemCode};
use axum::http::header::{CONTENT_TYPE, RETRY_AFTER};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};

use super::request_id;
use crate::findings::FindingsError;
use crate::store::{CreateJobError, SaveArenaError, StoreError};

/// A problem, ready to be sent.
#[derive(Debug)]
pub struct Refusal {
    problem: Box<Problem>,
    retry_after_s: Option<u32>,
}

impl Refusal {
    /// A problem of this kind, with a sentence on what happened here.
    pub fn new(code: ProblemCode, detail: impl Into<String>) -> Self {
        Self {
            problem: Box::new(Problem::new(code).with_detail(detail)),
            retry_after_s: None,
        }
    }

    /// There is no such thing; `code` says what kind of thing.
    pub fn not_found(code: ProblemCode, what: &str, name: &str) -> Self {
        // Names come from the path; what is echoed is kept short.
        let name: String = name.chars().take(80).collect();
        Self::new(code, format!("there is no {what} {name:?}"))
    }

    /// The document is JSON, but these fields are wrong.
    pub fn fields(errors: Vec<FieldError>) -> Self {
        let detail = match errors.as_slice() {
            [error] => error.to_string(),
            errors => format!("{} fields are wrong", errors.len()),
        };
        Self::new(ProblemCode::InvalidDocument, detail).with_errors(errors)
    }

    /// The fault is the server's. The log has the reason; the client does not need it.
    pub fn internal(reason: &dyn std::fmt::Display) -> Self {
        tracing::error!(%reason, "a request failed");
        Self::new(ProblemCode::Internal, "the server failed; its log says why")
    }

    /// What is stored cannot be used: which, and why.
    pub fn damaged(reason: &dyn std::fmt::Display) -> Self {
        tracing::error!(%reason, "stored data is damaged");
        Self::new(ProblemCode::Damaged, reason.to_string())
    }

    /// With the errors of a document that is not JSON.
    #[must_use]
    pub fn with_errors(mut self, errors: Vec<FieldError>) -> Self {
        self.problem.errors = errors;
        self
    }

    /// With a time after which to try again.
    #[must_use]
    pub fn retry_after_s(mut self, seconds: u32) -> Self {
        self.retry_after_s = Some(seconds);
        self
    }
}

impl IntoResponse for Refusal {
    fn into_response(mut self) -> Response {
        self.problem.request_id = request_id::current();
        // A problem holds strings, numbers and lists: JSON can hold all of them.
        let body = serde_json::to_vec(&self.problem).unwrap_or_default();
        let status = StatusCode::from_u16(self.problem.status);
        let status = status.unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, body).into_response();
        let headers = response.headers_mut();
        headers.insert(CONTENT_TYPE, HeaderValue::from_static(Problem::MEDIA_TYPE));
        if let Some(seconds) = self.retry_after_s {
            headers.insert(RETRY_AFTER, HeaderValue::from(seconds));
        }
        response
    }
}

impl From<StoreError> for Refusal {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Unreadable { .. } | StoreError::Damaged { .. } => Self::damaged(&error),
            StoreError::Full(_) => {
                tracing::error!(%error, "a request failed");
                Self::new(ProblemCode::StoreFull, error.to_string()).retry_after_s(30)
            }
            _ => Self::internal(&error),
        }
    }
}

impl From<FindingsError> for Refusal {
    fn from(error: FindingsError) -> Self {
        let code = match error {
            FindingsError::NotKept(_) => ProblemCode::FindingsNotKept,
            FindingsError::StateNotKept => ProblemCode::CheckpointNotKept,
            FindingsError::Comparison(_) | FindingsError::TooManyRuns(_) => {
                ProblemCode::InvalidQuery
            }
            FindingsError::Unfinished { .. } => ProblemCode::ReportNotReady,
            FindingsError::RunGone(_) => ProblemCode::RunNotFound,
            FindingsError::NoReport(_) => ProblemCode::ReportNotFound,
            FindingsError::Broken { .. } | FindingsError::Checkpoint(_) => {
                return Self::damaged(&error);
            }
            FindingsError::Busy(busy) => return busy.into(),
            FindingsError::BeingMade => {
                let refusal = Self::new(ProblemCode::Overloaded, error.to_string());
                return refusal.retry_after_s(5);
            }
            FindingsError::GivenUp => ProblemCode::Overloaded,
            FindingsError::Store(error) => return error.into(),
        };
        Self::new(code, error.to_string())
    }
}

impl From<CreateJobError> for Refusal {
    fn from(error: CreateJobError) -> Self {
        match error {
            CreateJobError::KeyReused => Self::new(
                ProblemCode::KeyReused,
                "this Idempotency-Key was used for a job with another body",
            ),
            CreateJobError::UnderWay => Self::new(
                ProblemCode::KeyUnderWay,
                "a request with this Idempotency-Key is under way; ask again",
            )
            .retry_after_s(1),
            CreateJobError::QueueFull { unfinished, limit } => Self::new(
                ProblemCode::QueueFull,
                format!("{unfinished} runs are unfinished and at most {limit} may be"),
            )
            .retry_after_s(30),
            CreateJobError::TooLarge { .. } => {
                Self::new(ProblemCode::JobTooLarge, error.to_string())
            }
            CreateJobError::Store(error) => error.into(),
        }
    }
}

impl From<SaveArenaError> for Refusal {
    fn from(error: SaveArenaError) -> Self {
        match error {
            SaveArenaError::NameTaken => Self::new(
                ProblemCode::ArenaNameTaken,
                "another arena has this name; delete it first or choose another",
            ),
            SaveArenaError::Full(_) => Self::new(ProblemCode::ArenasFull, error.to_string()),
            SaveArenaError::Store(error) => error.into(),
        }
    }
}
