//! A controller of one's own: the Braitenberg vehicle that is also built in (`braitenberg`), from
//! outside. Start it, then a run with `"controller": {"method": "external"}`:
//!
//! `cargo run --release --example braitenberg -- RUN_ID [CONTROLLER]`
#![allow(clippy::print_stderr, reason = "an example")]

use api::controller::Controller;
use api::external::{RobotSense, WheelCommand};
use clap::Parser;

/// Steers a run as the method `braitenberg` does.
#[derive(Parser)]
struct Arguments {
    /// The run.
    run_id: String,
    /// Which of the run's controllers it is.
    #[arg(default_value_t = 0)]
    controller: usize,
}

/// What ps0 to ps7 add to the left and to the right wheel.
const WEIGHTS: [[f32; 2]; 8] = [
    [0.942, -0.22],
    [0.63, -0.1],
    [0.5, -0.06],
    [-0.06, -0.06],
    [-0.06, -0.06],
    [-0.06, 0.5],
    [-0.19, 0.63],
    [-0.13, 0.942],
];

fn act(robot: &RobotSense, command: &mut WheelCommand) {
    let mut sum = [0.0_f32; 2];
    for (weights, value) in WEIGHTS.iter().zip(robot.sensors) {
        let part = 1.0 - value / 512.0;
        sum[0] += weights[0] * part;
        sum[1] += weights[1] * part;
    }
    command.left = (0.5 * sum[0]).clamp(-1.0, 1.0);
    command.right = (0.5 * sum[1]).clamp(-1.0, 1.0);
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Arguments {
        run_id,
        controller: number,
    } = Arguments::parse();
    let mut controller = Controller::open(&api::frames::default_root(), &run_id, number)?;
    eprintln!("steers {run_id}");
    controller.serve(|_, robots, commands| {
        for (robot, command) in robots.iter().zip(commands) {
            act(robot, command);
        }
    })?;
    Ok(())
}
