-- Movable objects over time; null where the arena has none, and in older results.

ALTER TABLE results ADD COLUMN objects BLOB;
