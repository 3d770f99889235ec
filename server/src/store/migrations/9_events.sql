-- Changes of state in the order they were stored, for listeners that come late or come back: the
-- newest 100,000. Triggers write them in the transaction that changes the state.

CREATE TABLE changes (
    id    INTEGER PRIMARY KEY AUTOINCREMENT,
    run   INTEGER, -- null where it is the job's owner who wants something else
    job   INTEGER, -- null where it is a run's state
    state TEXT NOT NULL
) STRICT;

CREATE INDEX changes_by_run ON changes (run, id) WHERE run IS NOT NULL;

CREATE TRIGGER run_state_changed AFTER UPDATE OF state ON runs WHEN OLD.state <> NEW.state BEGIN
    INSERT INTO changes (run, state) VALUES (NEW.seq, NEW.state);
END;

CREATE TRIGGER job_intent_changed AFTER UPDATE OF intent ON jobs WHEN OLD.intent <> NEW.intent BEGIN
    INSERT INTO changes (job, state) VALUES (NEW.seq, NEW.intent);
END;

CREATE TRIGGER changes_bounded AFTER INSERT ON changes BEGIN
    DELETE FROM changes WHERE id <= NEW.id - 100000;
END;
