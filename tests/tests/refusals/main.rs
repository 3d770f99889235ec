//! The README's table of what is refused and how: every row, over HTTP and by `evswarm run`.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod commands;
mod jobs;
mod requests;
mod specs;

use std::collections::BTreeSet;
use std::fs;

use api::FieldError;
use api::refusals::REFUSED;
use tests::readme;
use tests::refusals::row;

/// Whether there is an error at this place with these words, which says what is allowed.
fn has(errors: &[FieldError], pointer: &str, words: &str) -> bool {
    errors.iter().any(|error| {
        error.pointer == pointer && error.message.contains(words) && !error.allowed.is_empty()
    })
}

/// The texts of the tests that show rows, besides those of wrong specs: the ones here, those of
/// connections and events, and those of the service itself, which can have smaller limits.
fn sources() -> String {
    let folders = ["tests/tests/refusals", "server/src/http/tests"];
    let files = folders.map(|folder| fs::read_dir(readme::root().join(folder)).unwrap());
    let paths = files.into_iter().flatten().map(|file| file.unwrap().path());
    let others =
        ["connections.rs", "events.rs"].map(|file| readme::root().join("tests/tests").join(file));
    paths
        .chain(others)
        .map(|path| fs::read_to_string(path).unwrap())
        .collect()
}

#[test]
fn every_row_of_the_table_has_its_test() {
    let specs: BTreeSet<&str> = specs::wrong_specs()
        .into_iter()
        .map(|wrong| row(wrong.0).what)
        .collect();
    let sources = sources();
    let untested: Vec<&str> = REFUSED
        .iter()
        .map(|case| case.what)
        .filter(|what| !specs.contains(what) && !sources.contains(&format!("{what:?}")))
        .collect();
    assert!(
        untested.is_empty(),
        "no test names these rows of api/src/refusals.rs: {untested:#?}"
    );
}
