//! Everything that a route can refuse with, as `application/problem+json`.

use api::{FieldError, Problem};
use axum::http::header::{CONTENT_TYPE, RETRY_AFTER};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};

use crate::findings::FindingsError;
use crate::store::{CreateJobError, SaveArenaError, StoreError};

/// A problem, ready to be sent.
#[derive(Debug)]
pub struct Refusal {
    status: StatusCode,
    problem: Box<Problem>,
    retry_after_s: Option<u32>,
}

impl Refusal {
    /// A problem of this status, with a sentence on what happened here.
    pub fn new(status: StatusCode, detail: impl Into<String>) -> Self {
        let title = status.canonical_reason().unwrap_or("Error");
        let problem = Problem::new(status.as_u16(), title).with_detail(detail);
        Self {
            status,
            problem: Box::new(problem),
            retry_after_s: None,
        }
    }

    /// There is no such thing.
    pub fn not_found(what: &str, name: &str) -> Self {
        // Names come from the path; what is echoed is kept short.
        let name: String = name.chars().take(80).collect();
        Self::new(
            StatusCode::NOT_FOUND,
            format!("there is no {what} {name:?}"),
        )
    }

    /// The present state does not allow it.
    pub fn conflict(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, detail)
    }

    /// The request itself is malformed.
    pub fn bad_request(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, detail)
    }

    /// The document is JSON, but these fields are wrong.
    pub fn fields(errors: Vec<FieldError>) -> Self {
        let detail = match errors.as_slice() {
            [error] => error.to_string(),
            errors => format!("{} fields are wrong", errors.len()),
        };
        let mut refusal = Self::new(StatusCode::UNPROCESSABLE_ENTITY, detail);
        refusal.problem.errors = errors;
        refusal
    }

    /// The fault is the server's. The log has the reason; the client does not need it.
    pub fn internal(reason: &dyn std::fmt::Display) -> Self {
        tracing::error!(%reason, "a request failed");
        Self::new(
            StatusCode::INTERNAL_SERVER_ERROR,
            "the server failed; its log says why",
        )
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
    fn into_response(self) -> Response {
        // A problem holds strings, numbers and lists: JSON can hold all of them.
        let body = serde_json::to_vec(&self.problem).unwrap_or_default();
        let mut response = (self.status, body).into_response();
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
        Self::internal(&error)
    }
}

impl From<FindingsError> for Refusal {
    fn from(error: FindingsError) -> Self {
        match error {
            FindingsError::NotKept(_) | FindingsError::Unfinished { .. } => {
                Self::conflict(error.to_string())
            }
            FindingsError::RunGone(_) | FindingsError::NoReport(_) => {
                Self::new(StatusCode::NOT_FOUND, error.to_string())
            }
            FindingsError::Broken { .. }
            | FindingsError::Store(_)
            | FindingsError::Checkpoint(_) => Self::internal(&error),
        }
    }
}

impl From<CreateJobError> for Refusal {
    fn from(error: CreateJobError) -> Self {
        match error {
            CreateJobError::KeyReused => Self::new(
                StatusCode::UNPROCESSABLE_ENTITY,
                "this Idempotency-Key was used for a job with another body",
            ),
            CreateJobError::QueueFull { unfinished, limit } => Self::new(
                StatusCode::TOO_MANY_REQUESTS,
                format!("{unfinished} runs are unfinished and at most {limit} may be"),
            )
            .retry_after_s(30),
            CreateJobError::TooLarge { .. } => {
                Self::new(StatusCode::UNPROCESSABLE_ENTITY, error.to_string())
            }
            CreateJobError::Store(error) => error.into(),
        }
    }
}

impl From<SaveArenaError> for Refusal {
    fn from(error: SaveArenaError) -> Self {
        match error {
            SaveArenaError::NameTaken => {
                Self::conflict("another arena has this name; delete it first or choose another")
            }
            SaveArenaError::Full(_) => {
                Self::new(StatusCode::INSUFFICIENT_STORAGE, error.to_string())
            }
            SaveArenaError::Store(error) => error.into(),
        }
    }
}
