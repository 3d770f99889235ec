//! Worlds that are shared by threads: the same bits for any number of them, whatever robots do,
//! interrupted or not.

use super::*;
use crate::crew::Crew;
use crate::spec::RadioLink;

/// Robots that threads share, and that do not fill a whole number of chunks.
const ROBOTS: u32 = 1_100;

fn hall(objects: &str) -> Arc<Arena> {
    let json = format!(
        r#"{{"name":"hall","width_m":6.4,"height_m":5.6,"objects":[{objects}],
            "walls_m":[[1,1,1,4],[2,3,4,3],[5,0.5,5,2],[3.1,1,4.2,2.2]],
            "starts":[{{"x_m":0.2,"y_m":0.2,"heading_rad":0}}]}}"#
    );
    Arc::new(Arena::from_json(&json).unwrap())
}

/// Robots close enough to each other that many touch.
fn crowd(method: Method) -> RunSpec {
    let mut spec = RunSpec {
        arena: hall(""),
        robots: ROBOTS,
        placement: Placement::Random,
        epochs: 2,
        steps_per_epoch: 35,
        ..spec(method)
    };
    let parameters = &mut spec.controller.parameters;
    (parameters.babbling_epochs, parameters.sample) = (1, 64);
    (parameters.kmeans_restarts, parameters.lambda) = (2, 3);
    spec.controller.training = Some(Training {
        arena: hall(""),
        epochs: 2,
    });
    spec
}

fn on(threads: usize, spec: &RunSpec) -> Run {
    let mut run = run_of(spec.clone());
    run.set_crew(Crew::new(threads));
    run
}

fn check(spec: &RunSpec) {
    assert!(Crew::useful_threads(spec.robots as usize) > 1);
    let whole = finished(spec.clone());
    for threads in [2, 3, 7] {
        let mut run = on(threads, spec);
        run.advance(u64::MAX);
        assert!(run.outcome().as_ref() == Some(&whole), "{threads} threads");
    }
    // Another number of threads after every block and every snapshot.
    let (mut run, mut saved) = (on(3, spec), 0);
    for threads in [7, 1, 2, 3].into_iter().cycle() {
        if run.advance(13).phase == Phase::Done {
            break;
        }
        if threads != 3 {
            run = Run::restore(valid(spec.clone()), &run.snapshot()).unwrap();
            saved += 1;
        }
        run.set_crew(Crew::new(threads));
    }
    assert!(saved > 2, "no snapshot between");
    assert!(run.outcome().unwrap() == whole, "changing threads");
    // Nobody steers robots that wait for a program outside.
    let rests = spec.controller.method == Method::External;
    assert!(rests || whole.collisions > 0, "nobody met anybody");
}

#[test]
fn every_method_is_the_same_on_any_number_of_threads() {
    for &method in Method::ALL {
        check(&crowd(method));
    }
}

#[test]
fn rigid_bodies_and_objects_are_the_same_on_any_number_of_threads() {
    let disc = |x: f64| format!(r#"{{"kind":"disc","x_m":{x},"y_m":2.5,"radius_m":0.05}}"#);
    let objects: Vec<String> = (0..4).map(|n| disc(0.5 + 1.3 * f64::from(n))).collect();
    for (method, arena) in [
        (Method::Brownian, hall("")),
        (Method::Brownian, hall(&objects.join(","))),
        (Method::EvIterC, hall(&objects.join(","))),
    ] {
        check(&RunSpec {
            arena,
            engine: EngineKind::Rapier,
            ..crowd(method)
        });
    }
}

#[test]
fn what_robots_share_is_the_same_on_any_number_of_threads() {
    let radio = Sharing::Radio(RadioLink {
        range_m: Some(0.3),
        bytes_per_step: 32,
    });
    for sharing in [Sharing::Arena, radio] {
        for method in [Method::EvIterC, Method::Im] {
            check(&RunSpec {
                sharing: sharing.clone(),
                ..crowd(method)
            });
        }
    }
}

#[test]
fn wheels_that_slip_and_epochs_that_go_on_are_the_same_on_any_number_of_threads() {
    let mut spec = RunSpec {
        episodes: Episodes::Continue,
        ..crowd(Method::Brownian)
    };
    spec.robot.parameters.wheel_slip = 0.1;
    spec.steps_per_epoch = 300;
    check(&spec);
}
