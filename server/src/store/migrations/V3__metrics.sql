-- Swarm metrics over time, and what a robot-step cost; neither is known of older results.

ALTER TABLE results ADD COLUMN metrics BLOB;
ALTER TABLE results ADD COLUMN cpu_ns_per_robot_step REAL;
