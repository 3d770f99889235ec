//! Every problem that the service answers with: one table makes the enum, the codes, their status
//! and what they mean. Codes are for programs and never change.

macro_rules! problem_codes {
    ($($name:ident $status:literal $code:literal $title:literal $meaning:literal)*) => {
        /// A kind of problem.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum ProblemCode {
            $(#[doc = $meaning] $name,)*
        }

        impl ProblemCode {
            /// All of them, by status.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// The code, for programs.
            pub const fn code(self) -> &'static str {
                match self { $(Self::$name => $code),* }
            }

            /// URI reference of the kind of problem, where the service says what it means.
            pub const fn uri(self) -> &'static str {
                match self { $(Self::$name => concat!("/problems/", $code)),* }
            }

            /// HTTP status.
            pub const fn status(self) -> u16 {
                match self { $(Self::$name => $status),* }
            }

            /// What kind of problem, in a few words.
            pub const fn title(self) -> &'static str {
                match self { $(Self::$name => $title),* }
            }

            /// What it means and what to do.
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$name => $meaning),* }
            }
        }
    };
}

problem_codes! {
    InvalidRequest 400 "invalid-request" "The request cannot be read"
        "Its path, its headers or its body cannot be read as HTTP or as UTF-8, or the body broke off."
    InvalidHeader 400 "invalid-header" "A header cannot be used"
        "A header is missing or its value cannot be used; the detail says which."
    InvalidQuery 400 "invalid-query" "The query cannot be used"
        "A query parameter does not exist, is given twice, or its value cannot be used."
    InvalidJson 400 "invalid-json" "The body is not JSON"
        "The errors say where the text stops being JSON."
    TokenNeeded 401 "token-needed" "A token is needed"
        "The server asks for a token and got none or a wrong one."
    ReadOnlyToken 403 "read-only-token" "The token only reads"
        "What changes something needs a token that may change it."
    ForeignHost 403 "foreign-host" "Another host's name"
        "A server without a token answers to localhost and loopback addresses alone."
    ForeignOrigin 403 "foreign-origin" "Another site's page"
        "What changes something may not be asked for by a page of another site."
    JobNotFound 404 "job-not-found" "There is no such job"
        "No job has this id; it may have been deleted."
    RunNotFound 404 "run-not-found" "There is no such run"
        "No job has a run of this id."
    ArenaNotFound 404 "arena-not-found" "There is no such arena"
        "No arena is built in or uploaded under this name."
    ReportNotFound 404 "report-not-found" "The job has no report"
        "Only jobs of the template chapter-5 have a report."
    RecordingNotFound 404 "recording-not-found" "There is no such recording"
        "The run's spec does not ask for a recording, it has not begun, or it was deleted to make room. One can be made of any run: `POST /v1/runs/{id}/recordings`."
    RouteNotFound 404 "route-not-found" "There is no such route"
        "Nothing is served under this path."
    MethodNotAllowed 405 "method-not-allowed" "The route does not have this method"
        "The header Allow says which it has."
    BodyTooSlow 408 "body-too-slow" "The body took too long"
        "A body has to arrive within the time that the server gives it."
    NoResult 409 "no-result" "The run has no result"
        "A run has its result when it is done."
    FindingsNotKept 409 "findings-not-kept" "What the run covered is not kept"
        "A run that failed or was cancelled keeps nothing of what it found."
    NothingLearnt 409 "nothing-learnt" "The robot has learnt nothing"
        "Its method learns nothing, or the run has no such robot."
    AlreadyEnded 409 "already-ended" "It has ended"
        "What has ended cannot be cancelled, paused or resumed, and what is done not tried again."
    NotEnded 409 "not-ended" "It has not ended"
        "Only what has ended can be tried again."
    NotPaused 409 "not-paused" "The run is not paused"
        "A run is stepped by epochs only while it is paused."
    HeldByJob 409 "held-by-job" "The run's job holds it"
        "A run of a job that is paused or cancelled goes on with its job: resume or retry that."
    DocumentNotKept 409 "document-not-kept" "The job's document is not kept"
        "Jobs of versions that did not keep documents can neither show theirs nor be extended."
    CheckpointNotKept 409 "checkpoint-not-kept" "No state of the run is kept"
        "A run that has not begun has no state to go on from, and of one that has ended its last state is kept only while there is room."
    ReportNotReady 409 "report-not-ready" "The report is not ready"
        "A report is made of all runs of its job, once they are done."
    ArenaNameTaken 409 "arena-name-taken" "The arena's name is taken"
        "Another arena has this name; delete that one or choose another name."
    ArenaInUse 409 "arena-in-use" "The arena is in use"
        "Stored runs use the arena; delete their jobs first."
    ArenaBuiltIn 409 "arena-built-in" "The arena is built in"
        "An arena that ships with the program cannot be deleted."
    RecordingBeingMade 409 "recording-being-made" "The recording is being made"
        "The run records itself: pause or cancel it, or wait until it is done."
    NotRepeatable 409 "not-repeatable" "The run cannot be stepped again"
        "A program outside steered it, or it is of another version of results: there is the recording that its spec asked for with `record`, and no other recording and no explanation."
    KeyUnderWay 409 "idempotency-key-under-way" "The same request is under way"
        "A request with the same Idempotency-Key is being stored or its job deleted; ask again after the time in Retry-After."
    BodyTooLarge 413 "body-too-large" "The body is too large"
        "A body has a greatest size; the detail tells it."
    NotSaidToBeJson 415 "not-said-to-be-json" "The body is not said to be JSON"
        "Send the header content-type: application/json."
    NotSaidToBeBytes 415 "not-said-to-be-bytes" "The body is not said to be bytes"
        "Send the header content-type: application/octet-stream, or none."
    RangeNotSatisfiable 416 "range-not-satisfiable" "There are no such bytes"
        "The header Range asks for bytes beyond the end; Content-Range tells how many there are."
    InvalidDocument 422 "invalid-document" "Fields of the document cannot be used"
        "The body is JSON, but the errors name fields that cannot be used, and what is allowed."
    KeyReused 422 "idempotency-key-reused" "The idempotency key was used"
        "Another body was posted with the same Idempotency-Key."
    JobTooLarge 422 "job-too-large" "The job has too many runs"
        "The job has more runs than may be unfinished at all."
    TableTooLong 422 "table-too-long" "The table would be too long"
        "A table of this job has more rows than are given at once; ask for its runs one by one."
    QueueFull 429 "queue-full" "Too many runs are unfinished"
        "Try again after the time in Retry-After, or cancel jobs."
    RecordingsFull 429 "recordings-full" "Too many recordings"
        "Too many wait to be made, or the run has too many: try again later, or delete one."
    TooManyAttempts 429 "too-many-attempts" "Too many wrong tokens"
        "Wrong tokens came from this address too often; try again after the time in Retry-After."
    Internal 500 "internal" "The server failed"
        "The fault is the server's; its log says why."
    Damaged 500 "damaged" "Stored data is damaged"
        "What is stored cannot be read or does not fit together; the server's log says which."
    Overloaded 503 "overloaded" "Too many requests at a time"
        "Try again after the time in Retry-After."
    AnswerTooSlow 503 "answer-too-slow" "The answer took too long"
        "The work was given up; try again after the time in Retry-After."
    NotReady 503 "not-ready" "The server is not ready"
        "Its database does not answer, or not soon enough, or there is no room left to store what comes; try again after the time in Retry-After."
    TooManyListeners 503 "too-many-listeners" "Too many listen"
        "As many streams are open as the server allows, or as many runs have channels that were asked for; the answer says when to try again."
    StoreFull 507 "store-full" "There is no room left"
        "The server's disk or quota is full. Nothing was stored; runs wait until there is room."
    ArenasFull 507 "arenas-full" "Too many arenas are stored"
        "Delete arenas that no run uses."
}

impl ProblemCode {
    /// The problem of this code.
    pub fn from_code(code: &str) -> Option<Self> {
        Self::ALL
            .iter()
            .copied()
            .find(|problem| problem.code() == code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_unique_and_sorted_by_status() {
        let codes: std::collections::BTreeSet<&str> =
            ProblemCode::ALL.iter().map(|code| code.code()).collect();
        assert_eq!(codes.len(), ProblemCode::ALL.len());
        assert!(ProblemCode::ALL.is_sorted_by_key(|code| code.status()));
        for code in ProblemCode::ALL {
            let is_plain = |c: char| c.is_ascii_lowercase() || c == '-';
            assert!(code.code().chars().all(is_plain), "{code:?}");
            assert_eq!(ProblemCode::from_code(code.code()), Some(*code));
            assert!(code.meaning().ends_with('.'), "{code:?}");
        }
    }
}
