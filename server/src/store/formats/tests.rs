#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use swarm::bodies::ObjectPose;
use swarm::metrics::{RowValues, Value};
use swarm::run::{MetricsRow, ObjectSample, RobotMemory, RobotMetrics, TrackParts, Tracks};

use sha2::{Digest, Sha256};
use swarm::run::{CurveRow, MetricsLog};

use super::envelope::{Kind, seal};
use super::*;
use crate::store::findings::Findings;

fn findings() -> Findings {
    let sample = |x_m| ObjectSample {
        pose: ObjectPose {
            x_m,
            y_m: 0.25,
            cos: 1.0,
            sin: 0.0,
        },
        moved_m: 0.125,
    };
    let parts = TrackParts {
        times: vec![(0, 0), (500, 1)],
        samples: vec![sample(0.5), sample(0.75)],
        offered: 2,
        halvings: 0,
    };
    let row = |steps, overlap: Option<f64>| MetricsRow {
        steps,
        epoch: 1,
        entered: [3, 2, 1, 0],
        values: RowValues::from_names(|name| match name {
            "entropy" => Some(Value::Real(0.5)),
            "overlap" => overlap.map(Value::Real),
            "contribution_max" => Some(Value::Real(1.0)),
            "collisions" => Some(Value::Count(17)),
            "distance_m" => Some(Value::Real(1.5)),
            _ => None,
        }),
    };
    Findings {
        curve: vec![CurveRow {
            epoch: 1,
            p1: 3,
            p2: 2,
            p5: 1,
            p10: 0,
        }],
        visits: vec![1, 2, 0, 300],
        dwell: vec![4, 5, 0, 70_000],
        metrics: MetricsLog {
            reachable: 4,
            rows: vec![row(500, None), row(1_000, Some(0.125))],
            robots: vec![RobotMetrics {
                first_entries: 3,
                distance_m: 1.5,
                memory: RobotMemory {
                    bytes: 288,
                    clusters_saturated: 1,
                },
            }],
            first_entry: vec![1, 2, 0, 3],
        },
        tracks: Tracks::from_parts(parts).unwrap(),
    }
}

#[test]
fn findings_come_back_as_they_were() {
    assert_eq!(Blobs::of(&findings()).read().unwrap(), findings());
    let nothing = Findings::default();
    let blobs = Blobs::of(&nothing);
    assert!(blobs.objects.is_none());
    assert_eq!(blobs.read().unwrap(), nothing);
}

/// The bytes are what counts: a layout is never changed once a program wrote it.
#[test]
fn layouts_stay() {
    let Blobs {
        coverage,
        metrics,
        objects,
    } = Blobs::of(&findings());
    let digests = [coverage, metrics.unwrap(), objects.unwrap()].map(|blob| {
        let digest = Sha256::digest(&blob);
        format!(
            "{} {:02x}{:02x}{:02x}{:02x}",
            blob.len(),
            digest[0],
            digest[1],
            digest[2],
            digest[3]
        )
    });
    assert_eq!(digests, LAYOUTS);
}
const LAYOUTS: [&str; 3] = ["57 f2bb8f75", "210 932c7076", "95 3cf84e63"];

#[test]
fn any_changed_cut_or_added_byte_is_damage() {
    let whole = Blobs::of(&findings());
    type Of = fn(&mut Blobs) -> &mut Vec<u8>;
    let kinds: [(Kind, Of); 3] = [
        (Kind::Coverage, |blobs| &mut blobs.coverage),
        (Kind::Metrics, |blobs| blobs.metrics.as_mut().unwrap()),
        (Kind::Objects, |blobs| blobs.objects.as_mut().unwrap()),
    ];
    for (kind, of) in kinds {
        let is_damaged = |change: &dyn Fn(&mut Vec<u8>)| {
            let mut blobs = Blobs {
                coverage: whole.coverage.clone(),
                metrics: whole.metrics.clone(),
                objects: whole.objects.clone(),
            };
            change(of(&mut blobs));
            blobs.read().is_err_and(|(found, _)| found == kind)
        };
        let length = of(&mut Blobs::of(&findings())).len();
        assert!(!is_damaged(&|_| {}));
        assert!(is_damaged(&|blob| blob.push(0)));
        for place in 0..length {
            assert!(is_damaged(&|blob| blob[place] ^= 1), "{kind:?} {place}");
            assert!(is_damaged(&|blob| blob.truncate(place)), "{kind:?} {place}");
        }
    }
    let swapped = Blobs {
        metrics: whole.objects.clone(),
        ..whole
    };
    assert!(matches!(
        swapped.read(),
        Err((Kind::Metrics, Damage::Foreign))
    ));
}

