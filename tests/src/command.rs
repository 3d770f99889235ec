//! `evswarm` from the command line.

use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

use crate::{program, wait};

/// What a command did.
#[derive(Debug)]
pub struct Done {
    /// Its exit code; `None` when a signal ended it.
    pub code: Option<i32>,
    /// What it printed.
    pub stdout: String,
    /// What it complained of.
    pub stderr: String,
}

impl From<Output> for Done {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        let done = Self {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        };
        assert!(!done.stderr.contains("panicked"), "{done:?}");
        done
    }
}

/// Starts `evswarm`; channels are under `root`.
pub fn start(arguments: &[&str], root: &Path) -> Child {
    start_in(arguments, root, &[])
}

fn start_in(arguments: &[&str], root: &Path, variables: &[(&str, &str)]) -> Child {
    Command::new(program("evswarm"))
        .args(arguments)
        .env("XDG_RUNTIME_DIR", root)
        .env_remove("EVSWARM_SERVER")
        .env_remove("EVSWARM_TOKEN")
        .env_remove("RUST_LOG")
        .envs(variables.iter().copied())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for a command to end and takes what it printed, which must fit in a pipe.
pub fn finish(mut child: Child) -> Done {
    wait::for_exit(&mut child);
    child.wait_with_output().unwrap().into()
}

/// Runs `evswarm` with this standard input.
pub fn evswarm(arguments: &[&str], input: &str) -> Done {
    evswarm_in(arguments, input, &[])
}

/// Runs `evswarm` with this standard input and these variables.
pub fn evswarm_in(arguments: &[&str], input: &str, variables: &[(&str, &str)]) -> Done {
    let root = tempfile::tempdir().unwrap();
    let mut child = start_in(arguments, root.path(), variables);
    let mut pipe = child.stdin.take().unwrap();
    #[allow(
        clippy::let_underscore_must_use,
        reason = "a command that does not read its input may have ended"
    )]
    let _ = pipe.write_all(input.as_bytes());
    drop(pipe);
    finish(child)
}

/// `evswarm run` of a spec into a directory.
pub fn run(spec: &Value, out: &Path, threads: &str) -> Done {
    let out = out.to_str().unwrap();
    let arguments = ["run", "-", "--out", out, "--threads", threads];
    evswarm(&arguments, &spec.to_string())
}
