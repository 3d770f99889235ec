//! What is measured: each case sets up its robots once and is then stepped in chunks.

use std::sync::Arc;

use anyhow::{Context, Result, anyhow};
use arenas::{Arena, Tiling};
use swarm::bodies::Reading;
use swarm::controllers::{Brownian, Controller};
use swarm::crew::Crew;
use swarm::placement::place;
use swarm::random::{Purpose, Site, draw, stream_key, unit};
use swarm::robot::RobotModel;
use swarm::run::{Phase, Run};
use swarm::spec::{
    ControllerParameters, ControllerSpec, EngineKind, Episodes, Method, Placement, RunSpec,
    Sharing, Training,
};
use swarm::world::{Ground, World};

/// Steps that are taken in one go, on some threads.
pub type Chunk = Box<dyn FnMut(u64, &Crew) -> u64>;

/// One row of the table.
pub struct Case {
    /// Stable name, for comparison with earlier figures.
    pub name: String,
    /// Goal, microseconds a robot-step.
    pub goal_us: Option<f64>,
    /// Stretch goal, microseconds a robot-step.
    pub stretch_us: Option<f64>,
    /// Robots, for the step counts of a chunk.
    pub robots: u64,
    /// Part of the standard table; the others need `--full`.
    pub standard: bool,
    /// Makes the chunk: called with arena steps, answers robot-steps done.
    pub setup: Box<dyn Fn() -> Result<Setup>>,
}

/// A case ready to be stepped.
pub struct Setup {
    /// Steps the case on.
    pub chunk: Chunk,
    /// Bytes held a robot, index excluded, where counted.
    pub bytes_per_robot: Option<u64>,
}

/// The load of the other simulators' figures: new random speeds each step, mostly forward.
pub struct Peer {
    key: u64,
}

impl Peer {
    /// The robot of this number.
    pub fn new(key: u64) -> Self {
        Self { key }
    }
}

impl Controller for Peer {
    #[inline(always)]
    fn act(&mut self, step: u64, _reading: &Reading) -> [f32; 2] {
        let bits = draw(self.key, step);
        let speed = |bits: u32| 1.4 * unit(bits) - 0.4;
        [speed(bits as u32), speed((bits >> 32) as u32)]
    }

    #[inline(always)]
    fn learn(&mut self, _reading: &Reading) {}
}

fn builtin(name: &str) -> Result<Arc<Arena>> {
    arenas::builtin(name)
        .map(Arc::new)
        .with_context(|| format!("no built-in arena `{name}`"))
}

fn refused<E: std::fmt::Debug>(errors: E) -> anyhow::Error {
    anyhow!("{errors:?}")
}

/// A world of a peer benchmark.
fn peer_arena(robots: u64) -> Result<Arc<Arena>> {
    let text = match robots {
        1 => include_str!("../worlds/world-1.json"),
        10 => include_str!("../worlds/world-10.json"),
        100 => include_str!("../worlds/world-100.json"),
        1_000 => include_str!("../worlds/world-1000.json"),
        _ => include_str!("../worlds/world-10000.json"),
    };
    Ok(Arc::new(Arena::from_json(text).map_err(refused)?))
}

/// Square metres a robot in the scaling cases, as in the peers' worlds.
const AREA_PER_ROBOT_M2: f64 = 0.036;

