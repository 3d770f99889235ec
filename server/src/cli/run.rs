//! `evswarm run`: one spec, one directory; can be killed at any time and started again.

use std::io::Read;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, anyhow, bail};
use swarm::run::{Outcome, RestoreError, Run};
use swarm::spec::Method;

use super::checkpoint::{Checkpoint, Spent};
use super::out::Out;
use super::progress::Meter;
use super::{Failure, output};
use crate::artifacts::{self, Finished, Timing};
use crate::channels::{ChannelSet, ChannelSettings, Desk, Extent, External, RunChannels};
use crate::documents::{self, BuiltinArenas, MOST_RECORDING_BYTES, ResolvedRun, Stretch};
use crate::recording::{self, Begun, SharedRecorder, Tail};
use crate::runner::{self, Attendant, Checkpoints, Ended, MemoryBound, Pilot, Threads, Waits};
use crate::scheduler::findings_of;
use crate::stop::Stop;

#[derive(Debug, clap::Args)]
pub struct RunArguments {
    /// The run spec, a JSON file; - reads standard input.
    spec: PathBuf,
    /// Directory to write, which must not exist, be empty or hold this very run.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Threads to step on; few robots need one, and the result does not depend on it [default: one a
    /// processor].
    #[arg(long, value_parser = super::values::threads)]
    threads: Option<usize>,
    /// Most bytes that the run may hold; one that comes to hold more fails [default: three quarters
    /// of the machine's memory].
    #[arg(long, value_parser = clap::value_parser!(u64).range(1_000_000..))]
    run_memory_bytes: Option<u64>,
    /// Where robots are steered from outside: the name under which controllers find this run, so
    /// that several of one spec can be under way [default: the run's id].
    #[arg(long, value_name = "NAME")]
    external_name: Option<String>,
    /// Where robots are steered from outside: a recording of this very run, whose commands steer
    /// them in place of programs. It must hold every step, all robots and the field command.
    #[arg(long, value_name = "FILE", conflicts_with = "external_name")]
    answers: Option<PathBuf>,
}

pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let text = read(&arguments.spec)?;
    let spec = documents::parse(&text)
        .and_then(|value| documents::resolve(&value, &BuiltinArenas))
        .map_err(Failure::WrongSpec)?;
    let out = &Out::at(&arguments.out)?;
    if already_complete(out, &spec)? {
        return output::say(format_args!("{out} is already complete for this spec"));
    }
    // Refused before anything is written.
    swarm::run::check_placement(&spec.run_spec()).map_err(|error| wrong(vec![error]))?;
    let answers = answers(&spec, arguments)?;
    let checkpoint = Arc::new(Checkpoint::open(out, spec.key())?);
    // Another process may have finished between the look above and the lock.
    if already_complete(out, &spec)? {
        checkpoint.remove();
        return output::say(format_args!("{out} is already complete for this spec"));
    }
    let threads = arguments
        .threads
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, NonZeroUsize::get));
    let stop = Stop::on_signals(super::EXIT_FAILED.into())?;

    let (run, before) = start(&spec, &checkpoint)?;
    let Begun { run, recorder } = recorded(&spec, &checkpoint, run)?;
    let mut work = Work {
        run,
        recorder,
        costs: Costs::since_now(before),
    };
    show_plan(&work.run);
    let channels = channels(&spec);
    let most = arguments.run_memory_bytes;
    let most = most.unwrap_or_else(|| runner::default_run_memory_bytes(NonZeroUsize::MIN));
    let mut pilot: Option<Box<dyn Pilot + '_>> = match answers {
        Some(answers) => Some(Box::new(answers)),
        None => patient(&spec, arguments, &stop)?,
    };
    let Some(outcome) = finish(
        &mut work,
        pilot.as_mut().map(|pilot| &mut **pilot as &mut dyn Pilot),
        &checkpoint,
        channels,
        (threads, most),
        &stop,
    )?
    else {
        return Err(anyhow!("interrupted; the same command goes on from here").into());
    };
    let Spent { wall_s, cpu_s } = work.costs.spent();
    let timing = Timing {
        wall_s,
        cpu_s,
        robot_steps: outcome.robot_steps,
        threads: work.run.crew().threads(),
    };
    let recording = spec.record().map(|_| checkpoint.recording().whole);
    let finished = Finished {
        spec: &spec,
        outcome: &outcome,
        findings: &findings_of(&work.run),
        recording: recording.as_deref(),
    };
    artifacts::write_directory(out.place(), checkpoint.directory(), &finished, &timing)?;
    checkpoint.remove();
    report(out, &outcome, &timing)
}

