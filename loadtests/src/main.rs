//! `make bench`: prints the table of figures against goals, and writes it as JSON.
#![allow(clippy::print_stdout, reason = "the table is the program's output")]

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};
use loadtests::cases::{self, Case};
use loadtests::measure::{Figure, measure};
use loadtests::{
    channels, compare, document, faults, fuzz, instructions, memory, picture, recording, service,
    short, table, threads,
};
use swarm::crew::Crew;

/// Benchmarks of the step loop: CPU nanoseconds a robot-step, on one thread.
#[derive(Parser)]
struct Options {
    #[command(subcommand)]
    other: Option<Other>,
    /// Only cases whose name contains this.
    #[arg(long, default_value = "")]
    only: String,
    /// Also the slow cases (10,000 robots with learning).
    #[arg(long)]
    full: bool,
    /// Rounds; each measures every case once.
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// Milliseconds a chunk.
    #[arg(long, default_value_t = 60.0)]
    chunk_ms: f64,
    /// Where the figures go as JSON.
    #[arg(long, default_value = "target/bench.json")]
    out: PathBuf,
    /// Earlier figures to compare with.
    #[arg(long)]
    base: Option<PathBuf>,
    /// Counts instructions (with valgrind) and peak memory instead of measuring time.
    #[arg(long)]
    instructions: bool,
    /// Also draws cost and memory against robots into this SVG file.
    #[arg(long)]
    picture: Option<PathBuf>,
    /// Also puts the tables into this document, between its `figures` and `scaling` markers.
    #[arg(long)]
    document: Option<PathBuf>,
    /// Steps just this case, by `--steps`: for profilers.
    #[arg(long, requires = "steps")]
    case: Option<String>,
    /// Arena steps for `--case`.
    #[arg(long)]
    steps: Option<u64>,
}

/// What is measured instead of the step loop.
#[derive(Subcommand)]
enum Other {
    /// The service under many clients.
    Http(service::Options),
    /// The service killed again and again while jobs of all kinds are posted and changed.
    Faults(faults::Options),
    /// Runs of ten steps: how many a second through the service, and the start of the program.
    Short(short::Options),
    /// What the server holds while many runs and jobs pass through it.
    Memory(memory::Options),
    /// Documents and checkpoints changed at random: no panic, none above two seconds.
    Fuzz(fuzz::Options),
    /// One world on several threads.
    Threads(threads::Options),
    /// What channels cost a run, or how long a question to a controller takes.
    Channels(channels::Options),
    /// What recording costs, as Markdown tables.
    Recording(recording::Options),
}

fn main() -> Result<()> {
    let options = Options::parse();
    match &options.other {
        Some(Other::Http(options)) => return service::run(options),
        Some(Other::Faults(options)) => return faults::run(options),
        Some(Other::Short(options)) => return short::run(options),
        Some(Other::Memory(options)) => return memory::run(options),
        Some(Other::Fuzz(options)) => return fuzz::run(options),
        Some(Other::Threads(options)) => return threads::run(options),
        Some(Other::Channels(options)) => return channels::run(options),
        Some(Other::Recording(options)) => return recording::run(options),
        None => {}
    }
    let cases: Vec<Case> = cases::all()
        .into_iter()
        .filter(|case| case.name.contains(&options.only) && (case.standard || options.full))
        .collect();
    if let (Some(name), Some(steps)) = (&options.case, options.steps) {
        let case = cases::all().into_iter().find(|case| case.name == *name);
        let mut setup = (case.context("no case of this name")?.setup)()?;
        (setup.chunk)(steps, &Crew::default());
        eprintln!("peak_bytes {}", instructions::peak_bytes().unwrap_or(0));
        return Ok(());
    }
    if options.instructions {
        println!(
            "{:<34} {:>18} {:>14}",
            "case", "instructions/step", "peak MB"
        );
        for case in &cases {
            let count = instructions::count(case)?;
            println!(
                "{:<34} {:>18.0} {:>14.1}",
                count.name,
                count.instructions,
                count.peak_bytes as f64 / 1e6
            );
        }
        return Ok(());
    }
    let total = cases.len() * (options.rounds + 1);
    let mut done = 0;
    let mut figures = measure(&cases, options.rounds, options.chunk_ms, |name| {
        done += 1;
        eprint!("\r{done}/{total} {name:<40}");
    })?;
    for (case, figure) in cases.iter().zip(&mut figures) {
        if case.name.contains("/swarm/") {
            figure.peak_bytes = Some(instructions::peak(case)?);
        }
    }
    eprintln!("\r{:<60}", "");
    let (mut lines, scaling) = (table::lines(&figures), table::scaling(&figures));
    lines.push(format!(
        "{} rounds of {} ms; load average {}, this program included",
        options.rounds,
        options.chunk_ms,
        instructions::load_average(),
    ));
    for line in lines.iter().chain([&String::new()]).chain(&scaling) {
        println!("{line}");
    }
    if let Some(path) = &options.document {
        document::refresh(path, &[("figures", lines), ("scaling", scaling)])?;
    }
    if let Some(folder) = options.out.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(&options.out, serde_json::to_string_pretty(&figures)? + "\n")
        .with_context(|| format!("writing {}", options.out.display()))?;
    println!("\nfigures: {}", options.out.display());
    if let Some(path) = &options.picture {
        picture::scaling(&figures, path)?;
        println!("picture: {}", path.display());
    }
    if let Some(base) = &options.base {
        let text =
            std::fs::read_to_string(base).with_context(|| format!("reading {}", base.display()))?;
        let base: Vec<Figure> = serde_json::from_str(&text)?;
        println!("\nagainst the earlier figures:");
        for line in compare::lines(&base, &figures) {
            println!("{line}");
        }
    }
    Ok(())
}
