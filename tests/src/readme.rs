//! The README, so that what it says is what is tested.

use std::fs;
use std::path::{Path, PathBuf};

/// The folder that the README is in.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap()
        .to_owned()
}

/// The README.
pub fn text() -> String {
    fs::read_to_string(root().join("README.md")).unwrap()
}

/// The rows of the first table under a heading, cell by cell.
pub fn table(heading: &str) -> Vec<Vec<String>> {
    let text = text();
    let rows: Vec<Vec<String>> = text
        .lines()
        .skip_while(|line| line.trim_start_matches('#').trim() != heading)
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'))
        .skip(2) // names of columns, and the line under them
        .map(|line| {
            let cells = line.trim_matches('|').split('|');
            cells.map(|cell| cell.trim().to_owned()).collect()
        })
        .collect();
    assert!(!rows.is_empty(), "no table under {heading:?}");
    rows
}
