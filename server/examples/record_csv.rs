//! Records a run's frames to CSV on standard output: a line for each robot of each frame. With
//! `--lossless` of every step, for which the run waits; ask for that before:
//!
//! `curl -d '{"lossless": {"readers": 1}}' -H 'content-type: application/json' .../v1/runs/RUN_ID/channels`
//!
//! `cargo run --release --example record_csv -- RUN_ID --lossless >frames.csv`

use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::time::Duration;

use api::channels::run_service;
use api::frames::default_root;
use api::reader::FrameReader;
use clap::Parser;

#[derive(Parser)]
struct Arguments {
    /// The run.
    run_id: String,
    /// Every frame, not the latest.
    #[arg(long)]
    lossless: bool,
    /// Folder that the server uses for its channels.
    #[arg(long, default_value_os_t = default_root())]
    root: PathBuf,
    /// Time to rest after each frame: for tests.
    #[arg(long, default_value_t = 0, hide = true)]
    delay_ms: u64,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let name = if arguments.lossless {
        "lossless"
    } else {
        "frames"
    };
    let service = run_service(&arguments.run_id, name);
    let wait = Duration::from_secs(10);
    let frames = FrameReader::open_within(&arguments.root, &service, wait)?;
    let mut out = BufWriter::new(std::io::stdout().lock());
    writeln!(
        out,
        "arena_step,sim_time_s,robot,x_m,y_m,heading_rad,left,right"
    )?;
    // A run that waits for its first frame may take its time.
    while let Some(frame) = frames.wait(Duration::from_secs(60))? {
        let header = frame.user_header();
        for robot in frame.payload() {
            writeln!(
                out,
                "{},{:?},{},{:?},{:?},{:?},{:?},{:?}",
                header.arena_step,
                header.sim_time_s,
                robot.number,
                robot.x_m,
                robot.y_m,
                robot.heading_sin.atan2(robot.heading_cos),
                robot.commands[0],
                robot.commands[1],
            )?;
        }
        std::thread::sleep(Duration::from_millis(arguments.delay_ms));
    }
    out.flush()?;
    Ok(())
}
