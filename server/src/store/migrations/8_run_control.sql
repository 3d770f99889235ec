-- Control of single runs, priorities, jobs as they were posted, and what was changed on the way.

ALTER TABLE jobs ADD COLUMN priority INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN document TEXT; -- NULL for jobs of earlier versions, and where none was posted

ALTER TABLE runs ADD COLUMN held INTEGER NOT NULL DEFAULT 0;  -- 1: paused by itself, whatever its jobs want
ALTER TABLE runs ADD COLUMN pause_at_step INTEGER;            -- step of its arena at which it is to be held

CREATE TABLE run_log (
    seq              INTEGER PRIMARY KEY,
    run              INTEGER NOT NULL REFERENCES runs (seq) ON DELETE CASCADE,
    at               TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
    robot_steps_done INTEGER, -- NULL where the run was in a worker's hands
    what             TEXT NOT NULL
) STRICT;

CREATE INDEX run_log_by_run ON run_log (run);
