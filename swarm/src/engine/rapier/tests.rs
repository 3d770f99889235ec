//! What the engine promises: the contact law, no way through walls, no memory beyond its bytes.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod crowd;

use super::*;
use crowd::*;

#[test]
fn free_motion_is_the_plain_sum() {
    for at in [0.3f32, 499.7] {
        let mut crowd = Crowd::at(&arena(1000.0, &[]), &model(1.0, 0.0), &[(at, at)], 1);
        let mut noise = Noise(3);
        let (mut x, mut y) = (at, at);
        for step in 0..1000 {
            let forth = if step % 2 == 0 { 1.0 } else { -1.0 };
            let (dx, dy) = (
                forth * TOP_STEP_M * noise.next(),
                forth * TOP_STEP_M * noise.next(),
            );
            (crowd.dx_m[0], crowd.dy_m[0]) = (dx, dy);
            crowd.engine_step();
            (x, y) = (x + dx, y + dy);
            assert_eq!(
                (crowd.x_m[0], crowd.y_m[0], crowd.touched[0]),
                (x, y, false),
                "step {step}"
            );
        }
    }
}

#[test]
fn slides_by_one_minus_friction_at_45_degrees() {
    for friction in [0.0, 0.25, 0.5, 1.0] {
        let start = (0.1, RADIUS_M as f32);
        let mut crowd = Crowd::at(&arena(2.0, &[]), &model(friction, 0.0), &[start], 1);
        let way = 0.005;
        (crowd.dx_m[0], crowd.dy_m[0]) = (way, -way);
        (0..20).for_each(|_| crowd.engine_step());
        let from = crowd.x_m[0];
        (0..100).for_each(|_| crowd.engine_step());
        let ratio = f64::from((crowd.x_m[0] - from) / (100.0 * way));
        assert!(
            (ratio - (1.0 - friction)).abs() < 0.01,
            "friction {friction}: {ratio}"
        );
        assert!(crowd.touched[0]);
    }
}

#[test]
fn bounces_off_a_wall_by_its_share_of_the_push() {
    for (friction, bounce) in [(0.0, 0.0), (0.0, 0.5), (1.0, 0.5), (0.0, 1.0)] {
        let start = (0.1, RADIUS_M as f32 + 0.004);
        let mut crowd = Crowd::at(&arena(2.0, &[]), &model(friction, bounce), &[start], 1);
        crowd.dy_m[0] = -0.008;
        crowd.engine_step();
        let clear_m = f64::from(crowd.y_m[0]) - RADIUS_M;
        assert!(
            (clear_m - 0.004 * bounce).abs() < 2e-5,
            "bounce {bounce}: {clear_m} m"
        );
        assert!(crowd.touched[0]);
    }
}

#[test]
fn an_elastic_hit_passes_the_motion_on() {
    let mut crowd = Crowd::at(
        &arena(2.0, &[]),
        &model(0.0, 1.0),
        &[(0.8, 1.0), (0.874, 1.0)],
        1,
    );
    crowd.dx_m[0] = 0.008;
    crowd.engine_step();
    assert!((crowd.x_m[0] - 0.8).abs() < 1e-4, "{}", crowd.x_m[0]);
    assert!((crowd.x_m[1] - 0.882).abs() < 1e-4, "{}", crowd.x_m[1]);
}

#[test]
fn never_goes_through_walls() {
    for (walls_m, places) in [
        (&EASY[..], [(0.1, 0.1), (0.5, 0.5)]),
        (&MAZE[..], [(0.07, 0.1), (0.52, 0.45)]),
    ] {
        let arena = arena(0.6, walls_m);
        let walls = all_walls(&arena);
        for friction in [0.0, 1.0] {
            for place in places {
                let mut crowd = Crowd::at(&arena, &model(friction, 0.0), &[place], 7);
                let mut touches = 0;
                for step in 0..20_000 {
                    let from = (crowd.x_m[0], crowd.y_m[0]);
                    crowd.wander();
                    let to = (crowd.x_m[0], crowd.y_m[0]);
                    touches += usize::from(crowd.touched[0]);
                    assert!(
                        !crosses(&walls, from, to),
                        "step {step}: {from:?} to {to:?}"
                    );
                    let depth_m = crowd.deepest_in_wall_m(&walls);
                    assert!(depth_m < 0.001, "step {step}: {depth_m} m deep at {to:?}");
                }
                assert!(touches > 2_000, "bumped only {touches} times");
            }
        }
    }
}

