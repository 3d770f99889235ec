//! The explanation of a run as it is kept in the folder of its recordings.

use std::fs;
use std::io::Write;
use std::path::Path;

use api::explanation::Explanation;
use serde::{Deserialize, Serialize};

const FILE: &str = "explanation.cache";
/// Raised when explanations tell other things: those of before are found anew.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
struct Kept {
    version: u32,
    explanation: Option<Explanation>,
    reason: Option<String>,
}

/// What is known of why a run did what it did, or why that cannot be known.
pub fn known_explanation(directory: &Path) -> Option<Result<Explanation, String>> {
    let bytes = fs::read(directory.join(FILE)).ok()?;
    let kept: Kept = serde_json::from_slice(&bytes).ok()?;
    if kept.version != VERSION {
        return None;
    }
    match kept {
        Kept {
            explanation: Some(explanation),
            ..
        } => Some(Ok(explanation)),
        Kept { reason, .. } => reason.map(Err),
    }
}

/// Keeps it; one that cannot be kept is found anew when it is asked for.
pub fn keep_explanation(directory: &Path, found: &Result<Explanation, String>) {
    let kept = Kept {
        version: VERSION,
        explanation: found.as_ref().ok().cloned(),
        reason: found.as_ref().err().cloned(),
    };
    let write = || -> std::io::Result<()> {
        fs::create_dir_all(directory)?;
        let mut file = tempfile::NamedTempFile::new_in(directory)?;
        file.write_all(&serde_json::to_vec(&kept)?)?;
        file.persist(directory.join(FILE))?;
        Ok(())
    };
    if let Err(error) = write() {
        tracing::warn!(%error, "an explanation cannot be kept");
    }
}
