//! The shape of a movable object, as sensors and contacts see it.

use arenas::{Arena, Movable};

/// An object's shape.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Half the sides of a box, none for a disc.
    pub(crate) half_sides_m: Option<[f32; 2]>,
    pub(crate) reach_m: f32,
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
}
