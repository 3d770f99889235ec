//! Tests of a world: geometry, sensing, engines.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod objects;

use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::bodies::Reading;
use crate::controllers::{Brownian, Controller};
use crate::random::{Stream, draw, unit};

/// Drives at random, in stretches, at full speed.
struct Bumper {
    key: u64,
    stretch: u64,
}

impl Controller for Bumper {
    fn act(&mut self, step: u64, _reading: &Reading) -> [f32; 2] {
        let bits = draw(self.key, step / self.stretch);
        [
            2.0 * unit(bits as u32) - 0.6,
            2.0 * unit((bits >> 32) as u32) - 0.6,
        ]
    }
    fn learn(&mut self, _reading: &Reading) {}
}

fn ground(name: &str, model: &RobotModel) -> Ground {
    Ground::new(Arc::new(arenas::builtin(name).unwrap()), model)
}

fn open(model: &RobotModel) -> Ground {
    let json = r#"{"name":"open","width_m":50,"height_m":50,"walls_m":[],
        "starts":[{"x_m":25,"y_m":25,"heading_rad":0}]}"#;
    Ground::new(Arc::new(Arena::from_json(json).unwrap()), model)
}

fn at(x_m: f64, y_m: f64, heading_rad: f64) -> StartPose {
    StartPose {
        x_m: x_m as f32,
        y_m: y_m as f32,
        cos: heading_rad.cos() as f32,
        sin: heading_rad.sin() as f32,
    }
}

fn world(ground: &Ground, model: &RobotModel, engine: EngineKind, starts: Vec<StartPose>) -> World {
    World::new(ground, model, engine, starts, 1, Site::Target)
}

/// No noise, no slip, no bounce.
fn quiet() -> RobotModel {
    let mut model = RobotModel::preset(crate::robot::Preset::Stepwise);
    model.parameters.sensor_noise = 0.0;
    model
}

/// Deepest penetration of any wall by any robot, metres, in f64 from the arena itself.
fn deepest_in_wall(world: &World, arena: &Arena, radius_m: f64) -> f64 {
    let state = world.state();
    let mut deepest = f64::NEG_INFINITY;
    for Body { x_m: x, y_m: y, .. } in state.bodies.iter() {
        let point = nalgebra::Point2::new(f64::from(*x), f64::from(*y));
        assert!(x.is_finite() && y.is_finite());
        for wall in arena.walls().iter().chain(&arena.boundary()) {
            deepest = deepest.max(radius_m - wall.distance_squared_m2(point).sqrt());
        }
        assert!(*x > 0.0 && *y > 0.0);
        assert!(f64::from(*x) < arena.width_m() && f64::from(*y) < arena.height_m());
    }
    deepest
}

/// Deepest overlap of two robots, metres.
fn deepest_overlap(world: &World, radius_m: f64) -> f64 {
    let state = world.state();
    let mut deepest = f64::NEG_INFINITY;
    for i in 0..state.bodies.len() {
        for j in 0..i {
            let dx = f64::from(state.bodies[i].x_m) - f64::from(state.bodies[j].x_m);
            let dy = f64::from(state.bodies[i].y_m) - f64::from(state.bodies[j].y_m);
            deepest = deepest.max(2.0 * radius_m - dx.hypot(dy));
        }
    }
    deepest
}

#[test]
fn hand_check_of_the_sensors() {
    let model = quiet();
    let json = r#"{"name":"room","width_m":0.6,"height_m":0.6,"walls_m":[],
        "starts":[{"x_m":0.3,"y_m":0.3,"heading_rad":0}]}"#;
    let ground = Ground::new(Arc::new(Arena::from_json(json).unwrap()), &model);
    let radius = model.parameters.body_radius_m;
    // A wall straight ahead, touching the body.
    let ahead = world(
        &ground,
        &model,
        EngineKind::Kinematic,
        vec![at(0.6 - radius, 0.3, 0.0)],
    );
    let seen = ahead.state().bodies[0].reading.proximity;
    assert_eq!(
        (seen[0].round(), seen[7].round()),
        (2862.0, 2862.0),
        "{seen:?}"
    );
    // A wall at right angles to each ray, touching the body.
    let expected = [
        3359.0, 3625.0, 3202.0, 3657.0, 3657.0, 3202.0, 3624.0, 3359.0,
    ];
    for (k, expected) in expected.iter().enumerate() {
        let heading = -model.mounts[k].heading_rad;
        let turned = world(
            &ground,
            &model,
            EngineKind::Kinematic,
            vec![at(0.6 - radius, 0.3, heading)],
        );
        let value = turned.state().bodies[0].reading.proximity[k];
        assert_eq!(value.round(), *expected, "ps{k}: {value}");
    }
    // Nothing in sight.
    let alone = world(
        &ground,
        &model,
        EngineKind::Kinematic,
        vec![at(0.3, 0.3, 0.3)],
    );
    assert!(
        alone.state().bodies[0]
            .reading
            .proximity
            .iter()
            .all(|v| (v - 34.0).abs() < 1e-3)
    );
}

