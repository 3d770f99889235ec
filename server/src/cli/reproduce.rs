//! `evswarm reproduce`: all runs of the thesis's experiments on worker threads, then the report.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use serde::Serialize;
use swarm::run::Phase;
use swarm::spec::EngineKind;

use super::checkpoint::{Checkpoint, Spent};
use super::progress::Meter;
use super::run::{Pace, already_complete, start, stop_flag};
use super::{Failure, output};
use crate::artifacts::{self, Finished, Timing};
use crate::reproduce::{self, Plan, PlannedRun, Settings};

/// Time between two looks at how far the workers are.
const LOOK_EVERY: Duration = Duration::from_millis(250);
const STEPS_PER_EPOCH: u32 = 2_000;

#[derive(Debug, clap::Args)]
pub struct ReproduceArguments {
    /// Directory for the runs and the report; what it holds of them already is kept.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Runs of each method on each arena [default: 15; 3 with --quick].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    seeds: Option<u32>,
    /// Counted epochs of a run [default: 2000; 200 with --quick].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    epochs: Option<u32>,
    /// Built-in arenas, separated by commas.
    #[arg(long, value_delimiter = ',', default_values = ["easy", "graph", "maze"])]
    arenas: Vec<String>,
    /// A rehearsal of minutes: 3 seeds and 200 epochs, too few for a verdict.
    #[arg(long)]
    quick: bool,
    /// Seeds for which im, ev-iter-c and curiosity-a are repeated under the engine rapier; 0 leaves
    /// that out [default: 5; 1 with --quick].
    #[arg(long, value_parser = clap::value_parser!(u32).range(0..=1_000))]
    rapier_seeds: Option<u32>,
    /// Runs at a time; no result depends on it [default: one a processor].
    #[arg(long, value_parser = super::threads)]
    threads: Option<usize>,
}

pub fn reproduce(arguments: &ReproduceArguments) -> Result<(), Failure> {
    let (seeds, epochs, rapier_seeds) = if arguments.quick {
        (3, 200, 1)
    } else {
        (15, 2_000, 5)
    };
    let seeds = arguments.seeds.unwrap_or(seeds);
    let plan = Plan::new(Settings {
        seeds,
        rapier_seeds: arguments.rapier_seeds.unwrap_or(rapier_seeds).min(seeds),
        epochs: arguments.epochs.unwrap_or(epochs),
        steps_per_epoch: STEPS_PER_EPOCH,
        arenas: arguments.arenas.clone(),
    })
    .map_err(Failure::WrongSpec)?;
    let threads = match arguments.threads {
        Some(threads) => threads,
        None => thread::available_parallelism().map_or(1, usize::from),
    };
    let stop = stop_flag()?;
    let verdicts = carry_out(&plan, &arguments.out, threads, &stop)?;
    for line in verdicts {
        output::say(line)?;
    }
    output::say(arguments.out.join("report.html").display())
}

/// Runs what is left to run, writes the report and `timing.json`; a line for each claim.
fn carry_out(
    plan: &Plan,
    out: &Path,
    threads: usize,
    stop: &AtomicBool,
) -> Result<Vec<String>, Failure> {
    let began = Instant::now();
    let cpu_s = artifacts::process_cpu_s();
    std::fs::create_dir_all(out).with_context(|| format!("cannot make {}", out.display()))?;
    let stepped = run_all(plan, out, threads, stop)?;
    let verdicts = reproduce::write_report(plan, out)?;
    let wall_s = began.elapsed().as_secs_f64();
    let timing = Document {
        schema: api::SCHEMA,
        runs: plan.runs.len(),
        robot_steps: plan.runs.iter().map(steps).sum(),
        this_time: ThisTime {
            wall_s,
            cpu_s: artifacts::process_cpu_s() - cpu_s,
            robot_steps: stepped,
            robot_steps_per_s: stepped as f64 / wall_s.max(1e-9),
            threads,
        },
        version: env!("CARGO_PKG_VERSION"),
    };
    let mut text = serde_json::to_vec_pretty(&timing)?;
    text.push(b'\n');
    reproduce::replace(&out.join("timing.json"), &text)?;
    Ok(verdicts)
}

/// `timing.json` of the whole; each run has its own.
#[derive(Serialize)]
struct Document {
    schema: u32,
    /// In the plan.
    runs: usize,
    /// Of all runs of the plan.
    robot_steps: u64,
    this_time: ThisTime,
    version: &'static str,
}

/// What the last execution did; a resumed one does less than the whole.
#[derive(Serialize)]
struct ThisTime {
    wall_s: f64,
    cpu_s: f64,
    robot_steps: u64,
    robot_steps_per_s: f64,
    threads: usize,
}

fn steps(run: &PlannedRun) -> u64 {
    run.spec.robot_steps()
}

