//! What documents say of the repository: links lead somewhere, lists are complete, the changelog
//! knows the version of results that the program has.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use tests::{command, readme};

/// Every document, the folder `target` and hidden ones left out.
fn documents() -> Vec<PathBuf> {
    fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir()
                && !name.starts_with('.')
                && !["target", "data", "node_modules"].contains(&&*name)
            {
                collect(&path, found);
            } else if name.ends_with(".md") {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    collect(&readme::root(), &mut found);
    assert!(found.len() > 20, "{found:?}");
    found
}

/// Where the links of a text lead that stay within the repository.
fn links(text: &str) -> Vec<&str> {
    let targets = text
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next());
    targets
        .filter(|link| !link.contains("://") && !link.starts_with('#'))
        .filter_map(|link| link.split('#').next())
        .collect()
}

#[test]
fn links_of_documents_lead_somewhere() {
    assert_eq!(
        links("[a](b.md#c) ![d](e/f.png) [g](#h) [i](https://j.k)"),
        ["b.md", "e/f.png"]
    );
    let broken: Vec<String> = documents()
        .iter()
        .flat_map(|document| {
            let text = fs::read_to_string(document).unwrap();
            let folder = document.parent().unwrap();
            let missing = links(&text)
                .into_iter()
                .filter(|link| !folder.join(link).exists())
                .map(|link| format!("{}: {link}", document.display()));
            missing.collect::<Vec<_>>()
        })
        .collect();
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_decision_is_in_the_list_of_the_architecture() {
    let folder = readme::root().join("docs/decisions");
    let files: BTreeSet<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let numbers: BTreeSet<&str> = files.iter().map(|name| &name[..4]).collect();
    assert_eq!(numbers.len(), files.len(), "a number twice: {files:?}");
    let text = fs::read_to_string(readme::root().join("ARCHITECTURE.md")).unwrap();
    let listed: BTreeSet<String> = links(&text)
        .into_iter()
        .filter_map(|link| link.strip_prefix("docs/decisions/"))
        .filter(|name| !name.is_empty())
        .map(str::to_owned)
        .collect();
    assert_eq!(listed, files);
}

#[test]
fn every_entry_of_the_changelog_begins_with_results_and_the_first_has_the_programs_version() {
    let text = fs::read_to_string(readme::root().join("CHANGELOG.md")).unwrap();
    let entries: Vec<&str> = text.split("\n## ").skip(1).collect();
    let versions: Vec<&str> = entries
        .iter()
        .map(|entry| {
            let line = entry.lines().skip(1).find(|line| !line.is_empty()).unwrap();
            let told = line.strip_prefix("Results: ");
            let told = told.unwrap_or_else(|| panic!("no results: {line:?}"));
            let (_, version) = told.split_once(" (version ").unwrap();
            let (version, _) = version.split_once(')').unwrap();
            version
        })
        .collect();
    let said = command::evswarm(&["--version"], "").stdout;
    assert!(
        said.contains(&format!("(results {})", versions[0])),
        "{said:?} is not the version {} of CHANGELOG.md's first entry",
        versions[0]
    );
}

/// Paths of the repository that a text has between backquotes; those with a NAME are patterns.
fn paths(text: &str) -> Vec<&str> {
    let roots = ["arenas/", "swarm/", "api/", "server/", "tests/", "docs/"];
    let quoted = text.split('`').skip(1).step_by(2);
    quoted
        .filter(|word| roots.iter().any(|root| word.starts_with(root)))
        .filter(|word| !word.contains("NAME"))
        .collect()
}

#[test]
fn files_that_the_glossary_and_the_recipes_name_exist() {
    for document in ["docs/glossary.md", "CONTRIBUTING.md"] {
        let text = fs::read_to_string(readme::root().join(document)).unwrap();
        let named = paths(&text);
        assert!(!named.is_empty(), "{document} names no file");
        for path in named {
            assert!(readme::root().join(path).exists(), "{document}: {path}");
        }
    }
}
