//! Other processes: readers of frames and controllers, ended when they are dropped.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Result, bail};
use api::controller::Controller;
use api::external::{RobotSense, WheelCommand};
use api::reader::FrameReader;
use rustix::process::{Pid, Signal, kill_process};
use swarm::methods::BRAITENBERG_WEIGHTS;

/// Time between two looks of a reader, a fraction of that between two frames.
const LOOK: Duration = Duration::from_millis(4);

/// A process of its own.
pub struct Other(Child);

impl Other {
    /// This program as `reader` or `controller` of a run under a root.
    pub fn start(what: &str, run_id: &str, root: &Path) -> Result<Self> {
        let child = Command::new(std::env::current_exe()?)
            .args(["channels", "--be", what, run_id])
            .arg(root)
            .stdin(Stdio::null())
            .spawn()?;
        Ok(Self(child))
    }

    /// Any program.
    pub fn of(command: &mut Command) -> Result<Self> {
        Ok(Self(command.stdin(Stdio::null()).spawn()?))
    }

    /// Stops it without ending it.
    pub fn stop(&self) -> Result<()> {
        // A process id is above 0.
        let pid = Pid::from_raw(self.0.id() as i32);
        kill_process(pid.unwrap_or(Pid::INIT), Signal::STOP)?;
        Ok(())
    }

    /// Kills it.
    pub fn kill(&mut self) -> Result<()> {
        self.0.kill()?;
        self.0.wait()?;
        Ok(())
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        // It may have been killed before.
        drop(self.kill());
    }
}

/// Is one of the other processes, until it is killed.
pub fn be(be: &[String]) -> Result<()> {
    let [what, run_id, root] = be else {
        bail!("what, which run, under which root?");
    };
    let root = Path::new(root);
    if what == "controller" {
        let mut controller = Controller::open(root, run_id, 0)?;
        controller.serve(|_, robots, commands| {
            for (robot, command) in robots.iter().zip(commands) {
                act(robot, command);
            }
        })?;
        return Ok(());
    }
    let service = api::frames::frames_service(run_id);
    let frames = FrameReader::open_within(root, &service, Duration::from_secs(10))?;
    let mut sum = 0.0;
    loop {
        while let Some(frame) = frames.receive()? {
            sum += frame.payload().iter().map(|robot| robot.x_m).sum::<f32>();
        }
        std::hint::black_box(sum);
        std::thread::sleep(LOOK);
    }
}

fn act(robot: &RobotSense, command: &mut WheelCommand) {
    let mut sum = [0.0_f32; 2];
    for (weights, value) in BRAITENBERG_WEIGHTS.iter().zip(robot.sensors) {
        let part = 1.0 - value / 512.0;
        sum[0] += weights[0] * part;
        sum[1] += weights[1] * part;
    }
    command.left = (0.5 * sum[0]).clamp(-1.0, 1.0);
    command.right = (0.5 * sum[1]).clamp(-1.0, 1.0);
}
