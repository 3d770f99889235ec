//! Rows of the table of refusals: an answer is compared with the row that it shows.

use api::Problem;
use api::refusals::{RefusedCase, refused};

use crate::http::Answer;

/// The row of these words, which must be there.
pub fn row(what: &str) -> &'static RefusedCase {
    refused(what).unwrap_or_else(|| panic!("the table of refusals has no row {what:?}"))
}

impl Answer {
    /// The body of an answer that must be what this row of the table says.
    pub fn refused(&self, what: &str) -> Problem {
        let code = row(what).problem.unwrap();
        let problem = self.problem(code.status());
        assert_eq!(
            (problem.code.as_str(), problem.kind.as_str()),
            (code.code(), code.uri()),
            "{what}: {problem:?}"
        );
        assert_eq!(problem.title, code.title());
        problem
    }
}
