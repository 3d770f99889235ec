//! Movable objects over time, on disk.

use serde::{Deserialize, Serialize};
use swarm::bodies::ObjectPose;
use swarm::run::{ObjectSample, TrackParts, Tracks};

use super::envelope::{Damage, Kind, open, seal, whole};

/// Layout 1, and 0 but for the envelope.
#[derive(Serialize, Deserialize)]
pub(super) struct V1 {
    times: Vec<TimeV1>,
    samples: Vec<SampleV1>,
    offered: u64,
    halvings: u32,
}

#[derive(Serialize, Deserialize)]
struct TimeV1 {
    steps: u64,
    epoch: u32,
}

#[derive(Serialize, Deserialize)]
struct SampleV1 {
    x_m: f32,
    y_m: f32,
    cos: f32,
    sin: f32,
    moved_m: f64,
}

/// In the present layout.
pub(super) fn write(tracks: &Tracks) -> Vec<u8> {
    let TrackParts {
        times,
        samples,
        offered,
        halvings,
    } = tracks.parts();
    let time = |(steps, epoch)| TimeV1 { steps, epoch };
    let sample = |sample: ObjectSample| {
        let ObjectSample {
            pose: ObjectPose { x_m, y_m, cos, sin },
            moved_m,
        } = sample;
        SampleV1 {
            x_m,
            y_m,
            cos,
            sin,
            moved_m,
        }
    };
    let layout = V1 {
        times: times.into_iter().map(time).collect(),
        samples: samples.into_iter().map(sample).collect(),
        offered,
        halvings,
    };
    seal(Kind::Objects, 1, &layout)
}

/// From any layout.
pub(super) fn read(bytes: &[u8]) -> Result<Tracks, Damage> {
    match open(Kind::Objects, bytes)? {
        (1, payload) => whole::<V1>(payload)?.into_tracks(),
        (version, _) => Err(Damage::Version(version)),
    }
}

impl V1 {
    pub(super) fn into_tracks(self) -> Result<Tracks, Damage> {
        let Self {
            times,
            samples,
            offered,
            halvings,
        } = self;
        let time = |TimeV1 { steps, epoch }| (steps, epoch);
        let sample = |sample: SampleV1| {
            let SampleV1 {
                x_m,
                y_m,
                cos,
                sin,
                moved_m,
            } = sample;
            ObjectSample {
                pose: ObjectPose { x_m, y_m, cos, sin },
                moved_m,
            }
        };
        let parts = TrackParts {
            times: times.into_iter().map(time).collect(),
            samples: samples.into_iter().map(sample).collect(),
            offered,
            halvings,
        };
        Tracks::from_parts(parts)
            .ok_or_else(|| Damage::Content("its moments have different numbers of objects".into()))
    }
}
