//! `evswarm reproduce`: the thesis's experiments as one job of a scheduler of its own, then the
//! report.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use api::State;
use serde::Serialize;
use serde_json::{Map, Value};

use super::progress::Meter;
use super::{Failure, output};
use crate::artifacts;
use crate::channels::ChannelSettings;
use crate::documents::{self, ExpandedJob};
use crate::recording::Limits;
use crate::reproduce::{Plan, Report, Settings, replace};
use crate::runner::default_run_memory_bytes;
use crate::scheduler::{Scheduler, SchedulerConfig, new_job};
use crate::stop::Stop;
use crate::store::{Created, Intent, JobKey, JobRequest, JobView, RunState, Store};

/// Time between two looks at how far the job is.
const LOOK_EVERY: Duration = Duration::from_millis(250);
const STEPS_PER_EPOCH: u32 = 2_000;

#[derive(Debug, clap::Args)]
pub struct ReproduceArguments {
    /// Directory for the report and, in `data`, the runs; what it holds of them already is kept.
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
    /// Fields that every run has, a JSON object as a run spec has them, such as
    /// {"controller": {"preset": "printed"}}: the claims under other settings.
    #[arg(long, value_name = "FILE")]
    base: Option<PathBuf>,
    /// Runs at a time; no result depends on it [default: one a processor].
    #[arg(long, value_parser = super::values::threads)]
    threads: Option<usize>,
}

pub fn reproduce(arguments: &ReproduceArguments) -> Result<(), Failure> {
    let (seeds, epochs, rapier_seeds) = if arguments.quick {
        (3, 200, 1)
    } else {
        (15, 2_000, 5)
    };
    let seeds = arguments.seeds.unwrap_or(seeds);
    let settings = Settings {
        seeds,
        rapier_seeds: arguments.rapier_seeds.unwrap_or(rapier_seeds).min(seeds),
        epochs: arguments.epochs.unwrap_or(epochs),
        steps_per_epoch: STEPS_PER_EPOCH,
        arenas: arguments.arenas.clone(),
    };
    let threads = match arguments.threads {
        Some(threads) => threads,
        None => thread::available_parallelism().map_or(1, usize::from),
    };
    let base = match &arguments.base {
        Some(path) => read_base(path)?,
        None => Map::new(),
    };
    let stop = Stop::on_signals(super::EXIT_FAILED.into())?;
    let verdicts = carry_out(settings, base, &arguments.out, threads, &stop)?;
    for line in verdicts {
        output::say(line)?;
    }
    output::say(arguments.out.join("report.html").display())
}

/// The JSON object of a file.
fn read_base(path: &Path) -> Result<Map<String, Value>, Failure> {
    let shown = path.display();
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {shown}"))?;
    match documents::parse(&text).map_err(Failure::WrongSpec)? {
        Value::Object(base) => Ok(base),
        _ => Err(anyhow!("{shown} holds no JSON object").into()),
    }
}

/// Has the scheduler do what is left to do, writes the report and `timing.json`; a line for each
/// claim.
fn carry_out(
    settings: Settings,
    base: Map<String, Value>,
    out: &Path,
    threads: usize,
    stop: &Stop,
) -> Result<Vec<String>, Failure> {
    let began = Instant::now();
    let cpu_s = artifacts::process_cpu_s();
    let job = settings.job_over(&base).map_err(Failure::WrongSpec)?;
    let plan = Plan::new(settings, &job).over(base);
    let store = Arc::new(Store::open(&out.join("data"))?);
    let runs = job.runs.len() as u64;
    let seq = submit(&store, job, &plan.settings.document(&plan.base))?;
    let before = find(&store, seq)?;
    let stepped_before = before.robot_steps_done;
    finish(&store, &before, runs, threads, stop)?;
    let report = Report::new(&plan, &store)?;
    report.write(out)?;
    let after = find(&store, seq)?;
    let wall_s = began.elapsed().as_secs_f64();
    let robot_steps = after.robot_steps_total.saturating_sub(stepped_before);
    let timing = Document {
        schema: api::SCHEMA,
        runs,
        robot_steps: after.robot_steps_total,
        this_time: ThisTime {
            wall_s,
            cpu_s: artifacts::process_cpu_s() - cpu_s,
            robot_steps,
            robot_steps_per_s: robot_steps as f64 / wall_s.max(1e-9),
            threads,
        },
        version: env!("CARGO_PKG_VERSION"),
    };
    let mut text = serde_json::to_vec_pretty(&timing)?;
    text.push(b'\n');
    replace(&out.join("timing.json"), &text)?;
    Ok(report.verdicts)
}