/// Distance of a ray to the nearest wall or disc by the textbook formulas, in f64, over all walls.
fn brute_force_ray(
    arena: &Arena,
    others: &[(f64, f64)],
    radius_m: f64,
    origin: (f64, f64),
    direction: (f64, f64),
) -> f64 {
    let mut best = f64::INFINITY;
    for wall in arena.walls().iter().chain(&arena.boundary()) {
        let e = wall.b - wall.a;
        let det = direction.0 * e.y - direction.1 * e.x;
        let w = (wall.a.x - origin.0, wall.a.y - origin.1);
        let t = (w.0 * e.y - w.1 * e.x) / det;
        let u = (w.0 * direction.1 - w.1 * direction.0) / det;
        if t >= 0.0 && (0.0..=1.0).contains(&u) {
            best = best.min(t);
        }
    }
    for other in others {
        let r = (other.0 - origin.0, other.1 - origin.1);
        let along = r.0 * direction.0 + r.1 * direction.1;
        let gap2 = r.0 * r.0 + r.1 * r.1 - along * along;
        if gap2 < radius_m * radius_m && along > 0.0 {
            best = best.min((along - (radius_m * radius_m - gap2).sqrt()).max(0.0));
        }
    }
    best
}

#[test]
fn rays_agree_with_brute_force() {
    let model = quiet();
    for name in ["easy", "graph", "maze", "hard-maze"] {
        let ground = ground(name, &model);
        let start = ground.arena.starts()[0];
        let mut world = world(
            &ground,
            &model,
            EngineKind::Kinematic,
            vec![at(start.x_m, start.y_m, start.heading_rad)],
        );
        let mut controllers = [Bumper {
            key: 3,
            stretch: 40,
        }];
        let range = model.response.range_m();
        let mut differing = 0;
        for _ in 0..4_000 {
            world.advance(&mut controllers, 1);
            let state = world.state();
            let (x, y) = (
                f64::from(state.bodies[0].x_m),
                f64::from(state.bodies[0].y_m),
            );
            let (c, s) = (
                f64::from(state.bodies[0].cos),
                f64::from(state.bodies[0].sin),
            );
            for (k, mount) in model.mounts.iter().enumerate() {
                let origin = (
                    x + c * mount.x_m - s * mount.y_m,
                    y + s * mount.x_m + c * mount.y_m,
                );
                let (mc, ms) = (mount.heading_rad.cos(), mount.heading_rad.sin());
                let direction = (c * mc - s * ms, s * mc + c * ms);
                let distance =
                    brute_force_ray(&ground.arena, &[], 0.0, origin, direction).min(range);
                let expected = model.response.at(distance * model.parameters.ray_stretch).0;
                let seen = f64::from(state.bodies[0].reading.proximity[k]);
                // 250,000 raw a metre at the steepest: 2 raw are 8 micrometres.
                differing += u32::from((seen - expected).abs() > 2.0);
            }
        }
        // A ray may pass the very end of a wall on the other side for rounding.
        assert!(differing <= 3, "{name}: {differing} of 32,000 rays differ");
    }
}

#[test]
fn robots_are_seen_as_discs() {
    let model = quiet();
    let ground = open(&model);
    let mut stream = Stream::new(4);
    for _ in 0..300 {
        let (distance, bearing) = (
            0.075 + 0.1 * stream.uniform(),
            std::f64::consts::TAU * stream.uniform(),
        );
        let other = (
            25.0 + distance * bearing.cos(),
            25.0 + distance * bearing.sin(),
        );
        let heading = std::f64::consts::TAU * stream.uniform();
        let pair = world(
            &ground,
            &model,
            EngineKind::Kinematic,
            vec![at(25.0, 25.0, heading), at(other.0, other.1, 0.0)],
        );
        for (k, mount) in model.mounts.iter().enumerate() {
            let (c, s) = (heading.cos(), heading.sin());
            let origin = (
                25.0 + c * mount.x_m - s * mount.y_m,
                25.0 + s * mount.x_m + c * mount.y_m,
            );
            let angle = heading + mount.heading_rad;
            let expected = brute_force_ray(
                &ground.arena,
                &[other],
                model.parameters.body_radius_m,
                origin,
                (angle.cos(), angle.sin()),
            );
            let expected = model.response.at(expected * model.parameters.ray_stretch).0;
            let seen = f64::from(pair.state().bodies[0].reading.proximity[k]);
            assert!(
                (seen - expected).abs() < 0.01 * expected + 3.0,
                "ps{k} {seen} {expected}"
            );
        }
    }
}

