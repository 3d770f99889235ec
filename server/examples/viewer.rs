//! Shows a run in the terminal: robots as arrows over what they have covered. The run needs the
//! channels `frames` and `coverage`: by `"channels": true` in its spec, or asked for over HTTP.
//!
//! `cargo run --release --example viewer -- RUN_ID`
#![allow(clippy::print_stdout, reason = "a command line program")]

use std::time::Duration;

use api::channels::run_service;
use api::frames::{RobotState, default_root};
use api::reader::{CoverageReader, FrameReader};
use clap::Parser;

/// Characters of a picture side by side; half as many lines.
const COLUMNS: usize = 72;
/// Time between two pictures.
const PAUSE: Duration = Duration::from_millis(100);

/// Shows a run in the terminal: robots as arrows over what they have covered.
#[derive(Parser)]
struct Arguments {
    /// The run.
    run_id: String,
}

/// The arrow of a heading.
fn arrow(robot: &RobotState) -> char {
    let eighths = robot.heading_sin.atan2(robot.heading_cos) / std::f32::consts::FRAC_PI_4;
    ['→', '↗', '↑', '↖', '←', '↙', '↓', '↘'][(eighths.round() as i32).rem_euclid(8) as usize]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Arguments { run_id } = Arguments::parse();
    let (root, wait) = (default_root(), Duration::from_secs(10));
    let frames = FrameReader::open_within(&root, &run_service(&run_id, "frames"), wait)?;
    let coverage = CoverageReader::open_within(&root, &run_service(&run_id, "coverage"), wait)?;
    let (mut squares, mut size, mut extent_m) = (Vec::new(), (0, 0), (1.0, 1.0));
    while let Some(frame) = frames.wait(wait)? {
        while let Some(picture) = coverage.receive()? {
            let header = picture.user_header();
            size = (header.columns as usize, header.rows as usize);
            extent_m = (header.width_m as f32, header.height_m as f32);
            squares = picture.payload().to_vec();
        }
        let robots = frame.payload();
        let lines = COLUMNS / 2;
        let mut picture = vec![vec![' '; COLUMNS]; lines];
        for (line, cells) in picture.iter_mut().enumerate() {
            for (column, cell) in cells.iter_mut().enumerate() {
                let (x, y) = (
                    column * size.0 / COLUMNS,
                    (lines - 1 - line) * size.1 / lines,
                );
                let entered = squares.get(y * size.0 + x).is_some_and(|it| it.entries > 0);
                *cell = if entered { '.' } else { ' ' };
            }
        }
        for robot in robots {
            let place = |share: f32, cells: usize| ((share * cells as f32) as usize).min(cells - 1);
            let line = lines - 1 - place(robot.y_m / extent_m.1, lines);
            picture[line][place(robot.x_m / extent_m.0, COLUMNS)] = arrow(robot);
        }
        print!("\x1b[2J\x1b[H");
        for cells in picture {
            println!("{}", cells.into_iter().collect::<String>());
        }
        let header = frame.user_header();
        println!(
            "{}  {:.1} s  {} robots",
            header.phase_name(),
            header.sim_time_s,
            header.robots
        );
        std::thread::sleep(PAUSE);
    }
    Ok(())
}
