//! The result directory: its files are made elsewhere and put into place when all are there.

use std::fs;
use std::io;
use std::path::Path;

use serde::Serialize;
use swarm::kept::reachable_from;
use swarm::run::Outcome;

use super::files::{Maker, Material, RUN_FILES, RunFile};
use super::put::{WriteError, at, put, sync, write_synced};
use super::run_result;
use super::timing::Timing;
use crate::documents::ResolvedRun;
use crate::store::Findings;

/// A finished run.
#[derive(Clone, Copy, Debug)]
pub struct Finished<'a> {
    /// What was run.
    pub spec: &'a ResolvedRun,
    /// How it ended.
    pub outcome: &'a Outcome,
    /// What it leaves besides.
    pub findings: &'a Findings,
    /// Its recording, on the file system of the workspace, where it has one.
    pub recording: Option<&'a Path>,
}

/// Name of the directory, in the one given for it, in which files are made.
pub const STAGED: &str = "files";

/// Makes all files of a finished run in `workspace` and puts them at `directory`, which must not
/// exist or be empty; see `put`.
///
/// # Errors
/// The first file that could not be written or put into place.
pub fn write_directory(
    directory: &Path,
    workspace: &Path,
    finished: &Finished<'_>,
    timing: &Timing,
) -> Result<(), WriteError> {
    let staged = workspace.join(STAGED);
    // What an earlier process made of the same run and did not come to put into place.
    if let Err(error) = fs::remove_dir_all(&staged)
        && error.kind() != io::ErrorKind::NotFound
    {
        return Err(at(&staged)(error));
    }
    fs::create_dir(&staged).map_err(at(&staged))?;
    for (name, bytes) in files(finished, timing) {
        let path = staged.join(name);
        write_synced(&path, &bytes).map_err(at(&path))?;
    }
    if let Some(recording) = finished.recording
        && let Some(file) = RUN_FILES
            .iter()
            .find(|file| matches!(file.maker, Maker::Recording))
    {
        let path = staged.join(file.name.unwrap_or_default());
        // It stays where it is too, for whoever comes after a crash.
        fs::hard_link(recording, &path)
            .or_else(|_| fs::copy(recording, &path).map(drop))
            .map_err(at(&path))?;
    }
    sync(&staged).map_err(at(&staged))?;
    put(&staged, directory)
}

/// The spec of the finished run that `directory` holds, as the text of its `spec.json`.
pub fn is_complete(directory: &Path) -> Option<String> {
    let spec = fs::read_to_string(directory.join("spec.json")).ok()?;
    directory.join("result.json").is_file().then_some(spec)
}

fn files(finished: &Finished<'_>, timing: &Timing) -> Vec<(&'static str, Vec<u8>)> {
    let Finished {
        spec,
        outcome,
        findings,
        recording: _,
    } = *finished;
    let reachable = || {
        let start = spec.arena().starts().first()?.position();
        let reachable = reachable_from(spec.arena(), &[start], spec.body_radius_m());
        Some(reachable.mask.clone().into())
    };
    let material = Material {
        spec,
        findings,
        reachable: &reachable,
        curve_points: None,
    };
    let make = |file: &RunFile| match file.maker {
        Maker::Spec => Some(spec.canonical_json().into_bytes()),
        Maker::Result => Some(json(&run_result(outcome))),
        Maker::Timing => Some(json(&timing.to_document())),
        Maker::Findings(make) => Some(make(&material)),
        Maker::Recording => None,
    };
    let has_objects = !findings.tracks.is_empty();
    RUN_FILES
        .iter()
        .filter(|file| has_objects || !file.needs_objects)
        .filter_map(|file| Some((file.name?, make(file)?)))
        .collect()
}

fn json(document: &impl Serialize) -> Vec<u8> {
    #[allow(
        clippy::expect_used,
        reason = "structs of numbers and strings: JSON can hold all of them"
    )]
    let mut bytes = serde_json::to_vec_pretty(document).expect("a document is JSON");
    bytes.push(b'\n');
    bytes
}
