//! What is wrong with an arena: one error a field, with a JSON pointer to it.

use serde_path_to_error::{Path, Segment};

/// One wrong field of an arena.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{pointer}: {message} (allowed: {allowed})")]
pub struct ArenaError {
    /// JSON pointer (RFC 6901) from the arena object, such as `/walls_m/3`; empty for the whole.
    pub pointer: String,
    /// What is wrong, with the value found.
    pub message: String,
    /// What would be right.
    pub allowed: String,
}

impl ArenaError {
    pub(crate) fn new(
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

/// RFC 6901 pointer of a path that serde walked.
pub(crate) fn json_pointer(path: &Path) -> String {
    let mut pointer = String::new();
    for segment in path.iter() {
        match segment {
            Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
            Segment::Map { key: name } | Segment::Enum { variant: name } => {
                pointer.push('/');
                pointer.push_str(&name.replace('~', "~0").replace('/', "~1"));
            }
            Segment::Unknown => {}
        }
    }
    pointer
}
