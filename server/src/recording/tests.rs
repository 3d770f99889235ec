//! A recording is the same to the last byte however the run was stepped, and shows what the run did.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;

use recording::{Header, Reader};
use serde_json::{Value, json};
use swarm::run::Run;

use super::*;
use crate::documents::{BuiltinArenas, ResolvedRun, Stretch, resolve};
use crate::runner;

/// Specs of every kind: both engines, objects, sharing, training, a baseline that shows.
fn specs() -> Vec<(&'static str, Value)> {
    let boxes = json!({
        "name": "boxes", "width_m": 1.0, "height_m": 1.0, "walls_m": [],
        "starts": [{ "x_m": 0.2, "y_m": 0.5, "heading_rad": 0.0 },
                   { "x_m": 0.2, "y_m": 0.3, "heading_rad": 0.0 }],
        "objects": [{ "kind": "box", "x_m": 0.3, "y_m": 0.5, "heading_rad": 0.1,
                      "width_m": 0.08, "height_m": 0.08, "mass_kg": 0.05, "friction": 0.3 }],
    });
    let learner = json!({ "method": "ev-iter-c", "train": { "arena": "easy", "epochs": 4 } });
    vec![
        (
            "ev-iter",
            json!({ "controller": learner, "epochs": 6, "steps_per_epoch": 70 }),
        ),
        (
            "rapier with objects",
            json!({ "arena": boxes, "engine": "rapier", "robots": 2,
                    "controller": { "method": "brownian" }, "epochs": 3, "steps_per_epoch": 120 }),
        ),
        (
            "sharing, continued, every third step",
            json!({ "controller": learner, "robots": 5, "placement": "random", "arena": "easy",
                    "sharing": { "mode": "arena" }, "episodes": "continue",
                    "record": { "every_steps": 3, "robots": [1, 4] },
                    "epochs": 4, "steps_per_epoch": 100 }),
        ),
        (
            "a baseline that trains elsewhere",
            json!({ "controller": { "method": "curiosity", "train": { "arena": "easy" } },
                    "epochs": 4, "steps_per_epoch": 60 }),
        ),
        (
            "long epochs of many robots",
            json!({ "controller": { "method": "brownian" }, "robots": 30, "placement": "random",
                    "arena": "easy", "epochs": 2, "steps_per_epoch": 2_000,
                    "record": { "every_steps": 1, "fields": ["pose", "command"] } }),
        ),
    ]
}

fn resolved(spec: &Value) -> ResolvedRun {
    let mut spec = spec.clone();
    if spec.get("record").is_none() {
        spec["record"] = json!({ "every_steps": 1 });
    }
    resolve(&spec, &BuiltinArenas).unwrap()
}

fn header_of(spec: &ResolvedRun) -> Header {
    let request = spec.record().unwrap();
    header(spec, request, Stretch::whole(&spec.run_spec()))
}

fn recorder(spec: &ResolvedRun, paths: &Paths, run: &Run) -> SharedRecorder {
    let recorder = Recorder::open(header_of(spec), paths, run, u64::MAX).unwrap();
    SharedRecorder::new(Some(recorder))
}

/// The recording of a run that is stepped in one go.
fn recorded(spec: &ResolvedRun, dir: &Path) -> Vec<u8> {
    let paths = Paths::new(dir, "whole");
    let mut run = Run::new(spec.run_spec()).unwrap();
    let mut observer = recorder(spec, &paths, &run);
    let ended = runner::step(&mut run, &|| false, &mut [&mut observer]);
    assert_eq!(ended, runner::Ended::Done);
    finish(&observer).unwrap();
    assert!(!paths.part.exists() && !paths.tail.exists());
    fs::read(&paths.whole).unwrap()
}