/// Carries out every run that is not complete; robot-steps of this execution.
fn run_all(plan: &Plan, out: &Path, threads: usize, stop: &AtomicBool) -> Result<u64, Failure> {
    let total = plan.runs.iter().map(steps).sum();
    let mut left = Vec::new();
    for run in &plan.runs {
        if !already_complete(&run.directory(out), &run.spec)? {
            left.push(run);
        }
    }
    // The longest first, so that no thread is left alone with one at the end: rigid bodies, which
    // cost some thirty times as much a step, then the most steps.
    left.sort_by_key(|run| std::cmp::Reverse((run.engine == EngineKind::Rapier, steps(run))));
    let done_before = total - left.iter().map(|run| steps(run)).sum::<u64>();
    let finished_before = plan.runs.len() - left.len();
    if finished_before > 0 {
        tracing::info!("{finished_before} of {} runs are complete", plan.runs.len());
    }
    let work = Work {
        out,
        runs: &left,
        next: AtomicUsize::new(0),
        finished: AtomicUsize::new(0),
        stepped: AtomicU64::new(0),
        failed: AtomicBool::new(false),
        stop,
    };
    let mut meter = Meter::new("robot-steps", total, done_before);
    let outcomes = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.min(left.len()))
            .map(|_| scope.spawn(|| work.until_none_is_left()))
            .collect();
        while !workers.iter().all(|worker| worker.is_finished()) {
            let finished = finished_before + work.finished.load(Ordering::Relaxed);
            let what = format!("run {finished}/{}", plan.runs.len());
            let done = done_before + work.stepped.load(Ordering::Relaxed);
            meter.show(done.min(total), &what);
            thread::sleep(LOOK_EVERY);
        }
        workers.into_iter().try_for_each(|worker| {
            worker
                .join()
                .unwrap_or_else(|_| Err(anyhow!("a run panicked").into()))
        })
    });
    meter.finish();
    outcomes?;
    if stop.load(Ordering::SeqCst) && work.finished.load(Ordering::SeqCst) < left.len() {
        return Err(anyhow!("interrupted; the same command goes on from here").into());
    }
    Ok(work.stepped.into_inner())
}

/// What the workers share.
struct Work<'a> {
    out: &'a Path,
    runs: &'a [&'a PlannedRun],
    /// Index of the run that the next free worker takes.
    next: AtomicUsize,
    finished: AtomicUsize,
    /// Robot-steps of this execution.
    stepped: AtomicU64,
    /// Set by a worker that gives up, so that the others do too.
    failed: AtomicBool,
    stop: &'a AtomicBool,
}

