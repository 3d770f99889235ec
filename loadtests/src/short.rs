//! `loadtests short`: runs of ten steps, where all that is not stepping shows: how many a second go
//! through the service, and what the start of `evswarm run` costs. Programs take turns.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use crate::client::Client;
use crate::instructions::load_average;
use crate::measure::quantile;
use crate::server::{self, Server, TICKS_A_SECOND};

/// How much.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Another `evswarm` to compare with.
    #[arg(long)]
    against: Option<PathBuf>,
    /// Rounds; each measures every program once.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Runs of a job.
    #[arg(long, default_value_t = 4_000)]
    runs: u64,
    /// Threads that step runs.
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Starts of `evswarm run` a round.
    #[arg(long, default_value_t = 20)]
    starts: u32,
    /// Where data and results go, for a moment [default: the system's temporary directory].
    #[arg(long)]
    dir: Option<PathBuf>,
}

/// What one program did in one round.
struct Round {
    runs_a_second: f64,
    /// Processor time of workers, of a run.
    worker_ms: f64,
    /// Processor time of a start.
    start_ms: f64,
}

/// Measures, and prints a line for each program and round, and the medians.
///
/// # Errors
/// When a program does not do as it is asked.
#[allow(clippy::print_stdout, reason = "the table is the program's output")]
pub fn run(options: &Options) -> Result<()> {
    let own = server::program()?;
    let programs: Vec<&Path> = options.against.iter().map(PathBuf::as_path).collect();
    let programs = [&programs[..], &[&own]].concat();
    let dir = options.dir.clone().unwrap_or_else(std::env::temp_dir);
    // Deleted at the end: files made soon after others were deleted cost more.
    let home = tempfile::tempdir_in(&dir)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let mut rounds: Vec<Vec<Round>> = programs.iter().map(|_| Vec::new()).collect();
    println!("program  runs/s  worker ms/run  start ms");
    for number in 0..options.rounds {
        for (place, program) in programs.iter().enumerate() {
            let home = home.path().join(format!("{number}-{place}"));
            std::fs::create_dir(&home)?;
            let (runs_a_second, worker_ms) =
                runtime.block_on(through_the_service(options, program, &home))?;
            let start_ms = starts(options, program, &home)?;
            println!("{place:>7} {runs_a_second:>7.0} {worker_ms:>14.2} {start_ms:>9.1}");
            rounds[place].push(Round {
                runs_a_second,
                worker_ms,
                start_ms,
            });
        }
    }
    for (program, rounds) in programs.iter().zip(&rounds) {
        let median = |figure: fn(&Round) -> f64| {
            let mut all: Vec<f64> = rounds.iter().map(figure).collect();
            all.sort_by(f64::total_cmp);
            quantile(&all, 0.5)
        };
        println!(
            "medians of {} rounds: {:.0} runs a second, {:.2} ms of a worker each; start {:.1} ms  ({})",
            rounds.len(),
            median(|round| round.runs_a_second),
            median(|round| round.worker_ms),
            median(|round| round.start_ms),
            program.display(),
        );
    }
    println!("load average {}, this program included", load_average());
    Ok(())
}

fn spec() -> Value {
    json!({ "arena": "easy", "controller": { "method": "brownian" },
            "epochs": 1, "steps_per_epoch": 10 })
}

/// Runs a second from the post of a job to its end, and processor time of workers, ms a run.
async fn through_the_service(options: &Options, program: &Path, home: &Path) -> Result<(f64, f64)> {
    let server = Server::start_program(program, home, options.threads, None)?;
    let mut client = Client::new(server.address());
    let job = json!({ "base": spec(), "seeds": { "first": 1, "count": options.runs } });
    let before_s = server.stepping_cpu_s()?;
    let started = Instant::now();
    let answer = client.post("/v1/jobs", Some(job.to_string())).await?;
    ensure!(answer.status == 201, "{:?}", answer.body);
    client.newest_job_is_done().await?;
    let wall_s = started.elapsed().as_secs_f64();
    let runs = options.runs as f64;
    let cpu_s = server.stepping_cpu_s()? - before_s;
    Ok((runs / wall_s, cpu_s * 1e3 / runs))
}

/// Processor time of `evswarm run` of ten steps, ms.
fn starts(options: &Options, program: &Path, home: &Path) -> Result<f64> {
    let spec_file = home.join("ten-steps.json");
    std::fs::write(&spec_file, spec().to_string())?;
    let before = ticks_of_children()?;
    for number in 0..options.starts {
        let done = Command::new(program)
            .arg("run")
            .arg(&spec_file)
            .arg("--out")
            .arg(home.join(format!("out-{number}")))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()?;
        ensure!(done.success(), "evswarm run: {done}");
    }
    let ticks = ticks_of_children()? - before;
    Ok(ticks as f64 / TICKS_A_SECOND * 1e3 / f64::from(options.starts))
}

/// User and system time of children that have ended, in ticks.
fn ticks_of_children() -> Result<u64> {
    server::ticks(Path::new("/proc/self/stat"), [16, 17]).context("no /proc/self/stat")
}
