//! Movable objects: seen where they are, pushed, never lost.

use super::super::object_grid::ObjectGrid;
use super::*;
use crate::bodies::{Reading, Shape};
use crate::lanes::F8;

/// A room of 1 m with these objects and a start at its centre.
fn room(objects: &str, model: &RobotModel) -> Ground {
    let json = format!(
        r#"{{"name":"room","width_m":1,"height_m":1,"walls_m":[],
        "starts":[{{"x_m":0.5,"y_m":0.5,"heading_rad":0}}],"objects":[{objects}]}}"#
    );
    Ground::new(Arc::new(Arena::from_json(&json).unwrap()), model)
}

struct Ahead;

impl Controller for Ahead {
    fn act(&mut self, _: u64, _: &Reading) -> [f32; 2] {
        [1.0; 2]
    }
    fn learn(&mut self, _: &Reading) {}
}

/// Whether a point is inside an object at a pose.
fn is_inside(object: &arenas::Movable, pose: &ObjectPose, x: f64, y: f64) -> bool {
    let (dx, dy) = (x - f64::from(pose.x_m), y - f64::from(pose.y_m));
    let (cos, sin) = (f64::from(pose.cos), f64::from(pose.sin));
    match object.half_sides_m() {
        Some([a, b]) => (cos * dx + sin * dy).abs() <= a && (cos * dy - sin * dx).abs() <= b,
        None => dx.hypot(dy) <= object.reach_m(),
    }
}

