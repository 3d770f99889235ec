//! Tests of whole runs: interruption, thread count, block size, instructions, engines, methods.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod continued;
mod forged;
mod learnt;
mod sharing;
mod threads;

use std::sync::Arc;

use arenas::Arena;
use rayon::prelude::*;

use super::{Outcome, Phase, RestoreError, Run, counts_within};
use crate::metrics::Value;
use crate::robot::{Preset, RobotModel};
use crate::spec::{
    ClusterScale, ControllerParameters, ControllerSpec, EngineKind, Episodes, EpsilonIs, Method,
    Placement, RunSpec, SensorScale, Sharing, Training,
};
use crate::validate::ValidSpec;
use crate::world::Backend;

fn arena(name: &str) -> Arc<Arena> {
    Arc::new(arenas::builtin(name).unwrap())
}

fn spec(method: Method) -> RunSpec {
    RunSpec {
        seed: 5,
        arena: arena("maze"),
        controller: ControllerSpec {
            method,
            parameters: ControllerParameters {
                babbling_epochs: 2,
                ..Default::default()
            },
            own: Default::default(),
            training: Some(Training {
                arena: arena("easy"),
                epochs: 3,
            }),
        },
        epochs: 3,
        steps_per_epoch: 200,
        robots: 1,
        placement: Placement::Start,
        episodes: Episodes::Reset,
        robot: RobotModel::default(),
        engine: EngineKind::Kinematic,
        memory_budget_bytes: None,
        sharing: Sharing::None,
    }
}

fn swarm(method: Method, robots: u32) -> RunSpec {
    RunSpec {
        robots,
        placement: Placement::Grid,
        epochs: 2,
        steps_per_epoch: 150,
        ..spec(method)
    }
}

fn valid(spec: RunSpec) -> ValidSpec {
    spec.validate().unwrap()
}

fn run_of(spec: RunSpec) -> Run {
    Run::new(valid(spec)).unwrap()
}

fn finished(spec: RunSpec) -> Outcome {
    let mut run = run_of(spec);
    run.advance(u64::MAX);
    run.outcome().unwrap()
}

/// Interrupts a run at every multiple of `every` steps and compares with one never interrupted.
fn check_interrupted(spec: &RunSpec, every: u64) {
    let mut whole = run_of(spec.clone());
    let mut parts = run_of(spec.clone());
    while whole.outcome().is_none() {
        whole.advance(every);
        parts.advance(every);
        let saved = parts.snapshot();
        assert!(
            saved == whole.snapshot(),
            "differs after {} steps",
            whole.step()
        );
        parts = Run::restore(valid(spec.clone()), &saved).unwrap();
        assert!(parts.snapshot() == saved, "restoring changed the state");
    }
    assert_eq!(whole.outcome(), parts.outcome());
}

#[test]
fn interrupted_equals_uninterrupted_for_every_method() {
    for &method in Method::ALL {
        check_interrupted(&spec(method), 137);
    }
}

#[test]
fn interrupted_equals_uninterrupted_for_swarms_engines_and_episodes() {
    check_interrupted(&swarm(Method::EvIterC, 4), 61);
    check_interrupted(
        &RunSpec {
            engine: EngineKind::Rapier,
            ..swarm(Method::Im, 3)
        },
        61,
    );
    check_interrupted(
        &RunSpec {
            episodes: Episodes::Continue,
            ..spec(Method::EvIterD)
        },
        137,
    );
}

/// What a saved learner does not hold is given back to it in every phase.
#[test]
fn interrupted_equals_uninterrupted_under_other_readings() {
    for method in [Method::Im, Method::EvIterCa, Method::Curiosity] {
        let mut spec = spec(method);
        spec.episodes = Episodes::ContinueExploring;
        let parameters = &mut spec.controller.parameters;
        parameters.command_levels = 5;
        parameters.sensor_scale = SensorScale::Unsigned;
        parameters.cluster_scale = ClusterScale::Signed;
        parameters.epsilon_is = EpsilonIs::Diameter;
        check_interrupted(&spec, 137);
    }
}