/// `timing.json` of the whole.
#[derive(Serialize)]
struct Document {
    schema: u32,
    /// In the plan.
    runs: u64,
    /// Of all runs of the plan.
    robot_steps: u64,
    this_time: ThisTime,
    version: &'static str,
}

/// What the last execution did; a resumed one does less than the whole. A run that was killed
/// counts in full.
#[derive(Serialize)]
struct ThisTime {
    wall_s: f64,
    cpu_s: f64,
    robot_steps: u64,
    robot_steps_per_s: f64,
    threads: usize,
}

/// Stores the job, unless an earlier execution has; what failed then is tried again. Jobs of other
/// settings are held, so that only runs of this one are stepped.
fn submit(store: &Store, job: ExpandedJob, document: &Value) -> anyhow::Result<JobKey> {
    let ids: Vec<String> = job.runs.iter().map(|run| run.key()).collect();
    let ids = ids.join("\n");
    let mut request = JobRequest::new(ids.as_bytes(), None);
    request.idempotency_key = Some(request.sha256.clone());
    request.document = Some(document.to_string());
    let job = new_job(job, request, &Limits::DEFAULT).map_err(|errors| {
        let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
        anyhow!("{}", errors.join("; "))
    })?;
    let created = store.create_job(&job, u64::MAX)?;
    let (Created::New(seq, _) | Created::Replayed(seq)) = created;
    let mut newest = None;
    while let Some(other) = store.jobs(newest, 1)?.pop() {
        newest = Some(other.seq);
        if other.seq != seq {
            store.set_intent(other.seq, Intent::Paused)?;
        }
    }
    store.retry(seq)?;
    Ok(seq)
}

fn find(store: &Store, seq: JobKey) -> anyhow::Result<JobView> {
    store.job(seq)?.context("the job is gone")
}

/// Waits until the scheduler has finished the job.
fn finish(
    store: &Arc<Store>,
    job: &JobView,
    runs: u64,
    threads: usize,
    stop: &Stop,
) -> anyhow::Result<()> {
    if job.counts.done > 0 {
        tracing::info!("{} of {runs} runs are complete", job.counts.done);
    }
    if job.counts.done == runs {
        return Ok(());
    }
    let workers = threads
        .try_into()
        .context("at least one thread is needed")?;
    let config = SchedulerConfig {
        workers,
        run_memory_bytes: default_run_memory_bytes(workers),
        unfinished_limit: u64::MAX,
        keep_every_epochs: None,
        recordings: Limits::DEFAULT,
        channels: ChannelSettings::default(),
    };
    let scheduler = Scheduler::start(Arc::clone(store), config)?;
    let done = |view: &JobView| scheduler.progress(view).fraction;
    let mut meter = Meter::of_share(done(&find(store, job.seq)?));
    let state = loop {
        let view = find(store, job.seq)?;
        let state = view.intent.job_state(&view.counts);
        if state.is_final() || stop.is_asked() {
            break state;
        }
        meter.show_share(done(&view), &format!("run {}/{runs}", view.counts.done));
        thread::sleep(LOOK_EVERY);
    };
    meter.finish();
    scheduler.shut_down();
    match state {
        State::Done => Ok(()),
        State::Failed => Err(failure(store, job.seq)?),
        _ => Err(anyhow!("interrupted; the same command goes on from here")),
    }
}

