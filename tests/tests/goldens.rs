//! Short runs of every kind against digests of what they gave before: results that change must
//! change `RESULTS_VERSION` too, or runs of two programs would be taken for the same.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use tests::command;
use tests::files::sha256_of;

#[derive(Serialize, Deserialize)]
struct Goldens {
    results_version: u32,
    goldens: Vec<Golden>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Golden {
    name: String,
    spec: Value,
    state_sha256: String,
    curve_sha256: String,
    visits_sha256: String,
}

/// As `evswarm --version` says it: `evswarm 0.1.0 (results 1)`.
fn results_version() -> u32 {
    let said = command::evswarm(&["--version"], "").stdout;
    let (_, version) = said.trim_end().rsplit_once("results ").unwrap();
    version.trim_end_matches(')').parse().unwrap()
}

fn run(golden: &Golden, out: &Path) -> Golden {
    let done = command::run(&golden.spec, out, "1");
    assert_eq!(done.code, Some(0), "{}: {}", golden.name, done.stderr);
    let result: Value =
        serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap();
    Golden {
        state_sha256: result["state_sha256"].as_str().unwrap().to_owned(),
        curve_sha256: sha256_of(&out.join("curve.csv")),
        visits_sha256: sha256_of(&out.join("visits.npy")),
        ..golden.clone()
    }
}

/// With `EVSWARM_GOLDENS` set to a path, the digests of this program are written there as well.
#[test]
fn results_are_those_of_their_version() {
    let text = include_str!("../goldens/goldens.json");
    let stored: Goldens = serde_json::from_str(text).unwrap();
    assert_eq!(
        stored.results_version,
        results_version(),
        "the goldens are of another version: make them anew with EVSWARM_GOLDENS=FILE"
    );
    let home = tempfile::tempdir().unwrap();
    let found: Vec<Golden> = stored
        .goldens
        .iter()
        .map(|golden| run(golden, &home.path().join(&golden.name)))
        .collect();
    if let Some(path) = std::env::var_os("EVSWARM_GOLDENS") {
        let found = Goldens {
            results_version: stored.results_version,
            goldens: found.clone(),
        };
        fs::write(path, serde_json::to_string_pretty(&found).unwrap()).unwrap();
    }
    let changed: Vec<&str> = stored
        .goldens
        .iter()
        .zip(&found)
        .filter(|(stored, found)| stored != found)
        .map(|(stored, _)| stored.name.as_str())
        .collect();
    assert!(
        changed.is_empty(),
        "{changed:?} gave other results than version {} of results: if that is meant, raise \
         swarm::RESULTS_VERSION, say so in CHANGELOG.md and make the goldens anew",
        stored.results_version
    );
}
