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
        "the job has {groups} groups, more than {most} that can be compared; pool them with by, one \
         of {known}"
    )]
    Groups {
        /// Its groups.
        groups: usize,
        /// As many as may be.
        most: usize,
        /// What it varies.
        known: String,
    },
    /// The job has fewer groups.
    #[error("group: the job has {groups} groups, numbered from 0; there is no {asked}")]
    Group {
        /// What was asked for.
        asked: u64,
        /// How many there are.
        groups: u64,
    },
    /// The runs of a group are in arenas of different squares.
    #[error(
        "the group's runs count visits in different squares: they cannot be laid over each other"
    )]
    Squares,
}