#[test]
fn robots_head_on_stop_each_other() {
    for gap in 0..40 {
        for offset in [0.0, 0.005, 0.02] {
            let places = [(0.8, 1.0), (0.95 + 0.001 * gap as f32, 1.0 + offset)];
            let mut crowd = Crowd::at(&arena(2.0, &[]), &model(1.0, 0.0), &places, 1);
            crowd.dx_m = vec![TOP_STEP_M, -TOP_STEP_M];
            let mut touches = 0;
            for _ in 0..60 {
                crowd.engine_step();
                touches += usize::from(crowd.touched[0] && crowd.touched[1]);
                assert!(
                    crowd.deepest_overlap_m() < 0.001,
                    "gap {gap}, offset {offset}"
                );
            }
            assert!(touches > 0);
        }
    }
}

#[test]
fn a_standing_robot_is_pushed_along() {
    let mut crowd = Crowd::at(
        &arena(2.0, &[]),
        &model(1.0, 0.0),
        &[(0.8, 1.0), (0.9, 1.0)],
        1,
    );
    crowd.dx_m[0] = TOP_STEP_M;
    (0..50).for_each(|_| crowd.engine_step());
    assert!(crowd.x_m[1] > 0.95 && crowd.touched == [true, true]);
}

#[test]
fn place_erases_history() {
    let arena = arena(0.6, &MAZE);
    let (starts, seed) = ([(0.07, 0.1), (0.07, 0.2), (0.52, 0.45)], 11);
    let mut fresh = Crowd::at(&arena, &model(0.5, 0.5), &starts, seed);
    let mut used = Crowd::at(&arena, &model(0.5, 0.5), &starts, seed);
    (0..777).for_each(|_| used.wander());
    let mut placed = Crowd::at(&arena, &model(0.5, 0.5), &starts, seed);
    std::mem::swap(&mut placed.engine, &mut used.engine);
    placed.engine.place(&placed.x_m, &placed.y_m);
    for step in 0..1000 {
        assert_eq!(fresh.bytes(), placed.bytes(), "step {step}");
        fresh.wander();
        placed.wander();
        assert_eq!(
            (&fresh.x_m, &fresh.y_m),
            (&placed.x_m, &placed.y_m),
            "step {step}"
        );
    }
}

#[test]
fn a_restored_engine_goes_on_bit_for_bit() {
    let arena = arena(0.6, &MAZE);
    for saved_after in [0, 1, 137, 500] {
        let mut kept = Crowd::random(&arena, &model(0.7, 0.5), 8, 5);
        let mut restored = Crowd::random(&arena, &model(0.7, 0.5), 8, 5);
        for _ in 0..saved_after {
            kept.wander();
            restored.wander();
        }
        let saved = kept.bytes();
        assert_eq!(saved, restored.bytes(), "same state, same bytes");
        restored.engine = postcard::from_bytes(&saved).unwrap();
        assert_eq!(saved, restored.bytes(), "restoring changes nothing");
        let mut touches = 0;
        for step in 0..2_000 {
            kept.wander();
            restored.wander();
            touches += kept.touched.iter().filter(|t| **t).count();
            assert_eq!(
                (&kept.x_m, &kept.y_m),
                (&restored.x_m, &restored.y_m),
                "step {step}"
            );
            assert_eq!(kept.touched, restored.touched, "step {step}");
            assert!(
                kept.bytes() == restored.bytes(),
                "bytes differ at step {step}"
            );
        }
        assert!(touches > 1_000, "bumped only {touches} times");
    }
}

#[test]
fn equal_worlds_stay_equal_and_restoring_often_changes_nothing() {
    let arena = arena(1.2, &EASY);
    let mut kept = Crowd::random(&arena, &model(1.0, 0.0), 60, 3);
    let mut restored = Crowd::random(&arena, &model(1.0, 0.0), 60, 3);
    for step in 0..300 {
        kept.wander();
        restored.wander();
        assert!(
            kept.bytes() == restored.bytes(),
            "bytes differ at step {step}"
        );
        restored.engine = postcard::from_bytes(&restored.bytes()).unwrap();
    }
}

#[test]
fn a_crowd_stays_apart_and_inside() {
    let arena = arena(1.2, &EASY);
    let walls = all_walls(&arena);
    for friction in [0.0, 1.0] {
        let mut crowd = Crowd::random(&arena, &model(friction, 0.0), 100, 2);
        for step in 0..1_000 {
            crowd.wander();
            let (robots_m, walls_m) = (crowd.deepest_overlap_m(), crowd.deepest_in_wall_m(&walls));
            assert!(
                robots_m < 0.0015 && walls_m < 0.001,
                "step {step}: {robots_m} m, {walls_m} m"
            );
        }
    }
}

