//! Result directories, tables and pictures of small made-up runs.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;

use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use swarm::memory::MemoryPlan;
use swarm::run::{CurveRow, ObjectOutcome, Outcome, RobotMemory};
use swarm::world::ObjectPose;

use super::*;
use crate::documents::{self, BuiltinArenas, ResolvedRun};
use crate::store::Findings;

const SQUARES: u32 = 10;

fn run() -> ResolvedRun {
    let spec = json!({ "arena": {
        "name": "two-rooms", "width_m": 0.6, "height_m": 0.4, "squares": SQUARES,
        "walls_m": [[0.3, 0.0, 0.3, 0.25]],
        "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.5 }]
    } });
    documents::resolve(&spec, &BuiltinArenas).unwrap()
}

/// Visits of 0 to 12, row by row, and a mask without the outermost squares.
fn visits_and_mask() -> (Vec<u32>, Vec<bool>) {
    let visits =
        (0..SQUARES * SQUARES).map(|place| if place / SQUARES < 5 { place % 13 } else { 0 });
    let inner = |place: u32| (1..SQUARES - 1).contains(&place);
    let mask = (0..SQUARES * SQUARES).map(|place| inner(place % SQUARES) && inner(place / SQUARES));
    (visits.collect(), mask.collect())
}

fn outcome() -> Outcome {
    Outcome {
        metrics: vec![
            ("t50_steps", Some(swarm::metrics::Value::Count(100))),
            ("t90_steps", None),
            ("mean_coverage", Some(swarm::metrics::Value::Real(0.25))),
        ],
        coverage: CurveRow {
            epoch: 2,
            p1: 46,
            p2: 42,
            p5: 30,
            p10: 9,
        },
        reachable: 64,
        coverage_reachable: [38, 35, 24, 8],
        dwell: [46, 45, 40, 20],
        robot_steps: 4_000,
        collisions: 17,
        sensor_clusters: 3,
        actuator_clusters: 4,
        sensori_motor_clusters: 5,
        model: None,
        bytes: 678,
        memory_plan: MemoryPlan {
            sensor_clusters: 12,
            actuator_clusters: 8,
            sensori_motor_clusters: 24,
            sample: 72,
            actuator_sample: 4,
            lambda: 20,
            genomes: 2,
            bytes: 8_000,
        },
        memory: vec![
            RobotMemory {
                bytes: 7_000,
                clusters_saturated: 5,
            },
            RobotMemory {
                bytes: 7_100,
                clusters_saturated: 0,
            },
        ],
        objects: vec![ObjectOutcome {
            kind: "disc",
            pose: ObjectPose {
                x_m: 0.5,
                y_m: 0.25,
                cos: 1.0,
                sin: 0.0,
            },
            moved_m: 0.375,
            displaced_m: 0.125,
        }],
        state_sha256: "ab".to_owned(),
    }
}

#[test]
fn tables_say_what_they_hold() {
    let curve = [
        CurveRow {
            epoch: 1,
            p1: 4,
            p2: 3,
            p5: 2,
            p10: 1,
        },
        CurveRow {
            epoch: 2,
            p1: 8,
            p2: 7,
            p5: 6,
            p10: 5,
        },
    ];
    assert_eq!(
        curve_csv(&curve),
        "epoch,p1,p2,p5,p10\n1,4,3,2,1\n2,8,7,6,5\n"
    );
    assert_eq!(
        coverage_csv(&[0, 2, 0, 1], 2),
        "column,row,visits\n1,0,2\n1,1,1\n"
    );
    let (visits, _) = visits_and_mask();
    let (_, mask) = visits_and_mask();
    let coverage = coverage_json(run().arena(), &visits, &mask);
    assert_eq!(coverage.reachable, 64);
    // Squares outside the mask were entered too: they are counted, but not in the shares.
    assert!(coverage.fractions.p1 < f64::from(coverage.p1) / 64.0);
    let everywhere = coverage_json(run().arena(), &vec![3; visits.len()], &mask);
    assert_eq!((everywhere.p1, everywhere.fractions.p1), (100, 1.0));
    assert_eq!(
        (everywhere.fractions.p2, everywhere.fractions.p5),
        (1.0, 0.0)
    );
    assert_eq!(
        (coverage.p1, coverage.p2, coverage.p5, coverage.p10),
        (46, 42, 30, 10)
    );
    assert_eq!(coverage.visits.len(), SQUARES as usize);
    assert_eq!(coverage.visits[1][2], 12);
    let result = run_result(&outcome());
    assert_eq!((result.p5, result.fractions.p5), (30, 24.0 / 64.0));
    let none = run_result(&Outcome {
        reachable: 0,
        ..outcome()
    });
    assert_eq!(none.fractions.p1, 0.0);
}

