//! What evswarm's robots do under the load `kinematic/peers/N`, in the figures of the other
//! simulators' `--check`: distance moved, contact, what the sensors see. For one `WORLD.json STEPS`.
#![allow(clippy::print_stdout, reason = "the figures are the program's output")]

use std::sync::Arc;

use anyhow::{Context, Result, anyhow};
use arenas::Arena;
use loadtests::cases::Peer;
use swarm::placement::place;
use swarm::random::Site;
use swarm::robot::RobotModel;
use swarm::robot::response::SensorResponse;
use swarm::spec::{EngineKind, Placement};
use swarm::world::{Ground, World};

/// A lone robot goes back to its start after so many steps, as where it is measured.
const EPISODE: u64 = 2_000;

/// The distance that gives a value without noise; `None` for that of the range or beyond.
fn distance_m(response: &SensorResponse, value: f64) -> Option<f64> {
    response.rows().windows(2).find_map(|pair| {
        let (near, far) = (pair[0], pair[1]);
        (value > far.value + 1e-3).then(|| {
            let part = (near.value - value) / (near.value - far.value);
            near.distance_m + part.max(0.0) * (far.distance_m - near.distance_m)
        })
    })
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let (Some(path), Some(steps)) = (arguments.next(), arguments.next()) else {
        return Err(anyhow!("usage: peers_check WORLD.json STEPS"));
    };
    let steps: u64 = steps.parse().context("STEPS is a number")?;
    let text = std::fs::read_to_string(&path).with_context(|| format!("reading {path}"))?;
    let arena = Arc::new(Arena::from_json(&text).map_err(|errors| anyhow!("{errors:?}"))?);
    let robots = arena.starts().len();

    let mut model = RobotModel::default();
    model.parameters.sensor_noise = 0.0;
    let ground = Ground::new(Arc::clone(&arena), &model);
    let starts = place(
        &arena,
        &model,
        &ground.index,
        Placement::Start,
        robots as u32,
        1,
        Site::Target,
    )
    .map_err(|errors| anyhow!("{errors:?}"))?;
    let mut world = World::new(
        &ground,
        &model,
        EngineKind::Kinematic,
        starts,
        1,
        Site::Target,
    );
    world.set_counting(true);
    let mut controllers: Vec<Peer> = (0..robots as u64).map(Peer::new).collect();

    let (mut moved_m, mut ray_m, mut seen, mut rays) = (0.0, 0.0, 0_u64, 0_u64);
    let mut ways_m = vec![0.0_f64; robots];
    for step in 0..steps {
        if robots == 1 && step % EPISODE == 0 {
            world.reset();
        }
        let before: Vec<_> = places(&world).collect();
        world.advance(&mut controllers, 1);
        for ((from, to), way_m) in before.iter().zip(places(&world)).zip(&mut ways_m) {
            let way = f64::from((to[0] - from[0]).hypot(to[1] - from[1]));
            *way_m += way;
            moved_m += way;
        }
        for robot in 0..robots {
            for value in world.state().bodies[robot].reading.proximity {
                let distance = distance_m(&model.response, f64::from(value));
                ray_m += distance.unwrap_or(model.response.range_m());
                seen += u64::from(distance.is_some());
                rays += 1;
            }
        }
    }
    let robot_steps = (steps * robots as u64) as f64;
    println!(
        "moved_mm {:.3} contact {:.4} ray_mm {:.2} seen {:.4} still {}",
        1e3 * moved_m / robot_steps,
        world.state().collisions as f64 / robot_steps,
        1e3 * ray_m / rays as f64,
        seen as f64 / rays as f64,
        ways_m.iter().filter(|&&way_m| way_m < 0.001).count(),
    );
    Ok(())
}

fn places(world: &World) -> impl Iterator<Item = [f32; 2]> + '_ {
    let bodies = &world.state().bodies;
    (0..world.robots()).map(|robot| [bodies[robot].x_m, bodies[robot].y_m])
}
