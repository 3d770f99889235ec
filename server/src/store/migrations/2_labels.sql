-- What of its job's matrix a run has, in words.

ALTER TABLE job_runs ADD COLUMN label TEXT NOT NULL DEFAULT '';