impl Work<'_> {
    fn stops(&self) -> bool {
        self.stop.load(Ordering::SeqCst) || self.failed.load(Ordering::SeqCst)
    }

    /// Takes run after run. When stopped, leaves a checkpoint of the one at hand.
    fn until_none_is_left(&self) -> Result<(), Failure> {
        while !self.stops()
            && let Some(run) = self.runs.get(self.next.fetch_add(1, Ordering::Relaxed))
        {
            match self.carry_out(run) {
                Ok(true) => {
                    self.finished.fetch_add(1, Ordering::SeqCst);
                }
                Ok(false) => break,
                Err(failure) => {
                    self.failed.store(true, Ordering::SeqCst);
                    return Err(failure);
                }
            }
        }
        Ok(())
    }

    /// One run, from its checkpoint if there is one; whether it came to its end.
    fn carry_out(&self, planned: &PlannedRun) -> Result<bool, Failure> {
        let directory = planned.directory(self.out);
        let checkpoint = Checkpoint::open(&directory, planned.spec.key())?;
        let (mut run, before) = start(&planned.spec, &checkpoint)?;
        let (began, cpu_s) = (Instant::now(), artifacts::thread_cpu_s());
        let spent = || Spent {
            wall_s: before.wall_s + began.elapsed().as_secs_f64(),
            cpu_s: before.cpu_s + artifacts::thread_cpu_s() - cpu_s,
        };
        let mut done = run.progress().robot_steps_done;
        let mut pace = Pace::new();
        loop {
            let progress = pace.advance(&mut run);
            let steps = progress.robot_steps_done;
            self.stepped.fetch_add(steps - done, Ordering::Relaxed);
            done = steps;
            if progress.phase == Phase::Done {
                break;
            }
            if self.stops() {
                checkpoint.save(&run.snapshot(), spent())?;
                return Ok(false);
            }
            pace.save_if_due(&checkpoint, &run, spent);
        }
        let outcome = run
            .outcome()
            .context("the run is done but has no outcome")?;
        let Spent { wall_s, cpu_s } = spent();
        let timing = Timing {
            wall_s,
            cpu_s,
            robot_steps: outcome.robot_steps,
            threads: 1,
        };
        let visits = run.visits();
        let metrics = run.metrics();
        let tracks = run.tracks();
        let finished = Finished {
            spec: &planned.spec,
            outcome: &outcome,
            curve: run.curve(),
            visits: &visits,
            metrics: &metrics,
            tracks: &tracks,
        };
        artifacts::write_directory(&directory, &finished, &timing)?;
        checkpoint.remove();
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::fs;

    use super::*;

    const FILES: [&str; 4] = ["runs.csv", "claims.json", "report.md", "report.html"];

    fn plan() -> Plan {
        Plan::new(Settings {
            seeds: 2,
            epochs: 5,
            steps_per_epoch: 20,
            arenas: vec!["easy".to_owned(), "maze".to_owned()],
            rapier_seeds: 1,
        })
        .unwrap()
    }

    fn report(out: &Path) -> Vec<Vec<u8>> {
        FILES.map(|name| fs::read(out.join(name)).unwrap()).into()
    }

    fn all_of(plan: &Plan, out: &Path, threads: usize) -> Vec<String> {
        carry_out(plan, out, threads, &AtomicBool::new(false)).unwrap_or_else(|failure| {
            panic!("{failure:?}");
        })
    }

    #[test]
    fn threads_and_interruptions_change_no_byte() {
        let (plan, home) = (plan(), tempfile::tempdir().unwrap());
        let whole = home.path().join("whole");
        assert_eq!(all_of(&plan, &whole, 2).len(), 10);
        let expected = report(&whole);

        // Again: every run is complete, and the report is made of the same results.
        let first = fs::metadata(whole.join("runs.csv")).unwrap().len();
        all_of(&plan, &whole, 1);
        assert_eq!(report(&whole), expected);
        assert_eq!(fs::metadata(whole.join("runs.csv")).unwrap().len(), first);

        // Elsewhere, with some runs lost, one stopped in the middle and the report torn.
        let other = home.path().join("other");
        all_of(&plan, &other, 1);
        for run in plan.runs.iter().step_by(3) {
            fs::remove_dir_all(run.directory(&other)).unwrap();
        }
        fs::write(other.join("report.html"), "torn").unwrap();
        let half = &plan.runs[6];
        let checkpoint = Checkpoint::open(&half.directory(&other), half.spec.key()).unwrap();
        let mut run = swarm::run::Run::new(half.spec.run_spec()).unwrap();
        run.advance(33);
        checkpoint.save(&run.snapshot(), Spent::default()).unwrap();
        drop(checkpoint);
        all_of(&plan, &other, 2);
        assert_eq!(report(&other), expected);
        for entry in fs::read_dir(other.join("runs")).unwrap() {
            let name = entry.unwrap().file_name();
            assert_eq!(name.len(), 64, "{name:?} is left behind");
        }
    }

    #[test]
    fn stopped_it_says_how_to_go_on_and_writes_no_report() {
        let (plan, home) = (plan(), tempfile::tempdir().unwrap());
        let out = home.path().join("out");
        let failure = carry_out(&plan, &out, 2, &AtomicBool::new(true)).unwrap_err();
        assert!(format!("{failure:?}").contains("goes on from here"));
        assert!(!out.join("report.md").exists());
        all_of(&plan, &out, 2);
        assert!(out.join("report.md").exists());
    }

    #[test]
    fn a_directory_of_another_run_is_not_overwritten() {
        let (plan, home) = (plan(), tempfile::tempdir().unwrap());
        let taken = plan.runs[0].directory(home.path());
        fs::create_dir_all(&taken).unwrap();
        fs::write(taken.join("mine.txt"), "keep").unwrap();
        let stop = AtomicBool::new(false);
        assert!(carry_out(&plan, home.path(), 1, &stop).is_err());
        assert_eq!(fs::read_to_string(taken.join("mine.txt")).unwrap(), "keep");
    }

    #[test]
    fn the_report_holds_what_was_found() {
        let (plan, home) = (plan(), tempfile::tempdir().unwrap());
        all_of(&plan, home.path(), 2);
        let text = |name: &str| fs::read_to_string(home.path().join(name)).unwrap();
        // Ten methods on two arenas, and Ev-ITER-C with two shorter first phases on the maze.
        // Three methods on both arenas under rapier with one seed.
        assert_eq!(
            text("runs.csv").lines().count(),
            1 + 2 * (2 * 10 + 2) + 2 * 3
        );
        let claims: serde_json::Value = serde_json::from_str(&text("claims.json")).unwrap();
        assert_eq!(claims["claims"].as_array().unwrap().len(), 10);
        let markdown = text("report.md");
        for part in [
            "| maze |",
            "3341 ± 254 (3402)",
            "ev-iter-c:50",
            "evswarm reproduce --out DIR --seeds 2 --epochs 5 --arenas easy,maze \
             --rapier-seeds 1",
            "\"steps_per_epoch\": 20",
            "are a rehearsal",
        ] {
            assert!(markdown.contains(part), "{part}");
        }
        let html = text("report.html");
        assert_eq!(html.matches("<figure>").count(), 2 * 3);
        assert_eq!(html.matches("<image").count(), 2 * (2 * 10 + 2));
        for absent in ["<script", "NaN", "src=\"http", "/tmp"] {
            assert!(!html.contains(absent), "{absent}");
        }
    }
}
