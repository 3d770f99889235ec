//! Samples of one block as they are taken: numbers as the simulation has them, moment by moment.

use crate::header::Fields;
use crate::units::SENSORS;

/// Room for the samples of a block, taken once and used again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raw {
    /// Number of the first sample.
    pub first: u64,
    /// Samples.
    pub count: usize,
    /// Robots of a sample.
    pub rows: usize,
    /// Objects of a sample.
    pub objects: usize,
    /// x and y in metres, cosine and sine of the heading.
    pub poses: Vec<[f32; 4]>,
    /// Wheel speeds at the first sample, rad/s.
    pub wheels_rad_s: Vec<[f32; 2]>,
    /// Commands, left and right.
    pub commands: Vec<[f32; 2]>,
    /// State and action, each one more than its number, 0 for none.
    pub decisions: Vec<[u16; 2]>,
    /// What the proximity sensors read.
    pub sensors: Vec<[f32; SENSORS]>,
    /// As for robots.
    pub object_poses: Vec<[f32; 4]>,
}

impl Raw {
    /// Room for so many samples of so many robots and objects.
    pub fn with_room(fields: Fields, samples: usize, rows: usize, objects: usize) -> Self {
        let of = |wanted: bool| if wanted { samples * rows } else { 0 };
        Self {
            first: 0,
            count: 0,
            rows,
            objects,
            poses: Vec::with_capacity(of(fields.pose)),
            wheels_rad_s: Vec::with_capacity(if fields.pose { rows } else { 0 }),
            commands: Vec::with_capacity(of(fields.command)),
            decisions: Vec::with_capacity(of(fields.decision)),
            sensors: Vec::with_capacity(of(fields.sensors)),
            object_poses: Vec::with_capacity(samples * objects),
        }
    }

    /// Forgets its samples and begins at one.
    pub fn begin(&mut self, first: u64) {
        self.first = first;
        self.count = 0;
        self.poses.clear();
        self.wheels_rad_s.clear();
        self.commands.clear();
        self.decisions.clear();
        self.sensors.clear();
        self.object_poses.clear();
    }

    /// Forgets the samples from one on.
    pub fn truncate(&mut self, count: usize) {
        if count >= self.count {
            return;
        }
        let robots = count * self.rows;
        self.count = count;
        self.poses.truncate(robots);
        if count == 0 {
            self.wheels_rad_s.clear();
        }
        self.commands.truncate(robots);
        self.decisions.truncate(robots);
        self.sensors.truncate(robots);
        self.object_poses.truncate(count * self.objects);
    }
}