/// Each reading of the thesis changes what a run comes to, and its default changes nothing.
#[test]
fn every_reading_makes_a_difference() {
    let plain = finished(spec(Method::EvIterC));
    let with = |set: fn(&mut RunSpec)| {
        let mut spec = spec(Method::EvIterC);
        set(&mut spec);
        finished(spec)
    };
    let others = [
        with(|spec| spec.controller.parameters.cluster_scale = ClusterScale::Signed),
        with(|spec| spec.controller.parameters.command_levels = 0),
        with(|spec| spec.controller.parameters.epsilon_is = EpsilonIs::Diameter),
        with(|spec| spec.episodes = Episodes::ContinueExploring),
        with(|spec| spec.robot = RobotModel::preset(Preset::WebotsSliding)),
        with(|spec| spec.robot = RobotModel::preset(Preset::WebotsRough)),
    ];
    for (place, other) in others.iter().enumerate() {
        assert_ne!(other.state_sha256, plain.state_sha256, "{place}");
    }
    // Three levels a wheel are at most nine actions, and two are four.
    let four = with(|spec| spec.controller.parameters.command_levels = 2);
    let actions = [&four, &plain].map(|outcome| outcome.actuator_clusters);
    assert!(
        actions[0] <= 4 && (5..=9).contains(&actions[1]),
        "{actions:?}"
    );
    let same = with(|spec| spec.controller.parameters.cluster_scale = ClusterScale::AsSensed);
    let states = |outcome: &Outcome| (outcome.sensor_clusters, outcome.coverage);
    assert_eq!(states(&same), states(&others[0]));
}

/// Epsilon in [0, 1] is twice as much in [-1, 1], and a diameter twice a radius.
#[test]
fn scales_and_diameters_are_the_same_clusters() {
    let states = |epsilon_sensor, cluster_scale, epsilon_is| {
        let mut spec = spec(Method::Im);
        let parameters = &mut spec.controller.parameters;
        parameters.epsilon_sensor = epsilon_sensor;
        parameters.cluster_scale = cluster_scale;
        parameters.epsilon_is = epsilon_is;
        parameters.epsilon_actuator = match epsilon_is {
            EpsilonIs::Radius => 0.6,
            EpsilonIs::Diameter => 1.2,
        };
        let outcome = finished(spec);
        (outcome.sensor_clusters, outcome.actuator_clusters)
    };
    let plain = states(1.2, ClusterScale::AsSensed, EpsilonIs::Radius);
    assert_eq!(
        states(0.6, ClusterScale::Unsigned, EpsilonIs::Radius),
        plain
    );
    assert_eq!(
        states(2.4, ClusterScale::AsSensed, EpsilonIs::Diameter),
        plain
    );
}

#[test]
fn robots_go_on_only_while_they_explore() {
    let evolving = |method| {
        let spec = RunSpec {
            episodes: Episodes::ContinueExploring,
            ..spec(method)
        };
        let mut run = run_of(spec);
        let mut jumps = Vec::new();
        let mut phase = run.progress().phase;
        while run.outcome().is_none() {
            let before = run.robots()[0];
            run.advance(1);
            let robot = &run.robots()[0];
            let far = (robot.x_m - before.x_m).abs() + (robot.y_m - before.y_m).abs() > 0.02;
            if far && phase == run.progress().phase {
                jumps.push(phase);
            }
            phase = run.progress().phase;
        }
        jumps
    };
    assert!(evolving(Method::Brownian).is_empty());
    assert!(!evolving(Method::EvIterC).contains(&Phase::Exploration));
    assert!(evolving(Method::EvIterC).contains(&Phase::Evolution));
    assert!(evolving(Method::Curiosity).contains(&Phase::Exploration));
}

#[test]
fn blocks_and_instructions_do_not_matter() {
    for spec in [spec(Method::EvIterCa), swarm(Method::Curiosity, 5)] {
        let whole = finished(spec.clone());
        let mut blocks = run_of(spec.clone());
        while blocks.advance(7).phase != Phase::Done {}
        assert_eq!(blocks.outcome().unwrap(), whole);
        let mut portable = run_of(spec);
        portable.set_backend(Backend::Portable);
        portable.advance(u64::MAX);
        assert_eq!(portable.outcome().unwrap(), whole);
    }
}

#[test]
fn thread_count_does_not_matter() {
    let specs: Vec<RunSpec> = (0..6)
        .map(|seed| RunSpec {
            seed,
            ..spec(Method::Im)
        })
        .collect();
    let on = |threads: usize| -> Vec<Outcome> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| specs.par_iter().cloned().map(finished).collect())
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
    assert_ne!(one[0].state_sha256, one[1].state_sha256, "seeds differ");
}