#[test]
fn a_run_that_breaks_off_and_goes_on_leaves_the_same_recording() {
    for (name, spec) in specs() {
        let home = tempfile::tempdir().unwrap();
        let spec = resolved(&spec);
        let whole = recorded(&spec, home.path());
        for steps in [37_u64, 100, 1_999] {
            let paths = Paths::new(home.path(), "broken");
            paths.remove();
            let mut saved: Option<Vec<u8>> = None;
            let mut breaks = 0;
            loop {
                let mut run = match &saved {
                    None => Run::new(spec.run_spec()).unwrap(),
                    Some(bytes) => Run::restore(spec.run_spec(), bytes).unwrap(),
                };
                let mut recorder = recorder(&spec, &paths, &run);
                run.advance_before(steps, Some(&mut recorder));
                if run.outcome().is_some() {
                    finish(&recorder).unwrap();
                    break;
                }
                let (snapshot, tail) = (run.snapshot(), recorder.tail().unwrap());
                // What comes after the checkpoint is lost, or has reached the file.
                run.advance_before(steps / 2 + breaks, Some(&mut recorder));
                assert!(tail.keep());
                saved = Some(snapshot);
                breaks += 1;
            }
            assert!(breaks > 0 || steps > 37, "{name}");
            let same = fs::read(&paths.whole).unwrap() == whole;
            assert!(same, "{name}, broken every {steps} steps");
        }
    }
}

#[test]
fn a_crash_at_any_file_operation_leaves_what_the_last_checkpoint_needs() {
    let home = tempfile::tempdir().unwrap();
    let spec = resolved(&specs()[4].1);
    let whole = recorded(&spec, home.path());
    let paths = Paths::new(home.path(), "broken");
    let mut run = Run::new(spec.run_spec()).unwrap();
    let mut first = recorder(&spec, &paths, &run);
    run.advance_before(1_700, Some(&mut first));
    let snapshot = run.snapshot();
    assert!(first.tail().unwrap().keep());
    run.advance_before(900, Some(&mut first));
    // A later tail, of a block after the checkpoint's, whose checkpoint was never written.
    assert!(first.tail().unwrap().keep());
    drop(first.take());
    // Opened twice: what the first has cut off is in the tail that it wrote.
    for _ in 0..2 {
        let run = Run::restore(spec.run_spec(), &snapshot).unwrap();
        drop(recorder(&spec, &paths, &run).take());
    }
    let mut run = Run::restore(spec.run_spec(), &snapshot).unwrap();
    let mut last = recorder(&spec, &paths, &run);
    run.advance_before(u64::MAX, Some(&mut last));
    finish(&last).unwrap();
    assert!(fs::read(&paths.whole).unwrap() == whole);
}

#[test]
fn a_recording_that_does_not_reach_to_the_checkpoint_is_not_gone_on_with() {
    let home = tempfile::tempdir().unwrap();
    let spec = resolved(&specs()[0].1);
    let paths = Paths::new(home.path(), "lost");
    let mut run = Run::new(spec.run_spec()).unwrap();
    run.advance(100);
    let open = |paths: &Paths| Recorder::open(header_of(&spec), paths, &run, u64::MAX);
    assert!(matches!(open(&paths), Err(OpenError::Short)));
    fs::write(&paths.part, b"EVSWREC2 and nothing").unwrap();
    assert!(matches!(open(&paths), Err(OpenError::Short)));
}

