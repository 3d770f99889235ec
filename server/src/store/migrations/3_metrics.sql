-- Swarm metrics over time, and what a robot-step cost; neither is known of older results.

-- What a job varied: axes with their values, and the number of seeds, as JSON.

ALTER TABLE jobs ADD COLUMN design TEXT;
ALTER TABLE results ADD COLUMN metrics BLOB;
ALTER TABLE results ADD COLUMN cpu_ns_per_robot_step REAL;