/// A square arena with room for `robots` robots and a short wall for every five.
pub fn scaled_arena(robots: u64) -> Result<Arc<Arena>> {
    let side_m = (robots as f64 * AREA_PER_ROBOT_M2).sqrt().max(0.19);
    let mut walls = Vec::new();
    let mut number = 0;
    while walls.len() < (robots / 5) as usize {
        number += 1;
        let at = |k: u64| unit(draw(77, number * 4 + k) as u32) as f64;
        let (x, y, angle) = (
            at(0) * side_m,
            at(1) * side_m,
            at(2) * std::f64::consts::TAU,
        );
        let (bx, by) = (x + 0.1 * angle.cos(), y + 0.1 * angle.sin());
        if bx > 0.0 && by > 0.0 && bx < side_m && by < side_m {
            walls.push([x, y, bx, by]);
        }
    }
    // The single start is a corner; robots are placed at random.
    let walls: Vec<_> = walls
        .into_iter()
        .filter(|w| w[0].hypot(w[1]) > 0.3)
        .collect();
    let text = serde_json::json!({
        "name": format!("scaled-{robots}"), "width_m": side_m, "height_m": side_m,
        "walls_m": walls, "starts": [{"x_m": 0.06, "y_m": 0.06, "heading_rad": 0.8}],
    });
    Ok(Arc::new(
        Arena::from_json(&text.to_string()).map_err(refused)?,
    ))
}

/// So many columns and rows of the built-in arena `easy`, open to each other: 0.036 m2 a robot where
/// a tile has ten.
fn tiled(along: u32) -> Result<Arc<Arena>> {
    let tiling = Tiling {
        tile: [along, along],
        // An arena has at most 1,000 squares a side.
        squares: (along > 10).then_some([20, 20]),
        ..Tiling::default()
    };
    Ok(Arc::new(builtin("easy")?.tiled(&tiling).map_err(refused)?))
}

/// Robots that learn by themselves, with little to prepare.
fn im_spec(arena: Arc<Arena>, robots: u64) -> Result<RunSpec> {
    let mut spec = run_spec(Method::Im, arena, robots, EngineKind::Kinematic)?;
    spec.controller.parameters.babbling_epochs = 1;
    spec.steps_per_epoch = 500;
    spec.controller.parameters.sample = 1_024;
    Ok(spec)
}

/// Side of the yard with objects, metres, and objects along it.
const YARD_M: f64 = 6.0;
const OBJECTS_ALONG: u32 = 32;

/// A yard with so many boxes and discs, evenly spread.
fn yard(objects: u32) -> Result<Arc<Arena>> {
    let places = OBJECTS_ALONG * OBJECTS_ALONG;
    let objects: Vec<_> = (0..objects)
        .map(|number| {
            let place = number * places / objects;
            let at = |k: u32| (f64::from(k) + 0.5) * YARD_M / f64::from(OBJECTS_ALONG);
            let (x_m, y_m) = (at(place % OBJECTS_ALONG), at(place / OBJECTS_ALONG));
            if number % 2 == 0 {
                serde_json::json!({ "kind": "disc", "x_m": x_m, "y_m": y_m, "radius_m": 0.03 })
            } else {
                serde_json::json!({ "kind": "box", "x_m": x_m, "y_m": y_m, "heading_rad": 0.5,
                    "width_m": 0.06, "height_m": 0.04 })
            }
        })
        .collect();
    let text = serde_json::json!({
        "name": "yard", "width_m": YARD_M, "height_m": YARD_M, "walls_m": [], "objects": objects,
        "starts": [{"x_m": 0.18, "y_m": 0.18, "heading_rad": 0.8}],
    });
    Ok(Arc::new(
        Arena::from_json(&text.to_string()).map_err(refused)?,
    ))
}

fn world(
    arena: &Arc<Arena>,
    robots: u64,
    placement: Placement,
    engine: EngineKind,
) -> Result<World> {
    let model = RobotModel::default();
    let ground = Ground::new(Arc::clone(arena), &model);
    let starts = place(
        arena,
        &model,
        &ground.index,
        placement,
        robots as u32,
        1,
        Site::Target,
    )
    .map_err(refused)?;
    let mut world = World::new(&ground, &model, engine, starts, 1, Site::Target);
    world.set_counting(true);
    Ok(world)
}

