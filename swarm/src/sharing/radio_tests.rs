//! Radio against a search over all pairs.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use crate::bodies::{Body, StartPose};
use crate::random::{Purpose, Site, Stream, stream_key};
use crate::spec::DEFAULT_BYTES_PER_STEP;

fn radio(range_m: Option<f64>, robots: usize) -> Radio {
    let link = RadioLink {
        range_m,
        bytes_per_step: DEFAULT_BYTES_PER_STEP,
    };
    let key = stream_key(1, Site::Target, 0, Purpose::Radio);
    Radio::new(&link, &MemoryPlan::small(), robots, (3.0, 2.0), key)
}

fn scattered(robots: usize, seed: u64) -> Bodies {
    let mut stream = Stream::new(seed);
    (0..robots)
        .map(|_| {
            Body::at_rest(&StartPose {
                x_m: 3.0 * stream.uniform() as f32,
                y_m: 2.0 * stream.uniform() as f32,
                cos: 1.0,
                sin: 0.0,
            })
        })
        .collect::<Vec<_>>()
        .into()
}

#[test]
fn everybody_in_range_is_heard_and_nobody_else() {
    for (range_m, robots) in [
        (Some(0.24), 60),
        (Some(0.8), 12),
        (None, 9),
        (Some(0.0), 30),
    ] {
        let mut radio = radio(range_m, robots);
        for step in 0..40 {
            let bodies = scattered(robots, step);
            radio.locate(&bodies);
            for robot in 0..robots {
                let mut heard = Vec::new();
                radio.each_heard(robot, step, &bodies, |other| heard.push(other));
                heard.sort_unstable();
                let here = &bodies[robot];
                let near = (0..robots).filter(|other| {
                    let (dx, dy) = (bodies[*other].x_m - here.x_m, bodies[*other].y_m - here.y_m);
                    let range_m = range_m.map_or(f32::INFINITY, |range| range as f32);
                    *other != robot && dx * dx + dy * dy <= range_m * range_m
                });
                let near: Vec<usize> = near.collect();
                if near.len() <= MOST_HEARD {
                    assert_eq!(heard, near, "{range_m:?}, robot {robot} at step {step}");
                } else {
                    assert_eq!(heard.len(), MOST_HEARD);
                    heard.dedup();
                    assert_eq!(heard.len(), MOST_HEARD, "each once");
                    assert!(heard.iter().all(|other| near.contains(other)));
                }
            }
        }
    }
}

#[test]
fn a_crowd_is_heard_in_turn() {
    let robots = 50;
    let mut radio = radio(None, robots);
    let bodies = scattered(robots, 1);
    radio.locate(&bodies);
    let mut times = vec![0; robots];
    for step in 0..2_000 {
        radio.each_heard(7, step, &bodies, |other| times[other] += 1);
    }
    assert_eq!(times[7], 0);
    let expected = 2_000 * MOST_HEARD / (robots - 1);
    for (other, heard) in times.iter().enumerate().filter(|(other, _)| *other != 7) {
        assert!(
            (expected / 2..expected * 2).contains(heard),
            "{other}: {heard}"
        );
    }
}

#[test]
fn messages_are_as_long_as_their_bytes_allow() {
    let earlier = |bytes_per_step, sensor_clusters| {
        let link = RadioLink {
            range_m: None,
            bytes_per_step,
        };
        let plan = MemoryPlan {
            sensor_clusters,
            ..MemoryPlan::small()
        };
        told_transitions(&link, &plan).earlier
    };
    assert_eq!(
        [6, 7, 16, 4_096].map(|bytes| earlier(bytes, 25)),
        [0, 1, 3, 1_023]
    );
    assert_eq!(
        [6, 13, 14, 22].map(|bytes| earlier(bytes, 300)),
        [0, 0, 1, 2]
    );
}
