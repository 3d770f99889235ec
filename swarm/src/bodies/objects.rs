//! The movable objects of an arena: where they are, and how far each was moved.

use arenas::Arena;
use serde::{Deserialize, Serialize};

use super::pose::ObjectPose;

/// The part of all objects that is saved.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Objects {
    /// In the order of the arena's.
    pub poses: Vec<ObjectPose>,
    /// Way that each was moved while visits counted, metres.
    pub moved_m: Vec<f64>,
}

impl Objects {
    /// All at their beginning.
    pub fn new(arena: &Arena) -> Self {
        let poses: Vec<ObjectPose> = arena.objects().iter().map(ObjectPose::of).collect();
        Self {
            moved_m: vec![0.0; poses.len()],
            poses,
        }
    }

    /// Takes new poses; their ways count or not.
    pub fn follow(&mut self, poses: impl Iterator<Item = ObjectPose>, counting: bool) {
        for ((old, moved_m), new) in self.poses.iter_mut().zip(&mut self.moved_m).zip(poses) {
            let (dx_m, dy_m) = (new.x_m - old.x_m, new.y_m - old.y_m);
            if counting {
                *moved_m += f64::from((dx_m * dx_m + dy_m * dy_m).sqrt());
            }
            *old = new;
        }
    }

    /// Whether there are as many as in the arena.
    pub fn fits(&self, arena: &Arena) -> bool {
        let objects = arena.objects().len();
        self.poses.len() == objects && self.moved_m.len() == objects
    }
}