#[test]
fn a_recording_shows_what_the_run_did() {
    for (name, spec) in specs() {
        let home = tempfile::tempdir().unwrap();
        let spec = resolved(&spec);
        let bytes = recorded(&spec, home.path());
        let mut reader = Reader::open(std::io::Cursor::new(&bytes)).unwrap();
        assert!(reader.is_complete());
        let header = reader.header().clone();
        // Stepped one by one, without a recorder.
        let mut run = Run::new(spec.run_spec()).unwrap();
        let layout = *reader.layout();
        let mut block = reader.block(0).unwrap();
        for sample in layout.samples() {
            if sample >= block.first + block.count as u64 {
                block = reader.block(sample).unwrap();
            }
            let place = layout.place(sample);
            let due = place.arena_epoch * u64::from(header.steps_per_epoch) + u64::from(place.step);
            // The last step of an epoch is seen before robots are put back.
            let is_end = place.step == header.steps_per_epoch;
            if is_end {
                continue;
            }
            while run.step() < due {
                run.advance(1);
            }
            let at = (sample - block.first) as usize;
            for row in 0..block.rows {
                let number = header.robots.number(row) as usize;
                let body = &run.robots()[number];
                let [x_m, y_m, heading_rad] = block.pose(row, at);
                let near = |a: f64, b: f32| (a - f64::from(b)).abs() <= 0.51e-4;
                assert!(
                    near(x_m, body.x_m) && near(y_m, body.y_m),
                    "{name} {sample}"
                );
                assert!((heading_rad.cos() - f64::from(body.cos)).abs() < 1e-3);
                for (ticks, command) in block.command(row, at).iter().zip(body.command) {
                    assert!((ticks - f64::from(command)).abs() <= 0.51e-3);
                }
                if header.fields.sensors {
                    let read = block.sensors(row, at);
                    for (value, is) in read.iter().zip(body.reading.proximity) {
                        assert!((f32::from(*value) - is).abs() <= 0.51);
                    }
                }
            }
            if header.fields.decision && header.robots.len() == header.robots_total as usize {
                let mut row = 0;
                run.each_decision(&mut |decision| {
                    let kept = block.decision(row, at);
                    assert_eq!(kept.state.map(u32::from), Some(decision.state), "{name}");
                    assert_eq!(kept.action.map(u32::from), Some(decision.action), "{name}");
                    row += 1;
                });
                if row == 0 {
                    assert_eq!(block.decision(0, at).state, None);
                }
            }
            for (object, pose) in run.objects_here().poses.iter().enumerate() {
                let [x_m, ..] = block.object_pose(object, at);
                assert!((x_m - f64::from(pose.x_m)).abs() <= 0.51e-4, "{name}");
            }
        }
    }
}

#[test]
fn recording_changes_nothing_and_its_subject_is_the_run_without_it() {
    let (_, spec) = &specs()[0];
    let home = tempfile::tempdir().unwrap();
    let with = resolved(spec);
    let mut without = spec.clone();
    without["channels"] = json!(true);
    let without = resolve(&without, &BuiltinArenas).unwrap();
    assert_ne!(with.key(), without.key());
    assert_eq!(with.unrecorded().key(), without.unrecorded().key());
    assert_eq!(header_of(&with).subject, without.unrecorded().key());
    let paths = Paths::new(home.path(), "a");
    let mut run = Run::new(with.run_spec()).unwrap();
    let mut observer = recorder(&with, &paths, &run);
    runner::step(&mut run, &|| false, &mut [&mut observer]);
    let mut plain = Run::new(without.run_spec()).unwrap();
    plain.advance(u64::MAX);
    assert_eq!(plain.outcome(), run.outcome());
}

#[test]
fn a_recording_that_is_too_large_is_cut_and_the_run_goes_on() {
    let home = tempfile::tempdir().unwrap();
    let spec = resolved(&specs()[4].1);
    let paths = Paths::new(home.path(), "a");
    let mut run = Run::new(spec.run_spec()).unwrap();
    let opened = Recorder::open(header_of(&spec), &paths, &run, 300_000).unwrap();
    let mut observer = SharedRecorder::new(Some(opened));
    let ended = runner::step(&mut run, &|| false, &mut [&mut observer]);
    assert_eq!(ended, runner::Ended::Done);
    let why = finish(&observer).unwrap_err();
    assert!(why.contains("more than 300000 bytes"), "{why}");
    let (file, stage) = paths.open().unwrap().unwrap();
    assert_eq!(stage, Stage::Cut);
    let reader = Reader::open(file).unwrap();
    assert!(!reader.is_complete() && reader.samples().end > 0);
    // It is not begun again from a checkpoint.
    let mut run = Run::new(spec.run_spec()).unwrap();
    run.advance(100);
    let again = Recorder::open(header_of(&spec), &paths, &run, 300_000);
    assert!(matches!(again, Err(OpenError::GivenUp)));
    // Not even where what there was of it has made room.
    paths.remove_bytes();
    assert!(paths.open().unwrap().is_none());
    let again = Recorder::open(header_of(&spec), &paths, &run, 300_000);
    assert!(matches!(again, Err(OpenError::GivenUp)));
    // From its beginning it is.
    let run = Run::new(spec.run_spec()).unwrap();
    let begun = recorder(&spec, &paths, &run);
    assert!(begun.tail().is_some() && paths.part.exists() && !paths.given_up.exists());
    drop(begun.take());
}
