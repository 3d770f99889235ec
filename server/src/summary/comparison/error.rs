//! Why a job cannot be compared.

/// Most groups: each pair of them has a test.
pub const MOST_GROUPS: usize = 32;

/// Why a job cannot be compared as was asked.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum ComparisonError {
    /// The measure is none.
    #[error("measure: {asked:?} is none; it is one of {known}")]
    Measure {
        /// What was asked for.
        asked: String,
        /// All there are.
        known: String,
    },
    /// The job does not vary the field.
    #[error("by: the job does not vary {asked:?}; it varies {known}")]
    By {
        /// What was asked for.
        asked: String,
        /// All it varies.
        known: String,
    },
    /// More groups than can be compared.
    #[error(
        "the job has {groups} groups, more than {MOST_GROUPS} that can be compared; pool them with \
         by, one of {known}"
    )]
    Groups {
        /// Its groups.
        groups: usize,
        /// What it varies.
        known: String,
    },
}