fn stepped<P: Controller + 'static>(mut world: World, mut controllers: Vec<P>) -> Setup {
    let robots = controllers.len() as u64;
    let bytes_per_robot = Some((world.bytes() / controllers.len()) as u64);
    Setup {
        bytes_per_robot,
        chunk: Box::new(move |steps, crew| {
            world.set_crew(crew);
            let mut left = steps;
            while left > 0 {
                let block = left.min(2_000);
                if robots == 1 {
                    world.reset();
                }
                world.advance(&mut controllers, block);
                left -= block;
            }
            steps * robots
        }),
    }
}

fn brownians(robots: u64) -> Vec<Brownian> {
    (0..robots)
        .map(|robot| Brownian::new(stream_key(1, Site::Target, robot, Purpose::Action)))
        .collect()
}

fn run_spec(method: Method, arena: Arc<Arena>, robots: u64, engine: EngineKind) -> Result<RunSpec> {
    Ok(RunSpec {
        seed: 1,
        arena,
        controller: ControllerSpec {
            method,
            parameters: ControllerParameters::default(),
            own: Default::default(),
            training: Some(Training {
                arena: builtin("easy")?,
                epochs: 20,
            }),
        },
        epochs: 1_000_000,
        steps_per_epoch: 2_000,
        robots: robots as u32,
        placement: if robots == 1 {
            Placement::Start
        } else {
            Placement::Random
        },
        episodes: Episodes::Reset,
        robot: RobotModel::default(),
        engine,
        memory_budget_bytes: None,
        sharing: Sharing::None,
    })
}

/// A run stepped from the moment its exploration begins.
fn exploring(spec: RunSpec) -> Result<Setup> {
    let robots = u64::from(spec.robots);
    let mut run = spec.validate().and_then(Run::new).map_err(refused)?;
    while run.progress().phase != Phase::Exploration {
        run.advance(1_000);
    }
    Ok(Setup {
        bytes_per_robot: Some(run.bytes() / robots),
        chunk: Box::new(move |steps, crew| {
            run.set_crew(crew.clone());
            run.advance(steps);
            steps * robots
        }),
    })
}

/// Phase 1 of Ev-ITER alone, as long as anyone cares to measure.
fn evolving(arena: Arc<Arena>) -> Result<Setup> {
    let mut spec = run_spec(
        Method::EvIterC,
        Arc::clone(&arena),
        1,
        EngineKind::Kinematic,
    )?;
    spec.controller.training = Some(Training {
        arena,
        epochs: 1_000_000,
    });
    let mut run = spec.validate().and_then(Run::new).map_err(refused)?;
    run.advance(100_000);
    Ok(Setup {
        bytes_per_robot: Some(run.bytes()),
        chunk: Box::new(move |steps, _| {
            run.advance(steps);
            steps
        }),
    })
}

fn case(
    name: impl Into<String>,
    robots: u64,
    goals: Option<(f64, f64)>,
    setup: impl Fn() -> Result<Setup> + 'static,
) -> Case {
    Case {
        name: name.into(),
        goal_us: goals.map(|g| g.0),
        stretch_us: goals.map(|g| g.1),
        robots,
        standard: true,
        setup: Box::new(setup),
    }
}