/// What fits into a robot's memory budget, where it has one.
fn show_plan(run: &Run) {
    let Some(budget_bytes) = run.spec().memory_budget_bytes else {
        return;
    };
    let plan = run.memory_plan();
    tracing::info!(
        "a robot holds at most {} of {budget_bytes} bytes: {} states, {} actions, lists of {}, \
         {} commands an action, a sample of {} vectors, {} genomes",
        plan.bytes,
        plan.sensor_clusters,
        plan.actuator_clusters,
        plan.lambda,
        plan.actuator_sample,
        plan.sample,
        plan.genomes
    );
}

/// A run in progress, with what it has cost.
struct Work {
    run: Run,
    recorder: SharedRecorder,
    costs: Costs,
}

/// What a run has cost before, and since when it costs more.
struct Costs {
    before: Spent,
    since: Instant,
    /// Processor time of the process when this work began.
    cpu_s: f64,
}

impl Costs {
    fn since_now(before: Spent) -> Self {
        Self {
            before,
            since: Instant::now(),
            cpu_s: artifacts::process_cpu_s(),
        }
    }

    fn spent(&self) -> Spent {
        Spent {
            wall_s: self.before.wall_s + self.since.elapsed().as_secs_f64(),
            cpu_s: self.before.cpu_s + artifacts::process_cpu_s() - self.cpu_s,
        }
    }
}

pub(super) fn read(path: &Path) -> anyhow::Result<String> {
    if path == Path::new("-") {
        let mut text = String::new();
        std::io::stdin()
            .read_to_string(&mut text)
            .context("cannot read standard input")?;
        return Ok(text);
    }
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

/// Whether `out` holds this run.
///
/// # Errors
/// It holds something else.
fn already_complete(out: &Out, spec: &ResolvedRun) -> anyhow::Result<bool> {
    match artifacts::is_complete(out.place()) {
        Some(written) if written == spec.canonical_json() => Ok(true),
        Some(_) => {
            bail!("{out} holds the result of another spec; name another directory or remove it")
        }
        None if out.is_free()? => Ok(false),
        None => bail!("{out} is not empty and holds no result; name another directory"),
    }
}

/// The run from its checkpoint, or from the beginning.
fn start(spec: &ResolvedRun, checkpoint: &Checkpoint) -> Result<(Run, Spent), Failure> {
    if let Some(saved) = checkpoint.load() {
        match Run::restore(spec.run_spec(), &saved.snapshot) {
            Ok(run) => {
                let progress = run.progress();
                tracing::info!(
                    "going on at {} of {} epochs",
                    progress.epochs_done,
                    progress.epochs_total
                );
                return Ok((run, saved.spent));
            }
            Err(RestoreError::Spec(errors)) => return Err(wrong(errors)),
            Err(error) => tracing::warn!("starting anew: {error}"),
        }
    }
    let run = Run::new(spec.run_spec()).map_err(wrong)?;
    Ok((run, Spent::default()))
}

/// The run with whoever records it, if its spec asks for that.
fn recorded(spec: &ResolvedRun, checkpoint: &Checkpoint, run: Run) -> Result<Begun, Failure> {
    let Some(request) = spec.record() else {
        let recorder = SharedRecorder::new(None);
        return Ok(Begun { run, recorder });
    };
    let header = recording::header(spec, request, Stretch::whole(&spec.run_spec()));
    let paths = checkpoint.recording();
    recording::begin(run, header, &paths, MOST_RECORDING_BYTES, || {
        Run::new(spec.run_spec()).map_err(wrong)
    })
}

pub(super) fn wrong(errors: Vec<swarm::spec::FieldError>) -> Failure {
    Failure::WrongSpec(errors.into_iter().map(documents::field_error).collect())
}

/// The run's channels for local programs, if its spec asks for them.
fn channels(spec: &ResolvedRun) -> Option<RunChannels<'static>> {
    if !spec.channels() {
        return None;
    }
    let (key, extent) = (spec.key(), Extent::of(&spec.run_spec()));
    tracing::info!("frames are on {}", api::frames::frames_service(&key));
    Some(RunChannels::new(
        &ChannelSettings::default(),
        &key,
        extent,
        ChannelSet::of_spec(true),
        Arc::<Desk>::default(),
        Arc::default(),
        &(),
    ))
}

