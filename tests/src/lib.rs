//! What the end-to-end tests share: the real `evswarm` as separate processes, asked over HTTP and
//! by its command line, with every wait bounded.
//!
//! Failures panic: that is how a test fails.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

pub mod command;
pub mod events;
pub mod files;
pub mod http;
pub mod readme;
pub mod refusals;
pub mod server;
pub mod wait;

use std::path::PathBuf;

use serde_json::{Value, json};

/// A program that `make build` puts two folders above the test that runs: `evswarm`, or an example
/// such as `examples/watch_frames`.
pub fn program(name: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let folder = test.ancestors().nth(2).unwrap();
    let path = folder.join(name);
    assert!(
        path.is_file(),
        "{} is missing: run `make test`, or `make build` before",
        path.display()
    );
    path
}

/// A run spec that takes a moment.
pub fn small_spec() -> Value {
    json!({
        "seed": 1, "arena": "easy", "controller": { "method": "brownian" },
        "epochs": 3, "steps_per_epoch": 200
    })
}

/// A job of `count` runs of this spec, seeds from 1 up.
pub fn job(mut spec: Value, count: u64) -> Value {
    spec.as_object_mut().unwrap().remove("seed");
    json!({ "name": "a job", "base": spec, "seeds": { "first": 1, "count": count } })
}
