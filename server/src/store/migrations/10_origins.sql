-- Where a run goes on from that does not start at its beginning: the run and the state, as JSON.

ALTER TABLE runs ADD COLUMN origin TEXT;
