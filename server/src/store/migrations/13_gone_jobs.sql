-- A deleted job is a change too, for listeners that come back: in the transaction that deletes it.

CREATE TRIGGER job_deleted AFTER DELETE ON jobs BEGIN
    INSERT INTO changes (job, state) VALUES (OLD.seq, 'gone');
END;