#[test]
fn a_later_version_is_named() {
    let mut blobs = Blobs::of(&findings());
    blobs.coverage = seal(Kind::Coverage, 9, &0_u8);
    let (kind, damage) = blobs.read().unwrap_err();
    assert_eq!((kind, damage), (Kind::Coverage, Damage::Version(9)));
}

#[test]
fn parts_that_do_not_fit_together_are_damage() {
    for change in [
        |findings: &mut Findings| findings.visits.push(0),
        |findings: &mut Findings| findings.metrics.first_entry.push(0),
    ] {
        let mut findings = findings();
        change(&mut findings);
        let read = Blobs::of(&findings).read();
        assert!(matches!(read, Err((_, Damage::Content(_)))));
    }
}

/// What programs without envelopes wrote, field by field.
fn v0() -> Blobs {
    let Findings {
        curve,
        visits,
        dwell,
        metrics,
        tracks,
    } = findings();
    let row = |row: &MetricsRow| {
        let real = |name| match row.values.get(name) {
            Some(Value::Real(value)) => Some(value),
            _ => None,
        };
        let collisions = match row.values.get("collisions") {
            Some(Value::Count(count)) => count,
            other => panic!("{other:?}"),
        };
        (
            (
                row.steps,
                row.epoch,
                row.entered,
                real("entropy").unwrap(),
                real("overlap"),
            ),
            (
                real("contribution_max").unwrap(),
                collisions,
                real("distance_m").unwrap(),
            ),
        )
    };
    let robot = |robot: &RobotMetrics| {
        let RobotMemory {
            bytes,
            clusters_saturated,
        } = robot.memory;
        (
            robot.first_entries,
            robot.distance_m,
            bytes,
            clusters_saturated,
        )
    };
    let curve = curve
        .iter()
        .map(|row| (row.epoch, row.p1, row.p2, row.p5, row.p10));
    let rows: Vec<_> = metrics.rows.iter().map(row).collect();
    let robots: Vec<_> = metrics.robots.iter().map(robot).collect();
    let parts = tracks.parts();
    let samples = parts.samples.iter().map(|sample| {
        let pose = sample.pose;
        (pose.x_m, pose.y_m, pose.cos, pose.sin, sample.moved_m)
    });
    let curve: Vec<_> = curve.collect();
    let samples: Vec<_> = samples.collect();
    let bytes = |value: &dyn Fn() -> postcard::Result<Vec<u8>>| value().unwrap();
    Blobs {
        coverage: bytes(&|| postcard::to_stdvec(&(&curve, &visits, &dwell))),
        metrics: Some(bytes(&|| {
            postcard::to_stdvec(&(metrics.reachable, &rows, &robots, &metrics.first_entry))
        })),
        objects: Some(bytes(&|| {
            postcard::to_stdvec(&(&parts.times, &samples, parts.offered, parts.halvings))
        })),
    }
}

#[test]
fn bare_blobs_are_upgraded_and_strictly_read() {
    assert_eq!(upgrade_v0(&v0()).unwrap().read().unwrap(), findings());
    let without = upgrade_v0(&Blobs {
        metrics: None,
        objects: None,
        ..v0()
    });
    let read = without.unwrap().read().unwrap();
    assert_eq!(
        (read.visits, read.metrics.rows.len()),
        (findings().visits, 0)
    );
    let mut longer = v0();
    longer.coverage.push(0);
    assert!(upgrade_v0(&longer).is_err());
    let mut shorter = v0();
    shorter.metrics.as_mut().unwrap().pop();
    assert!(upgrade_v0(&shorter).is_err());
    let Blobs {
        coverage,
        metrics,
        objects,
    } = v0();
    let mut one = [coverage, metrics.unwrap(), objects.unwrap()].concat();
    assert_eq!(findings_v0(&one).unwrap(), findings());
    one.push(0);
    assert!(findings_v0(&one).is_err());
}
