-- Results have a version, that of the simulation they come from, and a digest. Blobs get envelopes
-- with versions and digests (see the hook of this migration).

ALTER TABLE runs ADD COLUMN results_version INTEGER NOT NULL DEFAULT 1;
ALTER TABLE results ADD COLUMN result_sha256 BLOB;