#[test]
fn a_directory_holds_all_files_or_is_not_there() {
    let home = tempfile::tempdir().unwrap();
    let directory = home.path().join("deep/out");
    let (run, outcome) = (run(), outcome());
    let (visits, _) = visits_and_mask();
    let finished = Finished {
        spec: &run,
        outcome: &outcome,
        findings: &Findings {
            visits,
            ..Findings::default()
        },
        recording: None,
    };
    let timing = Timing {
        wall_s: 2.0,
        cpu_s: 3.5,
        robot_steps: 4_000,
        threads: 2,
    };
    let workspace = home.path().join("deep/out.partial");
    fs::create_dir_all(&workspace).unwrap();
    assert_eq!(is_complete(&directory), None);
    write_directory(&directory, &workspace, &finished, &timing).unwrap();
    assert_eq!(is_complete(&directory), Some(run.canonical_json()));
    let names = |directory: &std::path::Path| -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    let files = [
        "coverage.png",
        "curve.csv",
        "metrics.csv",
        "result.json",
        "robots.csv",
        "spec.json",
        "timing.json",
        "visits.npy",
    ];
    assert_eq!(names(&directory), files);
    let timing_json: Value =
        serde_json::from_slice(&fs::read(directory.join("timing.json")).unwrap()).unwrap();
    assert_eq!(timing_json["robot_steps_per_s"], 2_000.0);
    let result: api::RunResult =
        serde_json::from_slice(&fs::read(directory.join("result.json")).unwrap()).unwrap();
    assert_eq!(result, run_result(&outcome));

    // What is there is never written over.
    fs::write(directory.join("result.json"), "mine").unwrap();
    for _ in 0..2 {
        assert!(write_directory(&directory, &workspace, &finished, &timing).is_err());
    }
    assert_eq!(fs::read(directory.join("result.json")).unwrap(), b"mine");
}

#[test]
fn the_picture_is_the_same_to_the_byte_everywhere() {
    let (visits, mask) = visits_and_mask();
    let png = coverage_png(run().arena(), &visits, Some(&mask), &[]);
    assert!(png.starts_with(b"\x89PNG"));
    let digest = hex::encode(Sha256::digest(&png));
    // Changes with the drawing and with the versions of tiny-skia, png and the font, with nothing
    // else.
    let expected = "77ffa7213b8182b58fb18ebb61deff99636b407ee7c41230ee9cf46e3ca5450f";
    assert_eq!(digest, expected);
}

#[test]
fn the_legend_tells_counts_and_shares() {
    let (visits, mask) = visits_and_mask();
    let svg = coverage_svg(run().arena(), &visits, Some(&mask), &[]);
    for words in [
        "two-rooms",
        ">46<",
        ">42<",
        ">30<",
        ">10<",
        ">46.9 %<",
        ">not reachable<",
        ">x (m)<",
        ">0.6<",
    ] {
        assert!(svg.contains(words), "no {words} in {svg}");
    }
    let without = coverage_svg(run().arena(), &visits, None, &[]);
    assert!(!without.contains("not reachable") && !without.contains('%'));
}
