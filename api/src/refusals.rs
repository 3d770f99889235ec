//! What is refused, and how: the README's table. Each row has a test that names it.

use crate::ProblemCode::{self, *};

/// Something that is refused.
#[derive(Clone, Copy, Debug)]
pub struct RefusedCase {
    /// In words.
    pub what: &'static str,
    /// What the service answers; `None` where it cannot be asked that.
    pub problem: Option<ProblemCode>,
    /// What `evswarm run` (or the command that is named) exits with; `None` where it cannot be
    /// asked that.
    pub exit: Option<u8>,
}

const fn spec(what: &'static str) -> RefusedCase {
    RefusedCase {
        what,
        problem: Some(InvalidDocument),
        exit: Some(2),
    }
}

const fn service(what: &'static str, problem: ProblemCode) -> RefusedCase {
    RefusedCase {
        what,
        problem: Some(problem),
        exit: None,
    }
}

const fn command(what: &'static str) -> RefusedCase {
    RefusedCase {
        what,
        problem: None,
        exit: Some(1),
    }
}

/// Every row, in the README's order.
pub const REFUSED: &[RefusedCase] = &[
    RefusedCase {
        problem: Some(InvalidJson),
        ..spec("text that is not JSON")
    },
    spec("a key that stands in its object twice"),
    spec("a field that does not exist (the nearest name is told)"),
    spec("a number out of range or a value of the wrong kind"),
    spec("an unknown arena, method, preset, engine or placement"),
    spec("an arena with a wall outside it or a start inside a wall"),
    spec("an arena written out under a built-in one's name, with other walls"),
    spec("more tiles of an arena than fit, a wrong scale or doorway"),
    spec("more robots than the arena has start poses"),
    spec("more robots than fit under the placement `grid` or `random`"),
    spec("a robot that moves too far in a step for its size"),
    spec("training for a method that has none"),
    spec("movable objects under the kinematic engine, also in a training arena"),
    spec("a memory budget too small for any plan (the smallest that works is told)"),
    spec("sharing what a method does not have, or by a radio that cannot be"),
    spec("recording robots or fields that are not there, or more bytes than a recording may have"),
    service(
        "a matrix with a wrong path, no value or twice the same run",
        InvalidDocument,
    ),
    service(
        "a parameter varied for a method that does not have it",
        InvalidDocument,
    ),
    service(
        "parts beside a matrix, or two that make the same run",
        InvalidDocument,
    ),
    service(
        "a seed twice, or seeds beside a seed in the base run",
        InvalidDocument,
    ),
    service("a job of more than 100,000 runs", InvalidDocument),
    service("an idempotency key used for another body", KeyReused),
    service("a job of more runs than may be unfinished", JobTooLarge),
    service(
        "more than 200,000 unfinished runs (`Retry-After` is given)",
        QueueFull,
    ),
    service("a body of more than 4 MiB", BodyTooLarge),
    service("a body that takes too long to come", BodyTooSlow),
    service("a body that is not said to be JSON", NotSaidToBeJson),
    service(
        "a checkpoint that is said to be something else than bytes",
        NotSaidToBeBytes,
    ),
    service(
        "bytes beyond the end of a file (`Range`)",
        RangeNotSatisfiable,
    ),
    service(
        "a query parameter that the route does not have, or one given twice",
        InvalidQuery,
    ),
    service("a page size or cursor that makes no sense", InvalidQuery),
    service(
        "an idempotency key that is empty or too long",
        InvalidHeader,
    ),
    service("a `Last-Event-ID` that is no number", InvalidHeader),
    service("a path that is not UTF-8", InvalidRequest),
    service(
        "a missing or wrong token, where the server has one",
        TokenNeeded,
    ),
    service(
        "a change asked for with a token that only reads",
        ReadOnlyToken,
    ),
    service(
        "more than 20 wrong tokens a minute from an address",
        TooManyAttempts,
    ),
    service("another host's name, where there is no token", ForeignHost),
    service("a change asked for by another site's page", ForeignOrigin),
    service("an unknown job", JobNotFound),
    service("an unknown run", RunNotFound),
    service("an unknown arena", ArenaNotFound),
    service("a recording that is not there", RecordingNotFound),
    service("an unknown route", RouteNotFound),
    service("a method that a route does not have", MethodNotAllowed),
    service(
        "deleting the recording of a run that is to record more",
        RecordingBeingMade,
    ),
    service(
        "more than 100 recordings of a run, or 64 that wait",
        RecordingsFull,
    ),
    service(
        "recording or explaining what a program outside steered",
        NotRepeatable,
    ),
    service(
        "more bytes of recordings than a run or a job may have",
        InvalidDocument,
    ),
    service(
        "the result or the explanation of an unfinished run",
        NoResult,
    ),
    service(
        "what a robot has learnt by a method that learns nothing",
        NothingLearnt,
    ),
    service(
        "a check of an arena or a job that is not valid",
        InvalidDocument,
    ),
    service("what a cancelled run covered", FindingsNotKept),
    service("cancelling what is done or failed", AlreadyEnded),
    service("opening channels of a run that has ended", AlreadyEnded),
    service("resuming or trying again what is done", AlreadyEnded),
    service("trying again a job that has not ended", NotEnded),
    service("stepping a run that is not paused", NotPaused),
    service(
        "the state of a run of which none is kept",
        CheckpointNotKept,
    ),
    service(
        "a checkpoint that is foreign, altered or of another version",
        InvalidDocument,
    ),
    service(
        "a fork that changes what its state was made with",
        InvalidDocument,
    ),
    service("resuming a run whose job is paused", HeldByJob),
    service(
        "a control that is not one whole number in its range",
        InvalidDocument,
    ),
    service("the report of another job than chapter 5", ReportNotFound),
    service("the report of an unfinished job", ReportNotReady),
    service("an arena whose name is taken", ArenaNameTaken),
    service("deleting an arena in use", ArenaInUse),
    service("deleting a built-in arena", ArenaBuiltIn),
    service("a stored spec or checkpoint that is damaged", Damaged),
    command("a spec that cannot be read, or an output directory that holds something else"),
    command("a file of tokens that cannot be used (`evswarm serve`)"),
    command("listening beyond this machine without a token (`evswarm serve`)"),
];

