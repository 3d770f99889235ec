//! Recordings of the real server and command: the same bytes however they came to be, read in every
//! form, looked at by the commands, and whole whatever happens to them.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod commands;
mod equality;
mod odd;
mod reading;
mod trouble;

use api::recording::{RecordingList, RecordingState, RecordingSummary};
use serde_json::{Value, json};
use tests::server::Server;
use tests::wait;

/// A spec with another value of a field.
fn with(mut spec: Value, field: &str, value: Value) -> Value {
    spec[field] = value;
    spec
}

fn one_run(spec: &Value) -> Value {
    json!({ "base": spec, "seeds": { "first": 1, "count": 1 } })
}

/// Waits for the last of a run's recordings.
fn wait_for_recording(server: &Server, path: &str) -> RecordingSummary {
    wait::until("the recording", || {
        let list: RecordingList = server.read(path);
        let last = list.items.into_iter().next_back()?;
        let ended = matches!(last.state, RecordingState::Done | RecordingState::Cut);
        ended.then_some(last)
    })
}

/// Asks for a recording and waits until it is made; where it is.
fn recorded_afterwards(server: &Server, run: &str, asked: &Value) -> String {
    let path = format!("/v1/runs/{run}/recordings");
    let answer = server.post(&path, asked);
    assert_eq!(answer.status, 201, "{}", answer.text());
    let location = answer.header("location").to_owned();
    let made = wait_for_recording(server, &path);
    assert_eq!(made.state, RecordingState::Done, "{made:?}");
    location
}