#[test]
fn engines_agree_in_free_motion() {
    let model = quiet();
    let ground = open(&model);
    let run = |engine| {
        let mut world = world(&ground, &model, engine, vec![at(25.0, 25.0, 0.5)]);
        let mut controllers = [Bumper {
            key: 9,
            stretch: 15,
        }];
        let mut path = Vec::new();
        for _ in 0..1_000 {
            world.advance(&mut controllers, 1);
            let state = world.state();
            path.push((
                f64::from(state.bodies[0].x_m),
                f64::from(state.bodies[0].y_m),
            ));
        }
        path
    };
    for (a, b) in run(EngineKind::Kinematic)
        .iter()
        .zip(run(EngineKind::Rapier))
    {
        assert!((a.0 - b.0).hypot(a.1 - b.1) < 1e-6, "{a:?} {b:?}");
    }
}

#[test]
fn engines_agree_statistically_in_contact() {
    let model = RobotModel::default();
    let ground = ground("easy", &model);
    let start = ground.arena.starts()[0];
    let coverage = |engine| {
        let starts = vec![at(start.x_m, start.y_m, start.heading_rad)];
        let mut world = world(&ground, &model, engine, starts);
        world.set_counting(true);
        let mut controllers = [Bumper {
            key: 2,
            stretch: 25,
        }];
        for _ in 0..20 {
            world.reset();
            world.advance(&mut controllers, 2_000);
        }
        (
            f64::from(world.coverage()[0]),
            world.state().collisions as f64 / 40_000.0,
        )
    };
    let (kinematic, rapier) = (
        coverage(EngineKind::Kinematic),
        coverage(EngineKind::Rapier),
    );
    assert!(
        (kinematic.0 / rapier.0 - 1.0).abs() < 0.2,
        "squares {kinematic:?} {rapier:?}"
    );
    assert!(
        (kinematic.1 - rapier.1).abs() < 0.15,
        "contact share {kinematic:?} {rapier:?}"
    );
}