/// The row of these words.
pub fn refused(what: &str) -> Option<&'static RefusedCase> {
    REFUSED.iter().find(|case| case.what == what)
}

/// The table in Markdown, as the README has it.
pub fn refusals_in_markdown() -> String {
    let mut text = String::from("| What | Service | Code | `evswarm run` |\n|---|---|---|---|\n");
    for RefusedCase {
        what,
        problem,
        exit,
    } in REFUSED
    {
        let cell = |text: String| match text {
            text if text.is_empty() => " ".to_owned(),
            text => format!(" {text} "),
        };
        let status = cell(problem.map_or(String::new(), |code| code.status().to_string()));
        let code = cell(problem.map_or(String::new(), |code| format!("`{}`", code.code())));
        let exit = cell(exit.map_or(String::new(), |exit| exit.to_string()));
        text += &format!("| {what} |{status}|{code}|{exit}|\n");
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::path::Path;

    use super::*;

    #[test]
    fn the_readme_has_this_table() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
        let readme = std::fs::read_to_string(&path).unwrap();
        let is_row = |line: &&str| line.starts_with('|');
        let told: Vec<&str> = readme
            .lines()
            .skip_while(|line| *line != "## What is refused, and how")
            .skip_while(|line| !is_row(line))
            .take_while(is_row)
            .collect();
        let told = told.join("\n") + "\n";
        let right = refusals_in_markdown();
        if std::env::var_os("EVSWARM_REWRITE").is_some() {
            std::fs::write(&path, readme.replacen(&told, &right, 1)).unwrap();
            return;
        }
        assert!(
            told == right,
            "the README's table of refusals differs from api/src/refusals.rs; rewrite it with \
             EVSWARM_REWRITE=1 cargo test --release -p api"
        );
    }
}