#[test]
fn replay_sees_the_very_trajectories_of_phase_1() {
    // The archive replayed at the end of phase 2 leaves the robot where phase 1 left it.
    let spec = spec(Method::EvIterC);
    let steps = u64::from(spec.steps_per_epoch) * 3;
    let mut run = run_of(spec);
    let pose = |run: &Run| {
        let robot = &run.robots()[0];
        (
            robot.x_m.to_bits(),
            robot.y_m.to_bits(),
            robot.reading.proximity.map(f32::to_bits),
        )
    };
    let mut evolved = Vec::new();
    let mut replayed = Vec::new();
    for step in 0..2 * steps {
        assert_eq!(
            run.progress().phase,
            if step < steps {
                Phase::Evolution
            } else {
                Phase::Repository
            }
        );
        run.advance(1);
        if (step + 1) % steps != 0 {
            if step < steps {
                evolved.push(pose(&run))
            } else {
                replayed.push(pose(&run))
            }
        }
    }
    assert_eq!(evolved, replayed);
}

#[test]
fn progress_counts_every_stage() {
    let mut run = run_of(spec(Method::EvIterC));
    let total = run.progress().robot_steps_total;
    assert_eq!(total, (3 + 3 + 3) * 200);
    assert_eq!(run.advance(u64::MAX).robot_steps_done, total);
    assert_eq!(run.curve().len(), 3);
    assert!(
        run.curve()
            .windows(2)
            .all(|w| w[0].p1 <= w[1].p1 && w[0].epoch < w[1].epoch)
    );
    let shown = run_of(spec(Method::Curiosity));
    assert_eq!(
        shown.progress().robot_steps_total,
        2 * 3 * 200,
        "evaluated, then shown"
    );
}

#[test]
fn visits_agree_with_coverage() {
    let mut run = run_of(swarm(Method::Brownian, 6));
    run.advance(u64::MAX);
    let (visits, dwell) = (run.visits(), run.dwell());
    let outcome = run.outcome().unwrap();
    assert_eq!(
        visits.iter().filter(|&&v| v >= 1).count() as u32,
        outcome.coverage.p1
    );
    assert_eq!(
        visits.iter().filter(|&&v| v >= 10).count() as u32,
        outcome.coverage.p10
    );
    assert_eq!(dwell.iter().sum::<u32>(), 2 * 150 * 6);
}

#[test]
fn damaged_and_foreign_snapshots_are_refused() {
    let run = run_of(spec(Method::Im));
    let saved = run.snapshot();
    for cut in [0, 7, 39, 41, saved.len() - 1] {
        assert!(Run::restore(valid(spec(Method::Im)), &saved[..cut]).is_err());
    }
    let mut flipped = saved.clone();
    flipped[100] ^= 1;
    assert!(matches!(
        Run::restore(valid(spec(Method::Im)), &flipped),
        Err(RestoreError::Unreadable(_))
    ));
    let other = RunSpec {
        seed: 6,
        ..spec(Method::Im)
    };
    assert!(matches!(
        Run::restore(valid(other), &saved),
        Err(RestoreError::OtherSpec)
    ));
}

#[test]
fn learners_that_do_not_suit_their_stage_are_not_restored() {
    // Otherwise sound, with the right checksum: only their kind, or their number, is another.
    for (of, other) in [
        (swarm(Method::Im, 2), swarm(Method::Brownian, 2)),
        (swarm(Method::EvIterC, 2), swarm(Method::Curiosity, 2)),
        (swarm(Method::Brownian, 2), swarm(Method::Brownian, 1)),
    ] {
        let mut run = run_of(of.clone());
        run.learners = run_of(other).learners;
        assert!(matches!(
            Run::restore(valid(of), &run.snapshot()),
            Err(RestoreError::Unreadable(_))
        ));
    }
}

