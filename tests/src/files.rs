//! What a run leaves behind, from a directory or from a server.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use api::RunResult;
use sha2::{Digest, Sha256};

use crate::http::Client;

/// The files of a run that only its spec decides: all but `timing.json`.
pub const SAME: [&str; 7] = [
    "spec.json",
    "result.json",
    "curve.csv",
    "metrics.csv",
    "robots.csv",
    "visits.npy",
    "coverage.png",
];

/// What a run found, byte for byte.
#[derive(Clone, PartialEq, Eq)]
pub struct Findings {
    files: BTreeMap<&'static str, Vec<u8>>,
}

impl Findings {
    /// From the directory that `evswarm run` wrote, which must hold these files and no others.
    pub fn of_directory(directory: &Path) -> Self {
        let mut names: Vec<String> = fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        let mut expected = SAME.map(str::to_owned).to_vec();
        expected.push("timing.json".to_owned());
        names.sort();
        expected.sort();
        assert_eq!(names, expected);
        let read = |name| (name, fs::read(directory.join(name)).unwrap());
        Self {
            files: SAME.into_iter().map(read).collect(),
        }
    }

    /// From a server.
    pub fn of_run(server: &Client, id: &str) -> Self {
        let read = |name| {
            let route = match name {
                "spec.json" => "spec",
                "result.json" => "result",
                "visits.npy" => "coverage.npy",
                other => other,
            };
            let answer = server.get(&format!("/v1/runs/{id}/{route}"));
            assert_eq!(answer.status, 200, "{name}");
            if name == "result.json" {
                // Files are written for people, with line breaks; answers are not.
                let result: RunResult = answer.json();
                let mut text = serde_json::to_vec_pretty(&result).unwrap();
                text.push(b'\n');
                return (name, text);
            }
            (name, answer.body)
        };
        Self {
            files: SAME.into_iter().map(read).collect(),
        }
    }

    /// Compares file by file.
    ///
    /// # Panics
    /// With the names of all files that differ.
    pub fn assert_same(&self, other: &Self, what: &str) {
        let differing = self.differing(other);
        assert!(differing.is_empty(), "{what}: {differing:?} differ");
    }

    /// The names of the files that differ.
    pub fn differing(&self, other: &Self) -> Vec<&'static str> {
        SAME.into_iter()
            .filter(|name| self.files[name] != other.files[name])
            .collect()
    }

    /// `result.json`.
    pub fn result(&self) -> RunResult {
        serde_json::from_slice(&self.files["result.json"]).unwrap()
    }
}

/// The numbers of a NumPy file of `u32` with this many squares along a side.
pub fn npy(bytes: &[u8], squares: usize) -> Vec<u32> {
    assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
    let header_bytes = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let (header, data) = bytes[10..].split_at(header_bytes);
    let header = std::str::from_utf8(header).unwrap();
    assert!(header.contains("'descr': '<u4'") && header.contains("'fortran_order': False"));
    assert!(header.contains(&format!("'shape': ({squares}, {squares})")));
    assert_eq!(data.len(), 4 * squares * squares);
    data.chunks_exact(4)
        .map(|chunk| u32::from_le_bytes(chunk.try_into().unwrap()))
        .collect()
}

/// SHA-256 of a file, in hex.
pub fn sha256_of(path: &Path) -> String {
    Sha256::digest(fs::read(path).unwrap())
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}
