-- About how much a robot-step of a run costs against one of the kinematic engine, for estimates.

ALTER TABLE runs ADD COLUMN step_cost INTEGER NOT NULL DEFAULT 1;
