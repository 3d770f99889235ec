-- Whether a run that is held goes on as soon as the programs that steer it are there.
ALTER TABLE runs ADD COLUMN awaits_controllers INTEGER NOT NULL DEFAULT 0;
