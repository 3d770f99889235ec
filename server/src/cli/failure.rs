//! Why a command ended otherwise than it should, and what it exits with then.

use api::FieldError;

/// Exit code of anything that went wrong, but for a wrong spec.
pub const EXIT_FAILED: u8 = 1;
/// Exit code of a wrong spec.
pub const EXIT_WRONG_SPEC: u8 = 2;

/// Why a command did not do what it was asked to.
#[derive(Debug)]
pub enum Failure {
    /// The spec is wrong, in these fields.
    WrongSpec(Vec<FieldError>),
    /// Anything else.
    Other(anyhow::Error),
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Failure::Other(error.into())
    }
}