/// Every case, in the order of the table.
pub fn all() -> Vec<Case> {
    use EngineKind::{Kinematic, Rapier};
    let mut cases = Vec::new();
    for name in ["easy", "maze"] {
        cases.push(case(
            format!("kinematic/1/{name}/brownian"),
            1,
            Some((0.25, 0.12)),
            move || {
                let world = world(&builtin(name)?, 1, Placement::Start, Kinematic)?;
                Ok(stepped(world, brownians(1)))
            },
        ));
        cases.push(case(
            format!("kinematic/1/{name}/phase-1"),
            1,
            Some((0.60, 0.30)),
            move || evolving(builtin(name)?),
        ));
        cases.push(case(
            format!("kinematic/1/{name}/phase-3"),
            1,
            Some((0.60, 0.30)),
            move || exploring(run_spec(Method::EvIterC, builtin(name)?, 1, Kinematic)?),
        ));
    }
    for robots in [1, 10, 100, 1_000, 10_000] {
        let stretch = if robots == 1 { 0.12 } else { 0.15 };
        cases.push(case(
            format!("kinematic/peers/{robots}"),
            robots,
            Some((0.30, stretch)),
            {
                move || {
                    let arena = peer_arena(robots)?;
                    let world = world(&arena, robots, Placement::Start, Kinematic)?;
                    let controllers = (0..robots).map(Peer::new).collect();
                    Ok(stepped(world, controllers))
                }
            },
        ));
    }
    for robots in [1, 10, 100, 1_000, 10_000, 100_000] {
        cases.push(case(
            format!("kinematic/swarm/{robots}/brownian"),
            robots,
            Some((0.35, 0.35)),
            {
                move || {
                    let arena = scaled_arena(robots)?;
                    let world = world(&arena, robots, Placement::Random, Kinematic)?;
                    Ok(stepped(world, brownians(robots)))
                }
            },
        ));
    }
    for robots in [1, 10, 100, 1_000, 10_000] {
        let mut learning = case(
            format!("kinematic/swarm/{robots}/im"),
            robots,
            Some((0.80, 0.40)),
            move || exploring(im_spec(scaled_arena(robots)?, robots)?),
        );
        learning.standard = robots <= 1_000;
        cases.push(learning);
    }
    cases.push(case("kinematic/tiled/1000/brownian", 1_000, None, || {
        let world = world(&tiled(10)?, 1_000, Placement::Random, Kinematic)?;
        Ok(stepped(world, brownians(1_000)))
    }));
    let mut learning = case("kinematic/tiled/10000/im", 10_000, None, || {
        exploring(im_spec(tiled(32)?, 10_000)?)
    });
    learning.standard = false;
    cases.push(learning);
    cases.push(case("kinematic/1/easy/curiosity", 1, None, || {
        exploring(run_spec(Method::Curiosity, builtin("easy")?, 1, Kinematic)?)
    }));
    cases.push(case("rapier/tiled/1000/brownian", 1_000, None, || {
        let world = world(&tiled(10)?, 1_000, Placement::Random, Rapier)?;
        Ok(stepped(world, brownians(1_000)))
    }));
    for name in ["easy", "maze"] {
        cases.push(case(
            format!("rapier/1/{name}/brownian"),
            1,
            Some((8.0, 5.5)),
            move || {
                let world = world(&builtin(name)?, 1, Placement::Start, Rapier)?;
                Ok(stepped(world, brownians(1)))
            },
        ));
        cases.push(case(
            format!("rapier/1/{name}/phase-3"),
            1,
            Some((8.0, 5.5)),
            move || exploring(run_spec(Method::EvIterC, builtin(name)?, 1, Rapier)?),
        ));
    }
    cases.push(case("rapier/peers/1", 1, Some((5.5, 5.5)), || {
        let world = world(&peer_arena(1)?, 1, Placement::Start, Rapier)?;
        Ok(stepped(world, vec![Peer::new(0)]))
    }));
    for robots in [1, 10, 100, 1_000, 10_000, 100_000] {
        let mut rigid = case(
            format!("rapier/swarm/{robots}/brownian"),
            robots,
            None,
            move || {
                let world = world(&scaled_arena(robots)?, robots, Placement::Random, Rapier)?;
                Ok(stepped(world, brownians(robots)))
            },
        );
        rigid.standard = robots == 1_000;
        cases.push(rigid);
    }
    for objects in [0, 100, 1_000] {
        // Objects are pushed by the rapier engine alone; the other shows what seeing them costs.
        for (name, engine) in [("objects", Rapier), ("objects-seen", Kinematic)] {
            let mut pushing = case(format!("{name}/{objects}/brownian"), 100, None, move || {
                let world = world(&yard(objects)?, 100, Placement::Random, engine)?;
                Ok(stepped(world, brownians(100)))
            });
            pushing.standard = false;
            cases.push(pushing);
        }
    }
    cases
}
