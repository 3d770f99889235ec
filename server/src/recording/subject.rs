//! The header of a recording of a run.

use std::sync::Arc;

use arenas::Arena;
use recording::{DriveModel, Header, StageMark};
use serde_json::Value;
use swarm::run::StagePlan;

use crate::documents::{RecordRequest, ResolvedRun, Stretch};

/// What a recording of a run says of itself: the same whether the run recorded, whether it showed
/// its frames, and when.
pub fn header(spec: &ResolvedRun, request: &RecordRequest, stretch: Stretch) -> Header {
    let plain = spec.unrecorded();
    let run = spec.run_spec();
    let plan = run.plan();
    let trains = plan.iter().any(|stage| stage.in_training);
    let training = run.controller.training.as_ref().filter(|_| trains);
    let training = training.map(|training| &training.arena);
    let p = &run.robot.parameters;
    let limit = p.max_wheel_acceleration_rad_s2 * p.step_s;
    let objects = |arena: &Arc<Arena>| arena.objects().len();
    let objects = objects(&run.arena).max(training.map_or(0, objects));
    Header {
        subject: plain.key(),
        results_version: swarm::RESULTS_VERSION,
        // A resolved spec is JSON.
        spec: serde_json::to_value(plain.canonical()).unwrap_or_default(),
        arena: shown(&run.arena),
        training_arena: training.map(shown),
        body_radius_m: p.body_radius_m,
        step_s: p.step_s,
        steps_per_epoch: run.steps_per_epoch,
        resets: run.episodes == swarm::spec::Episodes::Reset,
        stages: plan.iter().map(mark).collect(),
        from_epoch: stretch.from_epoch,
        epochs: stretch.epochs,
        every_steps: request.every_steps,
        robots_total: run.robots,
        robots: request.robots.of(run.robots),
        objects: objects as u32,
        fields: request.fields,
        drive: DriveModel {
            top_speed_rad_s: p.max_wheel_speed_rad_s,
            acceleration_rad_s_step: (limit > 0.0).then_some(limit),
            advance_m_s: p.wheel_radius_m * p.step_s / 2.0,
            turn_s: p.wheel_radius_m * p.step_s / p.axle_m,
        },
    }
}

fn shown(arena: &Arc<Arena>) -> Value {
    // Numbers and names: JSON can hold them.
    serde_json::to_value(arena.to_format()).unwrap_or_default()
}

fn mark(stage: &StagePlan) -> StageMark {
    StageMark {
        phase: stage.phase.name().to_owned(),
        epochs: stage.epochs,
        in_training: stage.in_training,
        shows: stage.shows,
    }
}
