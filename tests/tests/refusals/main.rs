//! The README's table of what is refused and how: every row, over HTTP and by `evswarm run`.
#![allow(clippy::unwrap_used)]

mod commands;
mod jobs;
mod requests;
mod specs;

use std::collections::BTreeSet;

use api::FieldError;
use tests::readme;

/// Whether there is an error at this place with these words, which says what is allowed.
fn has(errors: &[FieldError], pointer: &str, words: &str) -> bool {
    errors.iter().any(|error| {
        error.pointer == pointer && error.message.contains(words) && !error.allowed.is_empty()
    })
}

#[test]
fn every_row_of_the_readme_is_tested() {
    let here: BTreeSet<&str> = specs::wrong_specs()
        .into_iter()
        .map(|wrong| wrong.0)
        .collect();
    let elsewhere = [
        // The tests beside this file.
        ("text that is not JSON", "400", "2"),
        (
            "a matrix with a wrong path, no value or twice the same run",
            "422",
            "",
        ),
        (
            "parts beside a matrix, or two that make the same run",
            "422",
            "",
        ),
        (
            "a seed twice, or seeds beside a seed in the base run",
            "422",
            "",
        ),
        ("a job of more than 100,000 runs", "422", ""),
        ("an idempotency key used for another body", "422", ""),
        ("a body of more than 4 MiB", "413", ""),
        ("a body that is not said to be JSON", "415", ""),
        ("a page size or cursor that makes no sense", "400", ""),
        (
            "a missing or wrong token, where the server has one",
            "401",
            "",
        ),
        (
            "another host's name, or a change asked for by another site's page",
            "403",
            "",
        ),
        (
            "an unknown job, run, arena or route, or the report of another job than chapter 5",
            "404",
            "",
        ),
        ("a method that a route does not have", "405", ""),
        (
            "the result of an unfinished run, or cancelling a finished one",
            "409",
            "",
        ),
        (
            "the report of an unfinished job, or trying one again",
            "409",
            "",
        ),
        (
            "an arena whose name is taken, or deleting one in use",
            "409",
            "",
        ),
        (
            "a spec that cannot be read, or an output directory that holds something else",
            "",
            "1",
        ),
        (
            "listening beyond this machine without a token (`evswarm serve`)",
            "",
            "1",
        ),
        // The service's own tests, with a smaller limit.
        (
            "more than 200,000 unfinished runs (`Retry-After` is given)",
            "429",
            "",
        ),
    ];
    let expected: BTreeSet<(&str, &str, &str)> = here
        .into_iter()
        .map(|row| (row, "422", "2"))
        .chain(elsewhere)
        .collect();
    let table = readme::table("What is refused, and how");
    let told: BTreeSet<(&str, &str, &str)> = table
        .iter()
        .map(|row| (&*row[0], &*row[1], &*row[2]))
        .collect();
    assert_eq!(told, expected);
}
