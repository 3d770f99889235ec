-- Jobs, the runs that they share, what finished runs found, and uploaded arenas.

CREATE TABLE jobs (
    seq             INTEGER PRIMARY KEY AUTOINCREMENT,
    name            TEXT NOT NULL,
    intent          TEXT NOT NULL DEFAULT 'active' CHECK (intent IN ('active', 'paused', 'cancelled')),
    created_at      TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
    idempotency_key TEXT UNIQUE,
    request_sha256  TEXT NOT NULL
) STRICT;

CREATE TABLE runs (
    seq               INTEGER PRIMARY KEY AUTOINCREMENT,
    id                TEXT NOT NULL UNIQUE,
    seed              INTEGER NOT NULL,
    arena             TEXT NOT NULL,
    method            TEXT NOT NULL,
    state             TEXT NOT NULL DEFAULT 'queued'
        CHECK (state IN ('queued', 'running', 'paused', 'done', 'failed', 'cancelled')),
    reason            TEXT,
    phase             TEXT,
    epochs_done       INTEGER NOT NULL DEFAULT 0,
    epochs_total      INTEGER NOT NULL,
    robot_steps_done  INTEGER NOT NULL DEFAULT 0,
    robot_steps_total INTEGER NOT NULL,
    spec              TEXT NOT NULL, -- last, so that lists need not read past it
    CHECK ((state = 'failed') = (reason IS NOT NULL))
) STRICT;

CREATE INDEX runs_by_state ON runs (state);

CREATE TABLE job_runs (
    job     INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,
    ordinal INTEGER NOT NULL,
    run     INTEGER NOT NULL REFERENCES runs (seq),
    PRIMARY KEY (job, ordinal)
) STRICT, WITHOUT ROWID;

CREATE INDEX job_runs_by_run ON job_runs (run);

CREATE TABLE results (
    run      INTEGER PRIMARY KEY REFERENCES runs (seq) ON DELETE CASCADE,
    result   TEXT NOT NULL,
    coverage BLOB NOT NULL
) STRICT;

CREATE TABLE arenas (
    name    TEXT PRIMARY KEY,
    listing TEXT NOT NULL,
    body    TEXT NOT NULL
) STRICT;

-- Uploaded arenas that runs use, and that therefore cannot be deleted.
CREATE TABLE run_arenas (
    run   INTEGER NOT NULL REFERENCES runs (seq) ON DELETE CASCADE,
    arena TEXT NOT NULL REFERENCES arenas (name),
    PRIMARY KEY (run, arena)
) STRICT, WITHOUT ROWID;

CREATE INDEX run_arenas_by_arena ON run_arenas (arena);