#[test]
fn boxes_and_discs_are_seen_at_their_distance() {
    let model = quiet();
    let range_m = model.response.range_m();
    let mut stream = Stream::new(8);
    for case in 0..200 {
        let bearing = std::f64::consts::TAU * stream.uniform();
        let far = 0.085 + 0.06 * stream.uniform();
        let (x, y) = (0.5 + far * bearing.cos(), 0.5 + far * bearing.sin());
        let turn = 6.0 * stream.uniform();
        let object = if case % 2 == 0 {
            format!(r#"{{"kind":"disc","x_m":{x},"y_m":{y},"radius_m":0.03}}"#)
        } else {
            format!(
                r#"{{"kind":"box","x_m":{x},"y_m":{y},"heading_rad":{turn},"width_m":0.06,"height_m":0.04}}"#
            )
        };
        let ground = room(&object, &model);
        let heading = std::f64::consts::TAU * stream.uniform();
        let start = vec![at(0.5, 0.5, heading)];
        let world = world(&ground, &model, EngineKind::Rapier, start);
        let (object, pose) = (ground.arena.objects()[0], world.state().objects.poses[0]);
        for (k, mount) in model.mounts.iter().enumerate() {
            let (c, s) = (heading.cos(), heading.sin());
            let origin = (
                0.5 + c * mount.x_m - s * mount.y_m,
                0.5 + s * mount.x_m + c * mount.y_m,
            );
            let angle = heading + mount.heading_rad;
            // The oracle walks along the ray.
            let step_m = 2e-5;
            let walk = (0..(range_m / step_m) as u32).map(|n| f64::from(n) * step_m);
            let mut walk =
                walk.map(|d| (d, origin.0 + d * angle.cos(), origin.1 + d * angle.sin()));
            let hit = walk.find(|&(_, x, y)| is_inside(&object, &pose, x, y));
            let distance = hit.map_or(range_m, |(distance, ..)| distance);
            let expected = model.response.at(distance * model.parameters.ray_stretch).0;
            let seen = f64::from(world.state().bodies[0].reading.proximity[k]);
            assert!(
                (seen - expected).abs() < 0.01 * expected + 6.0,
                "case {case} ps{k}: {seen} {expected}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_grid_shows_all_that_a_full_scan_shows(key: u64, count in 1_usize..60, large in 0_usize..4) {
        let mut stream = Stream::new(key);
        // Places in the arena file stand apart; where objects are is decided below.
        let objects: Vec<String> = (0..count).map(|number| {
            let (x, y) = (0.8 + 1.2 * (number % 8) as f64, 0.8 + 1.2 * (number / 8) as f64);
            let size = if number < large { 1.0 } else { 0.02 + 0.08 * stream.uniform() };
            match number % 2 {
                0 => format!(r#"{{"kind":"disc","x_m":{x},"y_m":{y},"radius_m":{}}}"#, 0.5 * size),
                _ => format!(r#"{{"kind":"box","x_m":{x},"y_m":{y},"width_m":{size},"height_m":0.03}}"#),
            }
        }).collect();
        let json = format!(
            r#"{{"name":"hall","width_m":11,"height_m":11,"walls_m":[],
            "starts":[{{"x_m":0.1,"y_m":0.1,"heading_rad":0}}],"objects":[{}]}}"#,
            objects.join(",")
        );
        let arena = Arena::from_json(&json).unwrap();
        let optics = Optics::new(&quiet());
        let shapes = Shape::all(&arena);
        let mut grid = ObjectGrid::new(&arena, optics.sight_m());
        let bytes = grid.bytes();
        // A corner of the hall, so that objects are near each other, or all of it.
        let side = if key % 2 == 0 { 1.0 } else { 11.0 };
        let mut poses: Vec<ObjectPose> = arena.objects().iter().map(ObjectPose::of).collect();
        let mut met = 0;
        for round in 0..40 {
            for pose in &mut poses {
                let turn = std::f64::consts::TAU * stream.uniform();
                (pose.cos, pose.sin) = (turn.cos() as f32, turn.sin() as f32);
                // Mostly little ways, as between two steps; now and then all are put elsewhere.
                let way = if round % 10 == 0 { side } else { 0.02 };
                let mut go = |from: f32| match round % 10 {
                    0 => (side * stream.uniform()) as f32,
                    _ => (f64::from(from) + way * (stream.uniform() - 0.5)).clamp(0.0, 11.0) as f32,
                };
                (pose.x_m, pose.y_m) = (go(pose.x_m), go(pose.y_m));
            }
            grid.update(&poses);
            for _ in 0..60 {
                let (x, y) = ((side * stream.uniform()) as f32, (side * stream.uniform()) as f32);
                let turn = std::f64::consts::TAU * stream.uniform();
                let rays = optics.rays(x, y, turn.cos() as f32, turn.sin() as f32);
                let far = F8::splat(10.0);
                let seen = grid.see(&optics, &poses, &rays, (x, y), far);
                let mut expected = far;
                for (number, pose) in poses.iter().enumerate() {
                    let sight_m = optics.sight_m() as f32 + shapes[number].reach_m();
                    expected = optics.to_object(&shapes[number], pose, sight_m, &rays, (x, y), expected);
                }
                prop_assert_eq!(seen.0.map(f32::to_bits), expected.0.map(f32::to_bits));
                met += usize::from(expected.0 != far.0);
            }
        }
        prop_assert!(met > 0 || side > 1.0 || count < 10);
        prop_assert_eq!(grid.bytes(), bytes, "lists outgrew their capacity");
    }
}

/// How far an object ahead of the robot gets in 60 steps, metres.
fn pushed(object: &str) -> f64 {
    let model = quiet();
    let ground = room(object, &model);
    let mut world = world(&ground, &model, EngineKind::Rapier, vec![at(0.5, 0.5, 0.0)]);
    world.set_counting(true);
    world.advance(&mut [Ahead], 60);
    let objects = &world.state().objects;
    let displaced_m = f64::from(objects.poses[0].x_m) - ground.arena.objects()[0].centre().x;
    assert!(objects.moved_m[0] >= displaced_m.abs() * 0.999);
    displaced_m
}

#[test]
fn a_robot_pushes_what_is_ahead_and_heavy_things_less() {
    let disc = |mass: f64| {
        pushed(&format!(
            r#"{{"kind":"disc","x_m":0.58,"y_m":0.5,"radius_m":0.04,"mass_kg":{mass}}}"#
        ))
    };
    let (light, heavy) = (disc(0.02), disc(1.0));
    assert!(light > 0.2 && heavy > 0.005, "light {light}, heavy {heavy}");
    assert!(heavy < 0.5 * light, "light {light}, heavy {heavy}");
    let boxed = |mass: f64| {
        pushed(&format!(
            r#"{{"kind":"box","x_m":0.58,"y_m":0.5,"width_m":0.06,"height_m":0.06,"mass_kg":{mass}}}"#
        ))
    };
    assert!(boxed(0.02) > 0.2 && boxed(1.0) < 0.5 * boxed(0.02));
}

#[test]
fn nothing_moves_by_itself_and_a_reset_puts_everything_back() {
    let model = quiet();
    let object = r#"{"kind":"box","x_m":0.7,"y_m":0.7,"heading_rad":0.3,"width_m":0.05,"height_m":0.05},
        {"kind":"disc","x_m":0.58,"y_m":0.5,"radius_m":0.04}"#;
    let ground = room(object, &model);
    let mut world = world(&ground, &model, EngineKind::Rapier, vec![at(0.5, 0.5, 0.0)]);
    let before = world.state().objects.poses.clone();
    world.advance(&mut [Ahead], 30);
    let after = world.state().objects.poses.clone();
    assert_eq!(after[0], before[0]);
    assert!(after[1].x_m > before[1].x_m + 0.05);
    assert_eq!(
        world.state().objects.moved_m,
        [0.0, 0.0],
        "visits do not count"
    );
    world.reset();
    assert_eq!(world.state().objects.poses, before);
}

/// Drives ahead for some steps, then stands.
struct AheadUntil(u64);

impl Controller for AheadUntil {
    fn act(&mut self, step: u64, _: &Reading) -> [f32; 2] {
        if step < self.0 { [1.0; 2] } else { [0.0; 2] }
    }
    fn learn(&mut self, _: &Reading) {}
}

#[test]
fn a_robot_that_bounces_far_away_does_not_change_how_an_object_glides() {
    let mut model = quiet();
    model.parameters.contact_bounce = 0.5;
    let disc =
        r#"{"kind":"disc","x_m":0.28,"y_m":0.3,"radius_m":0.04,"mass_kg":0.02,"friction":0}"#;
    let ground = room(disc, &model);
    let glide = |far_steps| {
        let starts = vec![at(0.2, 0.3, 0.0), at(0.95, 0.9, 0.0)];
        let mut world = world(&ground, &model, EngineKind::Rapier, starts);
        world.advance(&mut [AheadUntil(10), AheadUntil(far_steps)], 50);
        world.state().objects.poses[0]
    };
    let alone = glide(0);
    assert!(alone.x_m > 0.4, "{alone:?}");
    assert_eq!(alone, glide(50));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn objects_stay_in_the_arena_and_robots_out_of_them(key in any::<u64>(), stretch in 1_u64..60) {
        let model = RobotModel::default();
        let json = r#"{"name":"yard","width_m":0.6,"height_m":0.6,"walls_m":[[0.3,0,0.3,0.25]],
            "starts":[{"x_m":0.1,"y_m":0.1,"heading_rad":0}],"objects":[
            {"kind":"box","x_m":0.2,"y_m":0.2,"width_m":0.06,"height_m":0.04,"heading_rad":0.4},
            {"kind":"disc","x_m":0.4,"y_m":0.4,"radius_m":0.03,"mass_kg":0.02},
            {"kind":"box","x_m":0.45,"y_m":0.15,"width_m":0.05,"height_m":0.05,"mass_kg":0.3},
            {"kind":"disc","x_m":0.15,"y_m":0.45,"radius_m":0.02,"friction":0.0}]}"#;
        let ground = Ground::new(Arc::new(Arena::from_json(json).unwrap()), &model);
        let starts = crate::placement::place(
            &ground.arena, &model, &ground.index, crate::spec::Placement::Random, 6, key, Site::Target,
        ).unwrap();
        for start in &starts {
            for object in ground.arena.objects() {
                let place = nalgebra::Point2::new(f64::from(start.x_m), f64::from(start.y_m));
                prop_assert!(object.distance_m(place) >= model.parameters.body_radius_m);
            }
        }
        let mut world = world(&ground, &model, EngineKind::Rapier, starts);
        let mut controllers: Vec<_> = (0..6).map(|i| Bumper { key: key ^ i, stretch }).collect();
        for _ in 0..800 {
            world.advance(&mut controllers, 1);
            let state = world.state();
            for (object, pose) in ground.arena.objects().iter().zip(&state.objects.poses) {
                prop_assert!(pose.x_m > 0.0 && pose.x_m < 0.6 && pose.y_m > 0.0 && pose.y_m < 0.6);
                prop_assert!((pose.cos.hypot(pose.sin) - 1.0).abs() < 1e-3);
                for body in state.bodies.iter() {
                    let (x, y) = (f64::from(body.x_m), f64::from(body.y_m));
                    prop_assert!(!is_inside(object, pose, x, y), "a robot's centre is in a {}", object.kind());
                }
            }
        }
        let moved = world.state().objects.poses.iter().zip(ground.arena.objects());
        let moved = moved.filter(|(pose, object)| (f64::from(pose.x_m) - object.centre().x).abs() > 1e-3);
        prop_assert!(moved.count() > 0, "nothing was pushed");
    }
}