/// What went wrong with the first run that failed.
fn failure(store: &Store, job: JobKey) -> anyhow::Result<anyhow::Error> {
    let failed = store
        .all_runs(job)?
        .into_iter()
        .find_map(|run| match run.state {
            RunState::Failed { reason } => Some(format!("run {} failed: {reason}", run.id)),
            _ => None,
        });
    Ok(anyhow!(failed.unwrap_or_else(|| "a run failed".to_owned())))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::fs;

    use super::*;
    use crate::store::Checkpoint;

    const FILES: [&str; 4] = ["runs.csv", "claims.json", "report.md", "report.html"];

    fn settings() -> Settings {
        Settings {
            seeds: 2,
            epochs: 5,
            steps_per_epoch: 20,
            arenas: vec!["easy".to_owned(), "maze".to_owned()],
            rapier_seeds: 1,
        }
    }

    fn report(out: &Path) -> Vec<Vec<u8>> {
        FILES.map(|name| fs::read(out.join(name)).unwrap()).into()
    }

    fn all_of(settings: &Settings, out: &Path, threads: usize) -> Vec<String> {
        let never = Stop::fixed(false);
        carry_out(settings.clone(), Map::new(), out, threads, &never).unwrap_or_else(|failure| {
            panic!("{failure:?}");
        })
    }

    #[test]
    fn threads_and_interruptions_change_no_byte() {
        let (settings, home) = (settings(), tempfile::tempdir().unwrap());
        let whole = home.path().join("whole");
        assert_eq!(all_of(&settings, &whole, 2).len(), 10);
        let expected = report(&whole);

        // Again: every run is complete, and the report is made of the same results.
        fs::write(whole.join("report.html"), "torn").unwrap();
        all_of(&settings, &whole, 1);
        assert_eq!(report(&whole), expected);

        // Elsewhere: some runs of a smaller job are there, one failed, one was stopped in the
        // middle, and a job of other settings waits.
        let other = home.path().join("other");
        let fewer = Settings {
            arenas: vec!["maze".to_owned()],
            ..settings.clone()
        };
        all_of(&fewer, &other, 1);
        let job = settings.job().unwrap();
        let (half, failed) = (&job.runs[6], &job.runs[7]);
        let store = Store::open(&other.join("data")).unwrap();
        let others = Settings {
            epochs: 7,
            ..settings.clone()
        };
        submit(&store, others.job().unwrap(), &others.document(&Map::new())).unwrap();
        submit(&store, job.clone(), &settings.document(&Map::new())).unwrap();
        let failed = store.run(&failed.key()).unwrap().unwrap();
        store.fail(failed.seq, "for a test").unwrap();
        let mut run = swarm::run::Run::new(half.run_spec()).unwrap();
        run.advance(33);
        let checkpoint = Checkpoint {
            findings: Default::default(),
            snapshot: run.snapshot(),
        };
        store.checkpoints().write(&half.key(), &checkpoint).unwrap();
        drop(store);
        all_of(&settings, &other, 2);
        assert_eq!(report(&other), expected);
        let store = Store::open(&other.join("data")).unwrap();
        let waiting: u64 = (store.jobs(None, 9).unwrap().iter())
            .map(|job| job.counts.paused)
            .sum();
        assert_eq!(waiting, job.runs.len() as u64, "other settings wait");
    }

    #[test]
    fn stopped_it_says_how_to_go_on_and_writes_no_report() {
        let (settings, home) = (settings(), tempfile::tempdir().unwrap());
        let out = home.path().join("out");
        let stopped = Stop::fixed(true);
        let failure = carry_out(settings.clone(), Map::new(), &out, 2, &stopped).unwrap_err();
        assert!(format!("{failure:?}").contains("goes on from here"));
        assert!(!out.join("report.md").exists());
        all_of(&settings, &out, 2);
        assert!(out.join("report.md").exists());
    }

    #[test]
    fn the_report_holds_what_was_found() {
        let (settings, home) = (settings(), tempfile::tempdir().unwrap());
        all_of(&settings, home.path(), 2);
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
