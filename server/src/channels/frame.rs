//! What a frame shows of a run.

use api::frames::{FRAMES_VERSION, FrameHeader, ObjectState, RobotState};
use swarm::run::{Phase, Progress, Run};
use swarm::world::{Bodies, Body, Objects};

use super::slot::Frame;

/// What a frame shows beside robots and objects.
#[derive(Clone, Copy, Debug)]
pub struct FrameInfo {
    /// Steps of the arena so far, all phases.
    pub arena_step: u64,
    /// How far the run is.
    pub progress: Progress,
    /// Control step, simulated seconds.
    pub step_s: f64,
}

impl FrameInfo {
    /// Of the run as it is now.
    pub fn of(run: &Run) -> Self {
        Self {
            arena_step: run.step(),
            progress: run.progress(),
            step_s: run.spec().robot.parameters.step_s,
        }
    }

    /// The header of a frame of so many robots.
    pub(super) fn header(&self, robots: usize) -> FrameHeader {
        let progress = &self.progress;
        FrameHeader {
            sequence: 0, // counted by the thread that sends
            arena_step: self.arena_step,
            robot_steps_done: progress.robot_steps_done,
            robot_steps_total: progress.robot_steps_total,
            sim_time_s: self.arena_step as f64 * self.step_s,
            step_s: self.step_s,
            version: FRAMES_VERSION,
            phase: phase_code(progress.phase),
            epochs_done: progress.epochs_done,
            epochs_total: progress.epochs_total,
            robots: u32::try_from(robots).unwrap_or(u32::MAX),
            reserved: 0,
        }
    }
}

/// Index of the phase in `api::frames::PHASES`.
pub(super) fn phase_code(phase: Phase) -> u32 {
    match phase {
        Phase::Babbling => 0,
        Phase::Evolution => 1,
        Phase::Repository => 2,
        Phase::Exploration => 3,
        Phase::Done => 4,
    }
}

/// A robot in a frame.
#[inline]
pub(super) fn robot_state(number: usize, body: &Body) -> RobotState {
    RobotState {
        number: number as u32,
        x_m: body.x_m,
        y_m: body.y_m,
        heading_cos: body.cos,
        heading_sin: body.sin,
        sensors: body.reading.proximity,
        commands: body.command,
    }
}

/// Writes a moment into a frame.
pub(super) fn fill(frame: &mut Frame, bodies: &Bodies, objects: &Objects, info: &FrameInfo) {
    frame.header = info.header(bodies.len());
    frame.robots.clear();
    let robots = bodies.iter().enumerate();
    frame
        .robots
        .extend(robots.map(|(number, body)| robot_state(number, body)));
    frame.objects.clear();
    let figures = objects.poses.iter().zip(&objects.moved_m);
    frame
        .objects
        .extend(figures.map(|(pose, &moved_m)| ObjectState {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: libm::atan2f(pose.sin, pose.cos),
            moved_m: moved_m as f32,
        }));
}
