//! The messages of `/v1/runs/{id}/frames`, little-endian: the layout is in `docs/live-frames.md`.

use api::frames::PHASES;
use arenas::Squares;
use bytes::{BufMut, Bytes, BytesMut};
use swarm::run::Run;

/// Version of the messages, told by the first.
const VERSION: u32 = 1;

const HELLO: u32 = 0;
const FRAME: u32 = 1;
const SQUARES: u32 = 2;
const WAITING: u32 = 3;

/// Length and kind.
const HEAD_BYTES: usize = 8;
const FRAME_BYTES: usize = 56;
/// Bytes of a robot in a frame.
pub const ROBOT_BYTES: usize = 40;
const OBJECT_BYTES: usize = 12;
/// State and action of a robot without a table.
const NO_CHOICE: u16 = u16::MAX;
/// Flag of a frame whose robots are in the training arena.
const TRAINING: u32 = 1;
/// Flag of a frame whose robots learn.
const LEARNS: u32 = 2;

/// The first message, and a sign of life.
pub fn hello() -> Bytes {
    let mut message = begin(HELLO, 4);
    message.put_u32_le(VERSION);
    message.freeze()
}

/// Nobody steps the run at present.
pub fn waiting() -> Bytes {
    begin(WAITING, 0).freeze()
}

/// Where robots and objects are at this moment.
pub fn frame(run: &Run) -> Bytes {
    let (progress, step) = (run.progress(), run.step());
    let (bodies, objects) = (run.robots(), &run.objects_here().poses);
    let mut message = begin(
        FRAME,
        FRAME_BYTES + bodies.len() * ROBOT_BYTES + objects.len() * OBJECT_BYTES,
    );
    message.put_f64_le(step as f64);
    message.put_f64_le(progress.robot_steps_done as f64);
    message.put_f64_le(progress.robot_steps_total as f64);
    message.put_f64_le(step as f64 * run.spec().robot.parameters.step_s);
    let phase = progress.phase.name();
    let phase = PHASES.iter().position(|name| *name == phase);
    message.put_u32_le(phase.map_or(u32::MAX, |phase| phase as u32));
    message.put_u32_le(progress.epochs_done);
    message.put_u32_le(progress.epochs_total);
    let training = if run.is_training() { TRAINING } else { 0 };
    let learns = if run.learns() { LEARNS } else { 0 };
    message.put_u32_le(training | learns);
    // A spec has far fewer robots and objects than 2^32.
    message.put_u32_le(bodies.len() as u32);
    message.put_u32_le(objects.len() as u32);
    for (number, body) in bodies.iter().enumerate() {
        message.put_f32_le(body.x_m);
        message.put_f32_le(body.y_m);
        message.put_f32_le(libm::atan2f(body.sin, body.cos));
        for command in body.command {
            message.put_f32_le(command);
        }
        for value in body.reading.proximity {
            message.put_u16_le(value.clamp(0.0, 4095.0) as u16);
        }
        let choice = run.choice(number);
        let choice = choice.map_or([NO_CHOICE; 2], |(state, action)| {
            [state as u16, action as u16]
        });
        for number in choice {
            message.put_u16_le(number);
        }
    }
    for pose in objects {
        message.put_f32_le(pose.x_m);
        message.put_f32_le(pose.y_m);
        message.put_f32_le(libm::atan2f(pose.sin, pose.cos));
    }
    message.freeze()
}

/// What was entered of the target arena so far, and when first.
pub fn squares(run: &Run) -> Bytes {
    let squares = Squares::of(&run.spec().arena);
    covered(
        run.counted_steps(),
        &squares,
        &run.visits(),
        run.first_entry(),
    )
}

