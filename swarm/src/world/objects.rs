//! Movable objects as robots see them, and how far each was moved.

use arenas::{Arena, Movable};
use serde::{Deserialize, Serialize};

use super::object_grid::ObjectGrid;
use crate::lanes::F8;
use crate::sense::{Optics, Rays};

/// Where an object is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectPose {
    /// Centre, metres.
    pub x_m: f32,
    /// Centre, metres.
    pub y_m: f32,
    /// Cosine of the heading.
    pub cos: f32,
    /// Sine of the heading.
    pub sin: f32,
}

impl ObjectPose {
    /// The pose at which an object begins.
    pub fn of(object: &Movable) -> Self {
        let centre = object.centre();
        Self {
            x_m: centre.x as f32,
            y_m: centre.y as f32,
            cos: libm::cos(object.heading_rad()) as f32,
            sin: libm::sin(object.heading_rad()) as f32,
        }
    }
}

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

/// An object's shape.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Half the sides of a box, none for a disc.
    half_sides_m: Option<[f32; 2]>,
    reach_m: f32,
}

impl Shape {
    /// The shapes of an arena's objects.
    pub fn all(arena: &Arena) -> Vec<Self> {
        let shape = |object: &Movable| Self {
            half_sides_m: object.half_sides_m().map(|half| half.map(|m| m as f32)),
            reach_m: object.reach_m() as f32,
        };
        arena.objects().iter().map(shape).collect()
    }

    /// Farthest that any part is from the centre, metres.
    pub fn reach_m(&self) -> f32 {
        self.reach_m
    }

    /// Shortens `best` by an object of this shape, if a robot at (x, y) can see it.
    #[inline(always)]
    pub(super) fn see(
        &self,
        optics: &Optics,
        pose: &ObjectPose,
        sight_m: f32,
        rays: &Rays,
        (x_m, y_m): (f32, f32),
        mut best: F8,
    ) -> F8 {
        let (dx_m, dy_m) = (pose.x_m - x_m, pose.y_m - y_m);
        if dx_m * dx_m + dy_m * dy_m > sight_m * sight_m {
            return best;
        }
        let Some([along, across]) = self.half_sides_m else {
            return optics.to_disc(rays, (pose.x_m, pose.y_m), self.reach_m, best);
        };
        let (ax, ay) = (along * pose.cos, along * pose.sin);
        let (bx, by) = (-across * pose.sin, across * pose.cos);
        let (x_m, y_m) = (pose.x_m, pose.y_m);
        let corners = [
            [x_m - ax - bx, y_m - ay - by],
            [x_m + ax - bx, y_m + ay - by],
            [x_m + ax + bx, y_m + ay + by],
            [x_m - ax + bx, y_m - ay + by],
        ];
        for side in 0..4 {
            best = optics.to_segment(rays, corners[side], corners[(side + 1) % 4], best);
        }
        best
    }
}

/// Shortens `best` by the objects that a robot at (x, y) can see; the grid is up to date.
pub fn see(
    optics: &Optics,
    (poses, grid): (&[ObjectPose], &ObjectGrid),
    rays: &Rays,
    (x_m, y_m): (f32, f32),
    mut best: F8,
) -> F8 {
    for &number in grid.near(x_m, y_m) {
        let pose = &poses[number as usize];
        let (shape, sight_m) = grid.shape(number as usize);
        best = shape.see(optics, pose, sight_m, rays, (x_m, y_m), best);
    }
    best
}
