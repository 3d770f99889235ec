//! What a run has found, at any step and at its end.

use sha2::{Digest, Sha256};

use super::coverage::{counts_over, counts_within};
use super::machine::Run;
use super::metrics::{MetricsLog, MetricsRow, RobotMetrics};
use super::outcome::{ObjectOutcome, Outcome};
use super::robot_memory::RobotMemory;
use super::tracks::{ObjectSample, Tracks, samples};
use super::venue::TARGET;
use crate::bodies::{Body, Objects};
use crate::metrics::{Counted, at_end};

impl Run {
    /// The metrics so far.
    pub fn metrics(&self) -> MetricsLog {
        let reachable = self.reachable();
        let state = self.venues[TARGET].world.state();
        let robot = |(body, memory): (&Body, RobotMemory)| RobotMetrics {
            first_entries: body.first_entries,
            distance_m: body.distance_m,
            memory,
        };
        let first_entry = state.tally.first_entry().iter().zip(&reachable.mask);
        MetricsLog {
            reachable: reachable.count,
            rows: self.metrics.clone(),
            robots: state.bodies.iter().zip(self.memory()).map(robot).collect(),
            first_entry: first_entry
                .map(|(&first, &inside)| if inside { first } else { 0 })
                .collect(),
        }
    }

    /// Rows of metrics so far.
    pub fn metrics_rows(&self) -> &[MetricsRow] {
        &self.metrics
    }

    /// The movable objects of the target arena over time; the last moment is the present one.
    pub fn tracks(&self) -> Tracks {
        let mut tracks = self.tracks.clone();
        let time = self.time();
        let objects = &self.venues[TARGET].world.state().objects;
        if !objects.poses.is_empty() && tracks.times.last().is_none_or(|l| l.steps != time.steps) {
            tracks.push(time, objects);
        }
        tracks
    }

    /// Movable objects of the arena that robots are in right now.
    pub fn objects_here(&self) -> &Objects {
        &self.venues[self.venue()].world.state().objects
    }

    /// What became of the movable objects of the target arena.
    pub fn objects(&self) -> Vec<ObjectOutcome> {
        let made = self.spec.arena.objects().iter();
        made.zip(samples(&self.venues[TARGET].world.state().objects))
            .map(|(object, ObjectSample { pose, moved_m })| {
                let (dx_m, dy_m) = (
                    f64::from(pose.x_m) - object.centre().x,
                    f64::from(pose.y_m) - object.centre().y,
                );
                ObjectOutcome {
                    kind: object.kind(),
                    pose,
                    moved_m,
                    displaced_m: (dx_m * dx_m + dy_m * dy_m).sqrt(),
                }
            })
            .collect()
    }

    /// What the run has to say, once all epochs are done.
    pub fn outcome(&self) -> Option<Outcome> {
        Some(self.end()?.0)
    }

    /// The outcome, and the [`Run::snapshot`] that goes with it.
    pub fn end(&self) -> Option<(Outcome, Vec<u8>)> {
        if self.stage().is_some() {
            return None;
        }
        let state = self.state();
        let state_sha256 = hex::encode(Sha256::digest(&state));
        let (sensor_clusters, actuator_clusters) = self.learners.clusters();
        let reachable = self.reachable();
        let outcome = Outcome {
            coverage: self.curve_row(self.spec.epochs),
            reachable: reachable.count,
            metrics: at_end(&Counted::new(&self.venues[TARGET].world, reachable)),
            coverage_reachable: counts_within(&self.visits(), &reachable.mask),
            dwell: counts_over(&self.dwell()),
            robot_steps: self.progress().robot_steps_done,
            collisions: self.venues[TARGET].world.state().collisions,
            sensor_clusters,
            actuator_clusters,
            sensori_motor_clusters: self
                .learners
                .sensori_motor_clusters()
                .unwrap_or(self.sensori_motor_clusters),
            model: self.model_accuracy(),
            bytes: self.bytes(),
            memory_plan: self.memory.clone(),
            memory: self.memory(),
            objects: self.objects(),
            state_sha256,
        };
        Some((outcome, self.snapshot_of(state)))
    }
}
