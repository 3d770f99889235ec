//! The files of `experiments/`: each is a job or a run as anyone can post it, and stands in the
//! table of the folder's README with its number of runs.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use api::FieldError;

use super::*;

/// What a file is, and how many runs it makes.
fn check(text: &str) -> Result<(&'static str, usize), Vec<FieldError>> {
    let document = parse(text)?;
    let fields = ["base", "parts", "template"];
    if fields.iter().any(|field| document.get(field).is_some()) {
        Ok(("job", expand(&document, &BuiltinArenas)?.runs.len()))
    } else {
        resolve(&document, &BuiltinArenas).map(|_| ("run", 1))
    }
}

#[test]
fn every_experiment_can_be_posted_and_stands_in_the_table() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(&folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name == "README.md" {
            continue;
        }
        let text = fs::read_to_string(folder.join(&name)).unwrap();
        let (kind, runs) = check(&text).unwrap_or_else(|errors| panic!("{name}: {errors:#?}"));
        let file = format!("[{name}]({name})");
        found.insert(file, (kind.to_owned(), runs.to_string()));
    }
    let readme = fs::read_to_string(folder.join("README.md")).unwrap();
    let rows = readme.lines().filter(|line| line.starts_with("| ["));
    let told: BTreeMap<_, _> = rows
        .map(|row| {
            let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
            let [file, kind, runs, _] = cells[..] else {
                panic!("not four cells: {row}")
            };
            (file.to_owned(), (kind.to_owned(), runs.to_owned()))
        })
        .collect();
    assert_eq!(told, found);
}

#[test]
fn an_experiment_with_a_wrong_field_is_told_with_its_pointer() {
    let errors = check(r#"{ "base": { "robotz": 3 } }"#).unwrap_err();
    assert_eq!(errors[0].pointer, "/base/robotz");
    let errors = check(r#"{ "robotz": 3 }"#).unwrap_err();
    assert_eq!(errors[0].pointer, "/robotz");
    assert!(check("{").is_err());
}
