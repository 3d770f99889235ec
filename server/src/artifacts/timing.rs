//! `timing.json`: how long a run took and on what; the one file that differs between equal runs.

use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;

/// What a run cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Seconds by the clock on the wall, interruptions left out.
    pub wall_s: f64,
    /// Seconds of processor time over all threads.
    pub cpu_s: f64,
    /// Robot-steps, uncounted phases included.
    pub robot_steps: u64,
    /// Threads that could be used.
    pub threads: usize,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    wall_s: f64,
    cpu_s: f64,
    robot_steps_per_s: f64,
    threads: usize,
    machine: Machine<'a>,
    version: &'a str,
}

#[derive(Serialize)]
struct Machine<'a> {
    system: &'a str,
    architecture: &'a str,
    processor: Option<String>,
    logical_cpus: usize,
}

impl Timing {
    /// The text of `timing.json`.
    pub(super) fn to_document(self) -> impl Serialize {
        Document {
            schema: api::SCHEMA,
            wall_s: self.wall_s,
            cpu_s: self.cpu_s,
            robot_steps_per_s: self.robot_steps as f64 / self.wall_s.max(1e-9),
            threads: self.threads,
            machine: Machine {
                system: std::env::consts::OS,
                architecture: std::env::consts::ARCH,
                processor: processor(),
                logical_cpus: std::thread::available_parallelism().map_or(1, usize::from),
            },
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// The processor's name, where the system tells it.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Processor time of all threads of this process so far, seconds.
pub fn process_cpu_s() -> f64 {
    seconds(ClockId::ProcessCPUTime)
}

/// Processor time of this thread so far, seconds.
pub fn thread_cpu_s() -> f64 {
    seconds(ClockId::ThreadCPUTime)
}

fn seconds(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
