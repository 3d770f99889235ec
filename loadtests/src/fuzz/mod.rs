//! `loadtests fuzz`: documents and checkpoints changed at random, read as the program reads them.
//! None may panic or take more than two seconds of processor time. A seed gives the same inputs.

mod corpus;
mod mutate;
mod target;

use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::Args;
use cpu_time::ThreadTime;

use mutate::Mutator;
use target::{Kind, Target};

/// Longest time for an input, of the processor.
const LONGEST: Duration = Duration::from_secs(2);
/// Longest time for an input by the clock, after which the program is ended.
const STUCK: Duration = Duration::from_secs(120);
/// Most memory that the program may take.
const MAX_MEMORY_BYTES: u64 = 4 << 30;

/// How long, and what.
#[derive(Args)]
pub struct Options {
    /// What is changed at random.
    #[arg(long)]
    target: Kind,
    /// Seconds.
    #[arg(long, default_value_t = 600)]
    seconds: u64,
    /// The same seed gives the same inputs.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where inputs that fail are kept.
    #[arg(long, default_value = "target/fuzz")]
    keep: PathBuf,
    /// Reads this file once instead.
    #[arg(long)]
    input: Option<PathBuf>,
}

/// The input that is being read, for whoever looks whether it ends.
type UnderWay = Arc<Mutex<Option<(Instant, Vec<u8>)>>>;

/// Changes inputs at random until the time is over.
///
/// # Errors
/// An input panicked or took too long.
#[allow(clippy::print_stdout, reason = "the figures are the program's output")]
pub fn run(options: &Options) -> Result<()> {
    bound_memory()?;
    let target = Target::new(options.target)?;
    if let Some(path) = &options.input {
        let input = std::fs::read(path).with_context(|| path.display().to_string())?;
        let (outcome, took) = timed(|| target.read(&input));
        println!("{outcome:?} in {took:?}");
        return Ok(());
    }
    std::fs::create_dir_all(&options.keep)?;
    let under_way = UnderWay::default();
    watch(Arc::clone(&under_way), options.keep.clone());
    let mut mutator = Mutator::new(options.seed, target.corpus());
    let end = Instant::now() + Duration::from_secs(options.seconds);
    let (mut inputs, mut taken, mut failed) = (0_u64, 0_u64, 0_u64);
    let mut slowest = Duration::ZERO;
    while Instant::now() < end {
        let input = target.sealed(mutator.input(target.is_text()), mutator.is_rather());
        *lock(&under_way) = Some((Instant::now(), input.clone()));
        let (outcome, took) =
            timed(|| panic::catch_unwind(AssertUnwindSafe(|| target.read(&input))));
        *lock(&under_way) = None;
        inputs += 1;
        slowest = slowest.max(took);
        let fault = match outcome {
            Err(_) => Some("panic"),
            Ok(_) if took > LONGEST => Some("slow"),
            Ok(true) => {
                taken += 1;
                mutator.learn(&input);
                None
            }
            Ok(false) => None,
        };
        if let Some(fault) = fault {
            failed += 1;
            let path = keep(&options.keep, options.target, fault, inputs, &input)?;
            println!("{fault} after {took:?}: {}", path.display());
            if failed >= 20 {
                bail!("{failed} inputs failed")
            }
        }
    }
    println!(
        "{:?}, seed {}: {inputs} inputs in {} s, {taken} of them right; slowest {} ms of the \
         processor; {failed} failed",
        options.target,
        options.seed,
        options.seconds,
        slowest.as_millis()
    );
    if failed > 0 {
        bail!("{failed} inputs failed")
    }
    Ok(())
}

fn timed<T>(task: impl FnOnce() -> T) -> (T, Duration) {
    let start = ThreadTime::now();
    let done = task();
    (done, start.elapsed())
}

fn lock(under_way: &UnderWay) -> std::sync::MutexGuard<'_, Option<(Instant, Vec<u8>)>> {
    under_way.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the program, keeping the input, when one does not end.
fn watch(under_way: UnderWay, folder: PathBuf) {
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let stuck = lock(&under_way).clone();
            if let Some((_, input)) = stuck.filter(|(since, _)| since.elapsed() > STUCK) {
                let path = folder.join("stuck");
                if std::fs::write(&path, input).is_ok() {
                    eprintln!("an input does not end: {}", path.display());
                }
                std::process::exit(1);
            }
        }
    });
}

fn keep(
    folder: &std::path::Path,
    kind: Kind,
    fault: &str,
    number: u64,
    input: &[u8],
) -> Result<PathBuf> {
    let path = folder.join(format!("{kind:?}-{fault}-{number}").to_lowercase());
    std::fs::write(&path, input).with_context(|| path.display().to_string())?;
    Ok(path)
}

/// An input that takes the machine's memory ends this program instead.
fn bound_memory() -> Result<()> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let limit = Rlimit {
        current: Some(MAX_MEMORY_BYTES),
        maximum: Some(MAX_MEMORY_BYTES),
    };
    setrlimit(Resource::As, limit).context("cannot bound the memory")
}
