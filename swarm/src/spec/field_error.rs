//! How a refusal of a spec is told.

use serde::{Deserialize, Serialize};

/// A field that cannot be used, with the JSON pointer that a user knows it by.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{pointer}: {message}; allowed: {allowed}")]
pub struct FieldError {
    /// JSON pointer into the run spec.
    pub pointer: String,
    /// Why it was refused.
    pub message: String,
    /// What is allowed.
    pub allowed: String,
}