#[test]
fn a_crush_does_not_break_a_wall() {
    let arena = arena(1.6, &[[0.8, 0.0, 0.8, 1.6], [0.4, 0.8, 0.8, 0.7]]);
    let walls = all_walls(&arena);
    let places: Vec<(f32, f32)> = (0..100)
        .map(|i| {
            (
                0.045 + 0.0755 * (i % 8) as f32,
                0.045 + 0.0755 * (i / 8) as f32,
            )
        })
        .filter(|&(x, y)| wall_distance_m(&walls, x, y) > RADIUS_M)
        .collect();
    let mut crowd = Crowd::at(&arena, &model(0.0, 0.0), &places, 1);
    crowd.dx_m.fill(TOP_STEP_M * 0.8);
    crowd.dy_m.fill(TOP_STEP_M * 0.6);
    for step in 0..600 {
        crowd.engine_step();
        let walls_m = crowd.deepest_in_wall_m(&walls);
        assert!(walls_m < 0.001, "step {step}: {walls_m} m");
        assert!(
            crowd.x_m.iter().all(|x| *x < 0.8),
            "step {step}: a robot broke through"
        );
    }
}

#[test]
fn wishes_that_make_no_sense_are_not_granted() {
    let mut crowd = Crowd::at(
        &arena(0.6, &EASY),
        &model(1.0, 0.0),
        &[(0.1, 0.1), (0.3, 0.2)],
        1,
    );
    for wish in [f32::NAN, f32::INFINITY, 1e30, 0.1] {
        (crowd.dx_m[0], crowd.dx_m[1]) = (wish, 0.001);
        let before = crowd.x_m.clone();
        crowd.engine_step();
        assert!(
            (crowd.x_m[0] - before[0]).abs() < 1e-6 && crowd.touched[0],
            "{wish}"
        );
        assert_eq!(
            (crowd.x_m[1], crowd.touched[1]),
            (before[1] + 0.001, false),
            "{wish}"
        );
    }
    crowd.dx_m[0] = 0.004;
    let before = crowd.x_m[0];
    crowd.engine_step();
    assert_eq!((crowd.x_m[0], crowd.touched[0]), (before + 0.004, false));
}

#[test]
fn a_body_gone_astray_is_put_back() {
    let places = [(0.1, 0.1), (0.3, 0.2)];
    let mut crowd = Crowd::at(&arena(0.6, &EASY), &model(1.0, 0.0), &places, 1);
    let lost = crowd.engine.robots[0];
    let astray: [fn(&mut RigidBody); 3] = [
        |body| body.set_translation(Vector::new(5.0, 5.0), true),
        |body| body.set_translation(Vector::NAN, true),
        |body| body.set_enabled(false),
    ];
    for go_astray in astray {
        go_astray(&mut crowd.engine.world.bodies[lost]);
        crowd.dx_m.fill(0.001);
        let before = crowd.x_m.clone();
        crowd.engine_step();
        assert_eq!((crowd.x_m[0], crowd.touched[0]), (before[0], true));
        assert_eq!((crowd.x_m[1], crowd.touched[1]), (before[1] + 0.001, false));
        crowd.engine_step();
        assert_eq!((crowd.x_m[0], crowd.touched[0]), (before[0] + 0.001, false));
    }
    crowd.dx_m[0] = -TOP_STEP_M;
    (0..20).for_each(|_| crowd.engine_step());
    assert!(
        crowd.touched[0] && (crowd.x_m[0] - 0.037).abs() < 1e-4,
        "walls hold it again"
    );
}

#[test]
fn fast_small_robots_stay_inside() {
    let mut model = model(0.3, 0.8);
    model.parameters.body_radius_m = 0.01;
    model.parameters.max_wheel_speed_rad_s = 60.0;
    let arena = arena(0.6, &MAZE);
    let walls = all_walls(&arena);
    let mut crowd = Crowd::at(&arena, &model, &[(0.07, 0.1), (0.1, 0.2)], 1);
    let longest_m = model.max_step_m() as f32;
    assert!(longest_m > 0.05);
    let mut noise = Noise(4);
    for step in 0..3_000 {
        for i in 0..2 {
            let heading = 7.0 * noise.next();
            crowd.dx_m[i] = longest_m * libm::cosf(heading);
            crowd.dy_m[i] = longest_m * libm::sinf(heading);
        }
        crowd.engine_step();
        for i in 0..2 {
            let (x, y) = (crowd.x_m[i], crowd.y_m[i]);
            assert!(
                wall_distance_m(&walls, x, y) > 0.009,
                "step {step}: ({x}, {y})"
            );
        }
    }
}

#[test]
fn an_engine_of_another_number_of_robots_does_not_fit() {
    let model = model(1.0, 0.0);
    let mut engine = RapierEngine::new(&arena(1.0, &[]), &model, &[0.3, 0.5], &[0.5, 0.5]);
    assert!(engine.fits(2) && !engine.fits(1) && !engine.fits(3));
    engine.robots[1] = RigidBodyHandle::invalid();
    assert!(!engine.fits(2), "a robot without a body");
}
