-- What a run waits for that is held and was not asked to pause, and whether it goes on as soon as the
-- programs that steer it are there.
ALTER TABLE runs ADD COLUMN waits_for TEXT;
ALTER TABLE runs ADD COLUMN awaits_controllers INTEGER NOT NULL DEFAULT 0;
