//! What is told is what a recording of the same run shows.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::explanation::Explanation;
use recording::{Reader, SamplePlace};
use serde_json::{Value, json};
use swarm::run::Run;

use super::*;
use crate::documents::{BuiltinArenas, ResolvedRun, Stretch, resolve};
use crate::recording::{Paths, Recorder, SharedRecorder, finish, header};
use crate::runner;

fn resolved(spec: &Value) -> ResolvedRun {
    resolve(spec, &BuiltinArenas).unwrap()
}

fn explained(spec: &Value) -> Explanation {
    let run = Run::new(resolved(spec).run_spec()).unwrap();
    explain(run, &|| false, &mut []).unwrap()
}

/// A run that covers 3.6 % of what it can reach, under the defaults that it was made with.
fn stuck() -> Value {
    let mut spec: Value = serde_json::from_str(include_str!("office_stuck.json")).unwrap();
    for part in ["controller", "robot"] {
        spec[part]["preset"] = "stepwise".into();
    }
    spec
}

#[test]
fn a_run_that_got_stuck_is_explained_in_a_sentence_that_its_recording_bears_out() {
    let mut spec = stuck();
    let explanation = explained(&spec);
    assert!(explanation.is_odd, "{explanation:#?}");
    let sentence = &explanation.sentence;
    assert_eq!(sentence.matches(". ").count(), 0, "{sentence}");

    // The longest stretch, as the recording has it.
    let told = explanation
        .standing
        .first()
        .or(explanation.confined.first());
    let stretch = told.unwrap();
    spec["record"] = json!({ "every_steps": 1 });
    let spec = resolved(&spec);
    let home = tempfile::tempdir().unwrap();
    let paths = Paths::new(home.path(), "stuck");
    let mut run = Run::new(spec.run_spec()).unwrap();
    let request = spec.record().unwrap();
    let header = header(&spec, request, Stretch::whole(&spec.run_spec()));
    let recorder = Recorder::open(header, &paths, &run, u64::MAX).unwrap();
    let mut recorder = SharedRecorder::new(Some(recorder));
    runner::step(&mut run, &|| false, &mut [&mut recorder]);
    finish(&recorder).unwrap();
    let (file, _) = paths.open().unwrap().unwrap();
    let mut reader = Reader::open(file).unwrap();
    let radius_m = if explanation.standing.is_empty() {
        0.05
    } else {
        0.001
    };
    let place = SamplePlace {
        arena_epoch: stretch.epoch,
        step: stretch.epoch_step,
    };
    let first = reader.layout().at_or_after(place);
    let (mut in_state, mut in_action) = (0, 0);
    for sample in first..=first + stretch.steps {
        let block = reader.block(sample).unwrap();
        let at = (sample - block.first) as usize;
        let [x_m, y_m, _] = block.pose(stretch.robot as usize, at);
        let off_m = ((x_m - stretch.x_m).powi(2) + (y_m - stretch.y_m).powi(2)).sqrt();
        // Both are rounded to 0.1 mm.
        assert!(off_m <= radius_m + 0.0002, "{off_m} at {sample}");
        if sample > first {
            let decision = block.decision(stretch.robot as usize, at);
            in_state += u64::from(decision.state.map(u32::from) == Some(stretch.states[0].number));
            in_action +=
                u64::from(decision.action.map(u32::from) == Some(stretch.actions[0].number));
        }
    }
    assert_eq!(in_state, stretch.states[0].steps);
    assert_eq!(in_action, stretch.actions[0].steps);
    let best = stretch.scores.iter().map(|scored| scored.score);
    assert!(best.clone().fold(f64::MIN, f64::max) >= best.fold(f64::MAX, f64::min));
}

#[test]
fn a_run_that_walks_about_is_not_odd() {
    let spec = json!({
        "controller": { "method": "brownian" }, "epochs": 5, "steps_per_epoch": 1_000,
    });
    let explanation = explained(&spec);
    let shares = explanation.behaviours.iter().map(|b| b.share);
    assert!(shares.sum::<f64>() <= 1.0, "{explanation:#?}");
    assert_eq!((explanation.epochs, explanation.robots_watched), (5, 1));
    assert_eq!(explanation.simulated_robot_steps, 5_000);
}