/// The same of counts that were kept.
pub fn covered(steps: u64, squares: &Squares, visits: &[u32], first: &[u64]) -> Bytes {
    let mut message = begin(SQUARES, 16 + visits.len() * 8);
    message.put_f64_le(steps as f64);
    message.put_u32_le(squares.columns());
    message.put_u32_le(squares.rows());
    for &count in visits {
        message.put_u32_le(count);
    }
    for square in 0..visits.len() {
        // 1 + steps, 0 for never.
        let first = first.get(square).copied().unwrap_or(0);
        message.put_f32_le(first as f32 - 1.0);
    }
    message.freeze()
}

/// The steps that a message of squares tells, as it has them; `None` of another.
pub fn steps_of_squares(message: &[u8]) -> Option<[u8; 8]> {
    let is_it = message.get(4..8)? == SQUARES.to_le_bytes();
    let steps = message.get(HEAD_BYTES..HEAD_BYTES + 8).filter(|_| is_it)?;
    steps.try_into().ok()
}

fn begin(kind: u32, body_bytes: usize) -> BytesMut {
    let mut message = BytesMut::with_capacity(HEAD_BYTES + body_bytes);
    // An arena has at most 1,000,000 squares, a run at most 100,000 robots: well below 2^32.
    message.put_u32_le((HEAD_BYTES - 4 + body_bytes) as u32);
    message.put_u32_le(kind);
    message
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::documents::{BuiltinArenas, resolve};
    use serde_json::json;

    fn run(method: &str, robots: u32) -> Run {
        let spec = json!({
            "arena": "easy", "robots": robots, "placement": "grid", "epochs": 3,
            "steps_per_epoch": 100,
            "controller": { "method": method },
        });
        Run::new(resolve(&spec, &BuiltinArenas).unwrap().run_spec()).unwrap()
    }

    fn u32_at(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    fn f32_at(bytes: &[u8], at: usize) -> f32 {
        f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    #[test]
    fn messages_say_their_length_and_hold_what_the_run_has() {
        let mut run = run("brownian", 3);
        run.advance(150);
        for message in [hello(), waiting(), frame(&run), squares(&run)] {
            assert_eq!(message.len(), 4 + u32_at(&message, 0) as usize);
        }
        let frame = frame(&run);
        assert_eq!(frame.len(), HEAD_BYTES + FRAME_BYTES + 3 * ROBOT_BYTES);
        assert_eq!(frame[8..16], 150.0_f64.to_le_bytes());
        assert_eq!([u32_at(&frame, 44), u32_at(&frame, 48)], [1, 3]);
        assert_eq!([u32_at(&frame, 52), u32_at(&frame, 56)], [0, 3]);
        for (number, body) in run.robots().iter().enumerate() {
            let at = HEAD_BYTES + FRAME_BYTES + number * ROBOT_BYTES;
            assert_eq!(
                (f32_at(&frame, at), f32_at(&frame, at + 4)),
                (body.x_m, body.y_m)
            );
            assert_eq!(u32_at(&frame, at + 36), u32::MAX);
        }
        let squares = squares(&run);
        assert_eq!([u32_at(&squares, 16), u32_at(&squares, 20)], [100, 100]);
        let steps = steps_of_squares(&squares).unwrap();
        assert_eq!(steps[..], (run.counted_steps() as f64).to_le_bytes());
        let visits = run.visits();
        let told: Vec<u32> = (0..10_000).map(|n| u32_at(&squares, 24 + 4 * n)).collect();
        assert_eq!(told, visits);
        let first = |n: usize| f32_at(&squares, 24 + 40_000 + 4 * n);
        assert!((0..10_000).all(|n| (first(n) >= 0.0) == (visits[n] > 0)));
    }

    #[test]
    fn a_learner_is_told_by_flag_and_choice() {
        let mut run = run("im", 2);
        run.advance(1);
        assert_eq!(u32_at(&frame(&run), 52), LEARNS);
        run.advance(u64::MAX);
        let frame = frame(&run);
        let choice = u32_at(&frame, HEAD_BYTES + FRAME_BYTES + 36);
        let (state, action) = run.choice(0).unwrap();
        assert_eq!(choice, state | action << 16);
    }
}
