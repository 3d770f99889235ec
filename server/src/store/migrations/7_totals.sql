-- Sums over a job's runs by state, kept by triggers, so that a list need not count; and what a job
-- is in the middle of, which the next start ends.

ALTER TABLE jobs ADD COLUMN unfinished TEXT
    CHECK (unfinished IN ('creating', 'starting', 'settling', 'retrying', 'deleting'));

CREATE INDEX jobs_unfinished ON jobs (seq) WHERE unfinished IS NOT NULL;

CREATE TABLE job_totals (
    job               INTEGER NOT NULL REFERENCES jobs (seq) ON DELETE CASCADE,
    state             TEXT NOT NULL,
    runs              INTEGER NOT NULL,
    robot_steps_done  INTEGER NOT NULL,
    robot_steps_total INTEGER NOT NULL,
    work_done         INTEGER NOT NULL,
    work_total        INTEGER NOT NULL,
    PRIMARY KEY (job, state)
) STRICT, WITHOUT ROWID;

INSERT INTO job_totals
    SELECT job, state, count(*), sum(robot_steps_done), sum(robot_steps_total),
        sum(robot_steps_done * step_cost), sum(robot_steps_total * step_cost)
    FROM job_runs JOIN runs ON runs.seq = job_runs.run GROUP BY job, state;

CREATE TRIGGER job_runs_added AFTER INSERT ON job_runs BEGIN
    INSERT INTO job_totals
        SELECT NEW.job, state, 1, robot_steps_done, robot_steps_total,
            robot_steps_done * step_cost, robot_steps_total * step_cost
        FROM runs WHERE seq = NEW.run
    ON CONFLICT (job, state) DO UPDATE SET
        runs = runs + 1,
        robot_steps_done = robot_steps_done + excluded.robot_steps_done,
        robot_steps_total = robot_steps_total + excluded.robot_steps_total,
        work_done = work_done + excluded.work_done,
        work_total = work_total + excluded.work_total;
END;

CREATE TRIGGER job_runs_removed AFTER DELETE ON job_runs BEGIN
    UPDATE job_totals SET
        runs = runs - 1,
        robot_steps_done = robot_steps_done - gone.done,
        robot_steps_total = robot_steps_total - gone.total,
        work_done = work_done - gone.done * gone.cost,
        work_total = work_total - gone.total * gone.cost
    FROM (SELECT state AS gone_state, robot_steps_done AS done, robot_steps_total AS total,
            step_cost AS cost FROM runs WHERE seq = OLD.run) AS gone
    WHERE job = OLD.job AND state = gone.gone_state;
END;

CREATE TRIGGER runs_changed AFTER UPDATE OF state, robot_steps_done, robot_steps_total, step_cost ON runs
WHEN OLD.state <> NEW.state OR OLD.robot_steps_done <> NEW.robot_steps_done
    OR OLD.robot_steps_total <> NEW.robot_steps_total OR OLD.step_cost <> NEW.step_cost
BEGIN
    UPDATE job_totals SET
        runs = runs - 1,
        robot_steps_done = robot_steps_done - OLD.robot_steps_done,
        robot_steps_total = robot_steps_total - OLD.robot_steps_total,
        work_done = work_done - OLD.robot_steps_done * OLD.step_cost,
        work_total = work_total - OLD.robot_steps_total * OLD.step_cost
    WHERE state = OLD.state AND job IN (SELECT job FROM job_runs WHERE run = OLD.seq);
    INSERT INTO job_totals
        SELECT job, NEW.state, 1, NEW.robot_steps_done, NEW.robot_steps_total,
            NEW.robot_steps_done * NEW.step_cost, NEW.robot_steps_total * NEW.step_cost
        FROM job_runs WHERE run = NEW.seq
    ON CONFLICT (job, state) DO UPDATE SET
        runs = runs + 1,
        robot_steps_done = robot_steps_done + excluded.robot_steps_done,
        robot_steps_total = robot_steps_total + excluded.robot_steps_total,
        work_done = work_done + excluded.work_done,
        work_total = work_total + excluded.work_total;
END;