/// Steps the run to its end; `None` when stopped on the way, with a checkpoint made.
fn finish(
    work: &mut Work,
    pilot: Option<&mut dyn Pilot>,
    checkpoint: &Arc<Checkpoint>,
    mut channels: Option<RunChannels<'_>>,
    (threads, run_memory_bytes): (usize, u64),
    stop: &Stop,
) -> anyhow::Result<Option<Outcome>> {
    let progress = work.run.progress();
    let mut meter = Meter::new(
        "robot-steps",
        progress.robot_steps_total,
        progress.robot_steps_done,
    );
    let Work {
        run,
        recorder,
        costs,
    } = work;
    let mut threads = Threads::new(|| threads);
    let mut memory = MemoryBound::new(run_memory_bytes);
    let take = |run: &Run| (run.snapshot(), costs.spent(), recorder.tail());
    let mut checkpoints = Checkpoints::new(take, {
        let checkpoint = Arc::clone(checkpoint);
        move |(snapshot, spent, tail): (Vec<u8>, Spent, Option<Tail>)| {
            // A recording that is given up is told of at the end.
            tail.map(Tail::keep);
            if let Err(error) = checkpoint.save(&snapshot, spent) {
                tracing::warn!("no checkpoint: {error:#}");
            }
        }
    });
    let ended = runner::step_by(
        run,
        pilot,
        &|| stop.is_asked(),
        &mut [
            &mut threads,
            &mut memory,
            &mut meter,
            &mut channels,
            &mut checkpoints,
            &mut recorder.clone(),
        ],
    );
    drop(checkpoints);
    match ended {
        Ended::Done => {
            recording::finish(recorder)
                .map_err(|why| anyhow!("the recording is not whole: {why}"))?;
            (run.outcome().map(Some)).context("the run is done but has no outcome")
        }
        Ended::Stopped => {
            recorder.tail().map(Tail::keep);
            checkpoint.save(&run.snapshot(), costs.spent())?;
            Ok(None)
        }
        Ended::Waiting(waits) => {
            checkpoint.save(&run.snapshot(), costs.spent())?;
            Err(anyhow!("{}; the same command goes on from here", waits.why))
        }
        Ended::Failed(reason) => Err(anyhow!(reason)),
    }
}

/// Programs that steer a run whose robots do not steer themselves.
fn patient<'a>(
    spec: &ResolvedRun,
    arguments: &RunArguments,
    stop: &'a Stop,
) -> anyhow::Result<Option<Box<dyn Pilot + 'a>>> {
    let patient = Patient::open(spec, arguments.external_name.as_deref(), stop)?;
    Ok(patient.map(|patient| Box::new(patient) as _))
}

/// The recording that steers a run in place of programs.
fn answers(
    spec: &ResolvedRun,
    arguments: &RunArguments,
) -> anyhow::Result<Option<recording::Answers>> {
    let Some(path) = &arguments.answers else {
        return Ok(None);
    };
    if spec.method() != Method::External {
        bail!("--answers is for runs with the method external");
    }
    let answers = recording::Answers::open(path, spec);
    let answers = answers.with_context(|| format!("{} cannot steer the run", path.display()))?;
    Ok(Some(answers))
}

/// Waits for the programs that steer a run for as long as it takes.
struct Patient<'a> {
    external: External,
    stop: &'a Stop,
    has_said: bool,
}

impl<'a> Patient<'a> {
    /// `None` where robots steer themselves.
    fn open(
        spec: &ResolvedRun,
        name: Option<&str>,
        stop: &'a Stop,
    ) -> anyhow::Result<Option<Self>> {
        let (root, key) = (ChannelSettings::default().root, spec.key());
        let name = name.unwrap_or(&key);
        let external = External::open(&root, name, &spec.run_spec())?;
        if external.is_some() {
            tracing::info!("run {name} asks its controllers on this machine");
        }
        Ok(external.map(|external| Self {
            external,
            stop,
            has_said: false,
        }))
    }
}

/// Nobody looks at a run of this process while it waits.
impl Attendant for Stop {
    fn is_stopping(&self) -> bool {
        self.is_asked()
    }
}

impl Pilot for Patient<'_> {
    fn steer(&mut self, run: &mut Run) -> Result<(), runner::Stop> {
        loop {
            match self.external.steer(run, self.stop) {
                Ok(()) => {
                    self.has_said = false;
                    return Ok(());
                }
                Err(_) if self.stop.is_asked() => return Err(runner::Stop::LetGo),
                Err(error) if error.may_pass() => {
                    if !std::mem::replace(&mut self.has_said, true) {
                        tracing::warn!("step {}: {error}; waiting", run.step());
                    }
                }
                Err(error) => {
                    return Err(runner::Stop::Wait(Waits {
                        why: error.to_string(),
                        for_controllers: false,
                    }));
                }
            }
        }
    }
}

fn report(out: &Out, outcome: &Outcome, timing: &Timing) -> Result<(), Failure> {
    let coverage = outcome.coverage;
    output::say(format_args!(
        "{out}: p1 {}, p2 {}, p5 {}, p10 {} of {} reachable squares; {:.1} s, {:.0} robot-steps/s",
        coverage.p1,
        coverage.p2,
        coverage.p5,
        coverage.p10,
        outcome.reachable,
        timing.wall_s,
        outcome.robot_steps as f64 / timing.wall_s.max(1e-9),
    ))
}