#[test]
fn specs_that_cannot_run_are_refused_with_their_fields() {
    let check =
        |spec: RunSpec, pointer: &str, part: &str| {
            let errors = spec.validate().and_then(Run::new).err().unwrap();
            assert!(
                errors.iter().any(|e| e.pointer == pointer
                    && (e.message.contains(part) || e.allowed.contains(part))),
                "{pointer} {part}: {errors:?}"
            );
        };
    check(
        RunSpec {
            epochs: 0,
            ..spec(Method::Im)
        },
        "/epochs",
        "from 1",
    );
    check(
        RunSpec {
            robots: 2,
            ..spec(Method::Im)
        },
        "/robots",
        "placement",
    );
    check(
        RunSpec {
            robots: 1_000,
            placement: Placement::Grid,
            ..spec(Method::Im)
        },
        "/robots",
        "at most",
    );
    check(
        RunSpec {
            robots: 1_000,
            placement: Placement::Random,
            ..spec(Method::Im)
        },
        "/robots",
        "at most",
    );
    let mut fast = spec(Method::Im);
    fast.robot.parameters.max_wheel_speed_rad_s = 100.0;
    check(fast, "/robot/max_wheel_speed_rad_s", "half the body radius");
    let mut large = spec(Method::Im);
    large.robot.parameters.body_radius_m = 0.2;
    check(large, "/arena/starts/0", "");
    let mut untrained = spec(Method::EvIterC);
    untrained.controller.training = None;
    check(untrained, "/controller/train", "training arena");
}

#[test]
fn model_accuracy_is_of_those_with_a_table_and_changes_nothing() {
    let mut brownian = run_of(spec(Method::Brownian));
    brownian.advance(u64::MAX);
    assert_eq!(brownian.outcome().unwrap().model, None);
    let mut im = run_of(spec(Method::Im));
    im.advance(u64::MAX);
    let before = im.snapshot();
    let model = im.outcome().unwrap().model.unwrap();
    assert_eq!(im.model_accuracy(), Some(model));
    assert!(im.snapshot() == before);
    let (states, actions) = im.learners.clusters();
    assert!((1..=states * actions).contains(&model.pairs), "{model:?}");
    assert!(
        model.sum_nats.is_finite() && model.sum_nats > 0.0,
        "{model:?}"
    );
}

#[test]
fn metrics_agree_with_visits_step_by_step() {
    let spec = RunSpec {
        epochs: 5,
        steps_per_epoch: 40,
        ..swarm(Method::Brownian, 3)
    };
    let mut run = run_of(spec);
    let mask = run.reachable().mask.clone();
    let reachable = run.reachable().count;
    // The oracle: visits after every step.
    let mut first = vec![0_u64; mask.len()];
    let mut distance_m = 0.0;
    let mut before: Vec<[f32; 2]> = run.robots().iter().map(|r| [r.x_m, r.y_m]).collect();
    for step in 0..=200_u64 {
        for (first, visits) in first.iter_mut().zip(run.visits()) {
            if *first == 0 && visits > 0 {
                *first = step + 1;
            }
        }
        if step == 200 {
            break;
        }
        run.advance(1);
        let reset = (step + 1) % 40 == 0;
        for (robot, before) in run.robots().iter().zip(&mut before) {
            if !reset {
                let way = [robot.x_m - before[0], robot.y_m - before[1]];
                distance_m += f64::from((way[0] * way[0] + way[1] * way[1]).sqrt());
            }
            *before = [robot.x_m, robot.y_m];
        }
    }
    let log = run.metrics();
    for ((known, first), inside) in log.first_entry.iter().zip(&first).zip(&mask) {
        assert_eq!(*known, if *inside { *first } else { 0 });
    }
    let last = log.rows.last().unwrap();
    assert_eq!((last.steps, last.epoch), (200, 5));
    assert_eq!(last.entered, counts_within(&run.visits(), &mask));
    let end = run.outcome().unwrap().metrics;
    let of_end = |name: &str| {
        let found = end.iter().find(|(known, _)| *known == name);
        found.unwrap_or_else(|| panic!("{name} at the end")).1
    };
    let real = |value: Option<Value>| match value {
        Some(Value::Real(value)) => value,
        other => panic!("{other:?}"),
    };
    for (name, value) in last.values.iter().filter(|(name, _)| *name != "collisions") {
        assert_eq!(of_end(name), value, "{name}");
    }
    // The last step of each epoch is not seen from outside: robots are back at their starts.
    let travelled_m = real(of_end("distance_m"));
    assert!(
        travelled_m > distance_m && travelled_m < 1.05 * distance_m,
        "{distance_m}"
    );
    let firsts: u32 = log.robots.iter().map(|robot| robot.first_entries).sum();
    assert_eq!(
        firsts as usize,
        first.iter().filter(|&&first| first > 0).count()
    );
    assert_eq!(log.reachable, reachable);
    // Nine tenths and the end of the first four epochs, and the fifth.
    assert_eq!(log.rows.len(), 41);
    assert!(log.rows.is_sorted_by_key(|row| (row.steps, row.entered)));
    assert!((0.0..=1.0).contains(&real(of_end("overlap"))));
    let contributors = real(of_end("contributors"));
    assert!(contributors > 1.0 && contributors <= 3.0);
}

