-- Since when nothing of a job waits or runs any more, as far as that was looked at: a Julian day.

ALTER TABLE jobs ADD COLUMN ended_at REAL;
