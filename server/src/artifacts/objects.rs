//! Movable objects over time as JSON types and CSV text.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use api::{ObjectSample, ObjectTrack, ObjectTracks};
use arenas::Arena;
use swarm::run::{Moment, Tracks};

use crate::tables::Decimal;

/// The objects of an arena over time; `step_s` is the length of a control step.
pub fn objects_json(arena: &Arena, tracks: &Tracks, step_s: f64) -> ObjectTracks {
    let track = |(number, object): (usize, &arenas::Movable)| ObjectTrack {
        kind: object.kind().to_owned(),
        samples: tracks
            .moments()
            .filter_map(|moment| sample(&moment, number, step_s))
            .collect(),
    };
    ObjectTracks {
        schema: api::SCHEMA,
        objects: arena.objects().iter().enumerate().map(track).collect(),
    }
}

fn sample(moment: &Moment<'_>, object: usize, step_s: f64) -> Option<ObjectSample> {
    let swarm::run::ObjectSample { pose, moved_m } = *moment.objects.get(object)?;
    Some(ObjectSample {
        steps: moment.steps,
        time_s: moment.steps as f64 * step_s,
        epoch: moment.epoch,
        x_m: pose.x_m,
        y_m: pose.y_m,
        heading_rad: libm::atan2f(pose.sin, pose.cos),
        moved_m,
    })
}

/// `objects.csv`: a line an object and moment, in order of time.
pub fn objects_csv(tracks: &Tracks) -> String {
    let mut text = String::from("steps,epoch,object,x_m,y_m,heading_rad,moved_m\n");
    for moment in tracks.moments() {
        for number in 0..moment.objects.len() {
            let Some(sample) = sample(&moment, number, 0.0) else {
                continue;
            };
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{},{number},{},{},{},{}",
                sample.steps,
                sample.epoch,
                Decimal(sample.x_m),
                Decimal(sample.y_m),
                Decimal(sample.heading_rad),
                Decimal(sample.moved_m)
            );
        }
    }
    text
}
