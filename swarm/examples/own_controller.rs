//! A controller of one's own in a world: robots that turn away from what they see.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::sync::Arc;

use swarm::bodies::Reading;
use swarm::controllers::Controller;
use swarm::dimensions::WHEELS;
use swarm::placement::place;
use swarm::random::Site;
use swarm::robot::RobotModel;
use swarm::spec::{EngineKind, Placement};
use swarm::world::{Ground, World};

/// Drives on, turns away from what is beside it, and on the spot from what is ahead: always to the
/// same side, so that no corner holds it.
struct Avoider;

/// Raw value of something about 3 cm away.
const NEAR: f32 = 300.0;

impl Controller for Avoider {
    #[inline(always)]
    fn act(&mut self, _step: u64, reading: &Reading) -> [f32; WHEELS] {
        let [ahead_right, right, _, _, _, _, left, ahead_left] = reading.proximity;
        if ahead_right.max(ahead_left) > NEAR {
            return [-0.5, 0.5];
        }
        let speed = |beside: f32| 1.0 - 0.5 * (beside / NEAR).min(1.0);
        [speed(right), speed(left)]
    }

    /// What followed the move, for controllers that learn.
    #[inline(always)]
    fn learn(&mut self, _reading: &Reading) {}
}

/// Ten robots drive for 3,000 steps; how many squares they entered, and of how many.
pub fn drive() -> Result<(u32, u32), Box<dyn Error>> {
    const ROBOTS: u32 = 10;
    let (model, seed) = (RobotModel::default(), 1);
    let ground = Ground::new(
        Arc::new(arenas::builtin("maze").ok_or("no such arena")?),
        &model,
    );
    let starts = place(
        &ground.arena,
        &model,
        &ground.index,
        Placement::Random,
        ROBOTS,
        seed,
        Site::Target,
    )?;
    let mut world = World::new(
        &ground,
        &model,
        EngineKind::Kinematic,
        starts,
        seed,
        Site::Target,
    );
    let mut controllers: Vec<Avoider> = (0..ROBOTS).map(|_| Avoider).collect();
    world.set_counting(true);
    world.advance(&mut controllers, 3_000);
    let [entered, ..] = world.coverage();
    Ok((entered, world.entries().count() as u32))
}

/// Shows it.
pub fn main() -> Result<(), Box<dyn Error>> {
    let (entered, squares) = drive()?;
    println!("{entered} of {squares} squares were entered");
    Ok(())
}