#[test]
fn slides_along_a_wall_as_friction_says() {
    for (friction, expected) in [(0.0, 1.0), (0.5, 0.5), (1.0, 0.0)] {
        let mut model = quiet();
        model.parameters.contact_friction = friction;
        let ground = open(&model);
        let start = at(
            25.0,
            50.0 - model.parameters.body_radius_m,
            std::f64::consts::FRAC_PI_4,
        );
        let mut world = world(&ground, &model, EngineKind::Kinematic, vec![start]);
        struct Ahead;
        impl Controller for Ahead {
            fn act(&mut self, _: u64, _: &Reading) -> [f32; 2] {
                [1.0; 2]
            }
            fn learn(&mut self, _: &Reading) {}
        }
        world.advance(&mut [Ahead], 12);
        let before = world.state().bodies[0].x_m;
        world.advance(&mut [Ahead], 20);
        let way = f64::from(world.state().bodies[0].x_m - before);
        let free = 20.0 * model.max_step_m() * std::f64::consts::FRAC_1_SQRT_2;
        assert!(
            (way / free - expected).abs() < 0.01,
            "friction {friction}: {}",
            way / free
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn never_inside_a_wall_whatever_the_commands(
        key in any::<u64>(),
        stretch in 1_u64..60,
        friction in prop_oneof![Just(0.0), Just(0.5), Just(1.0), Just(3.0)],
        bounce in prop_oneof![Just(0.0), Just(0.5), Just(1.0)],
        name in prop_oneof![Just("easy"), Just("graph"), Just("maze"), Just("hard-maze")],
    ) {
        let mut model = RobotModel::default();
        model.parameters.contact_friction = friction;
        model.parameters.contact_bounce = bounce;
        let ground = ground(name, &model);
        let start = ground.arena.starts()[0];
        let starts = vec![at(start.x_m, start.y_m, start.heading_rad)];
        let mut world = world(&ground, &model, EngineKind::Kinematic, starts);
        let mut controllers = [Bumper { key, stretch }];
        for _ in 0..3_000 {
            world.advance(&mut controllers, 1);
            let deepest = deepest_in_wall(&world, &ground.arena, model.parameters.body_radius_m);
            prop_assert!(deepest < 1.1e-5, "{deepest}");
        }
    }

    #[test]
    fn robots_never_overlap_nor_enter_walls(
        key in any::<u64>(),
        stretch in 1_u64..40,
        friction in prop_oneof![Just(0.0), Just(1.0)],
    ) {
        let mut model = RobotModel::default();
        model.parameters.contact_friction = friction;
        let ground = ground("easy", &model);
        let starts = crate::placement::place(
            &ground.arena, &model, &ground.index, crate::spec::Placement::Random, 18, key, Site::Target,
        ).unwrap();
        let mut world = world(&ground, &model, EngineKind::Kinematic, starts);
        let mut controllers: Vec<_> = (0..18).map(|i| Bumper { key: key ^ i, stretch }).collect();
        for _ in 0..600 {
            world.advance(&mut controllers, 1);
            let overlap = deepest_overlap(&world, model.parameters.body_radius_m);
            prop_assert!(overlap < 1e-4, "overlap {overlap}");
            let deepest = deepest_in_wall(&world, &ground.arena, model.parameters.body_radius_m);
            prop_assert!(deepest < 1.1e-5, "wall {deepest}");
        }
    }
}

#[test]
fn portable_and_avx2_give_the_same_bits_over_100_000_steps() {
    let model = RobotModel::default();
    let ground = ground("maze", &model);
    let start = ground.arena.starts()[0];
    let run = |backend| {
        let starts = vec![at(start.x_m, start.y_m, start.heading_rad)];
        let mut world = world(&ground, &model, EngineKind::Kinematic, starts);
        world.set_backend(backend);
        world.set_counting(true);
        let mut controllers = [Brownian::new(6)];
        world.advance(&mut controllers, 100_000);
        (
            world.state().bodies[0].x_m.to_bits(),
            world.state().bodies[0].sin.to_bits(),
            world.state().bodies[0].reading.proximity.map(f32::to_bits),
            world.visits(),
        )
    };
    assert!(run(Backend::Portable) == run(Backend::detect()));
}

/// Deepest overlap of robots and deepest way into a wall over a million random robot-steps of a
/// dense crowd, metres, looked at after every step.
fn deepest_in_a_million_robot_steps(engine: EngineKind) -> (f64, f64) {
    let model = RobotModel::default();
    let json = r#"{"name":"crowd","width_m":1.5,"height_m":1.5,"walls_m":[[0.75,0.3,0.75,1.2]],
        "starts":[{"x_m":0.1,"y_m":0.1,"heading_rad":0}]}"#;
    let ground = Ground::new(Arc::new(Arena::from_json(json).unwrap()), &model);
    let random = crate::spec::Placement::Random;
    let starts = crate::placement::place(
        &ground.arena,
        &model,
        &ground.index,
        random,
        100,
        5,
        Site::Target,
    )
    .unwrap();
    let mut world = world(&ground, &model, engine, starts);
    let mut controllers: Vec<_> = (0..100).map(|key| Bumper { key, stretch: 20 }).collect();
    let radius_m = model.parameters.body_radius_m;
    let (mut overlap_m, mut wall_m) = (0.0_f64, 0.0_f64);
    for _ in 0..10_000 {
        world.advance(&mut controllers, 1);
        overlap_m = overlap_m.max(deepest_overlap(&world, radius_m));
        wall_m = wall_m.max(deepest_in_wall(&world, &ground.arena, radius_m));
    }
    (overlap_m, wall_m)
}

#[test]
fn a_dense_crowd_neither_overlaps_nor_leaves_over_a_million_robot_steps() {
    let (overlap_m, wall_m) = deepest_in_a_million_robot_steps(EngineKind::Kinematic);
    assert!(overlap_m < 1e-4, "overlap {overlap_m}");
    assert!(wall_m < 1.1e-5, "wall {wall_m}");
}

#[test]
fn a_rigid_crowd_neither_overlaps_nor_leaves_over_a_million_robot_steps() {
    let (overlap_m, wall_m) = deepest_in_a_million_robot_steps(EngineKind::Rapier);
    assert!(overlap_m < 1e-4, "overlap {overlap_m}");
    assert!(wall_m < 1e-4, "wall {wall_m}");
}