fn pushing_boxes() -> RunSpec {
    let json = r#"{"name":"yard","width_m":0.6,"height_m":0.6,"walls_m":[],
        "starts":[{"x_m":0.1,"y_m":0.1,"heading_rad":0.8}],"objects":[
        {"kind":"box","x_m":0.2,"y_m":0.2,"width_m":0.06,"height_m":0.04},
        {"kind":"disc","x_m":0.35,"y_m":0.3,"radius_m":0.03}]}"#;
    RunSpec {
        arena: Arc::new(Arena::from_json(json).unwrap()),
        engine: EngineKind::Rapier,
        ..swarm(Method::Im, 3)
    }
}

#[test]
fn pushed_objects_are_saved_and_counted() {
    let spec = pushing_boxes();
    check_interrupted(&spec, 61);
    let on = RunSpec {
        episodes: Episodes::Continue,
        ..spec
    };
    check_interrupted(&on, 61);
    let objects = finished(on).objects;
    assert_eq!(objects.len(), 2);
    assert!(
        objects.iter().any(|object| object.moved_m > 0.01),
        "{objects:?}"
    );
    assert!(
        objects
            .iter()
            .all(|object| object.displaced_m <= object.moved_m + 1e-3)
    );
}

#[test]
fn objects_are_tracked_where_metrics_have_rows() {
    for episodes in [Episodes::Reset, Episodes::Continue] {
        let mut run = run_of(RunSpec {
            episodes,
            ..pushing_boxes()
        });
        let mut seen = Vec::new();
        while run.outcome().is_none() {
            run.advance(1);
            // Whatever the moment, the last one told is the present one.
            let tracks = run.tracks();
            let now = tracks.moments().next_back().unwrap();
            let known: Vec<_> = run.objects().iter().map(|o| (o.pose, o.moved_m)).collect();
            let told: Vec<_> = now.objects.iter().map(|o| (o.pose, o.moved_m)).collect();
            let epoch_begins = now.steps.is_multiple_of(150) && episodes == Episodes::Reset;
            assert!(told == known || epoch_begins);
            seen.push((now.steps, now.epoch, told));
        }
        let (tracks, log) = (run.tracks(), run.metrics());
        let rows = log.rows.iter().map(|row| (row.steps, row.epoch));
        let expected: Vec<_> = std::iter::once((0, 0)).chain(rows).collect();
        let times: Vec<_> = tracks.moments().map(|m| (m.steps, m.epoch)).collect();
        assert_eq!(times, expected);
        for moment in tracks.moments().filter(|moment| moment.steps > 0) {
            let told: Vec<_> = moment.objects.iter().map(|o| (o.pose, o.moved_m)).collect();
            assert!(seen.contains(&(moment.steps, moment.epoch, told)));
        }
        let first = tracks.moments().next().unwrap();
        assert!(first.objects.iter().all(|object| object.moved_m == 0.0));
    }
    assert!(run_of(swarm(Method::Im, 1)).tracks().is_empty());
}

#[test]
fn the_kinematic_engine_refuses_objects_also_in_training() {
    let pointer = |spec: RunSpec| {
        let errors = spec.validate().err().unwrap_or_default();
        errors.first().map(|error| error.pointer.clone())
    };
    let kinematic = RunSpec {
        engine: EngineKind::Kinematic,
        ..pushing_boxes()
    };
    assert_eq!(pointer(kinematic).as_deref(), Some("/engine"));
    let mut training = spec(Method::EvIterC);
    training.controller.training = Some(Training {
        arena: pushing_boxes().arena,
        epochs: 1,
    });
    assert_eq!(pointer(training).as_deref(), Some("/engine"));
}
