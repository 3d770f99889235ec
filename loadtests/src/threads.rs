//! One world on several threads: wall time against the same world on one, in turns.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use swarm::crew::Crew;

use crate::gain::{Gain, Point};
use crate::{cases, instructions, picture};

/// Cases with a world large enough to be shared.
const CASES: [&str; 4] = [
    "kinematic/swarm/1000/brownian",
    "kinematic/swarm/10000/brownian",
    "kinematic/swarm/100000/brownian",
    "kinematic/swarm/10000/im",
];

/// Speed-up by two threads that is aimed at.
const GOAL: f64 = 1.7;

/// One world on several threads.
#[derive(clap::Args)]
pub struct Options {
    /// Only cases whose name contains this.
    #[arg(long, default_value = "")]
    only: String,
    /// Rounds; each measures every number of threads once.
    #[arg(long, default_value_t = 15)]
    rounds: usize,
    /// Milliseconds a chunk on one thread.
    #[arg(long, default_value_t = 200.0)]
    chunk_ms: f64,
    /// Most threads [default: one a processor].
    #[arg(long)]
    most: Option<usize>,
    /// Draws the speed-up against threads into this SVG file.
    #[arg(long)]
    picture: Option<PathBuf>,
}

/// Measures, prints a table, and draws where asked to.
///
/// # Errors
/// When a case cannot be set up or the picture cannot be written.
#[allow(clippy::print_stdout, reason = "the table is the program's output")]
pub fn run(options: &Options) -> Result<()> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let most = options.most.unwrap_or(processors).max(1);
    let counts: Vec<usize> = (0..)
        .map(|power| 1 << power)
        .take_while(|count| *count < most)
        .chain([most])
        .collect();
    let crews: Vec<Crew> = counts.iter().map(|&threads| Crew::new(threads)).collect();
    let mut gains = Vec::new();
    for name in CASES.iter().filter(|name| name.contains(&options.only)) {
        eprintln!("{name}");
        gains.push(measure(name, &crews, options)?);
    }
    for line in lines(&gains) {
        println!("{line}");
    }
    println!(
        "{} rounds of {} ms; load average {}, this program included",
        options.rounds,
        options.chunk_ms,
        instructions::load_average(),
    );
    if let Some(path) = &options.picture {
        picture::threads(&gains, path)?;
    }
    Ok(())
}

fn measure(name: &str, crews: &[Crew], options: &Options) -> Result<Gain> {
    let case = cases::all().into_iter().find(|case| case.name == name);
    let case = case.context("no case of this name")?;
    let mut setup = (case.setup)()?;
    let mut timed = |steps: u64, crew: &Crew| {
        let start = Instant::now();
        let robot_steps = (setup.chunk)(steps, crew);
        start.elapsed().as_secs_f64() * 1e9 / robot_steps as f64
    };
    // Warms up, and finds how many steps a chunk takes.
    let warm = timed((200_000 / case.robots).max(4), &crews[0]);
    let steps = (options.chunk_ms * 1e6 / (warm * case.robots as f64)).max(1.0) as u64;
    let mut all = vec![Vec::new(); crews.len()];
    for _ in 0..options.rounds {
        for (times, crew) in all.iter_mut().zip(crews) {
            times.push(timed(steps, crew));
        }
    }
    let points = crews.iter().zip(all).map(|(crew, mut times)| {
        times.sort_by(f64::total_cmp);
        Point {
            threads: crew.threads(),
            min_ns: times[0],
            median_ns: times[times.len() / 2],
        }
    });
    Ok(Gain {
        name: name.to_owned(),
        points: points.collect(),
    })
}

fn lines(gains: &[Gain]) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<34} {:>7} {:>12} {:>12} {:>16} {:>16}",
        "case", "threads", "min wall ns", "median", "speed-up (min)", "(median)"
    )];
    for gain in gains {
        for point in &gain.points {
            let least = gain.points[0].min_ns / point.min_ns;
            let median = gain.points[0].median_ns / point.median_ns;
            let verdict = match point.threads {
                2 if median >= GOAL => "  goal",
                2 => "  missed",
                _ => "",
            };
            lines.push(format!(
                "{:<34} {:>7} {:>12.1} {:>12.1} {:>16.2} {:>16.2}{verdict}",
                gain.name, point.threads, point.min_ns, point.median_ns, least, median
            ));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_ups_are_against_one_thread() {
        let point = |threads, ns| Point {
            threads,
            min_ns: ns,
            median_ns: 2.0 * ns,
        };
        let gain = Gain {
            name: "case".into(),
            points: vec![point(1, 100.0), point(2, 50.0), point(4, 40.0)],
        };
        let lines = lines(&[gain]);
        assert!(lines[1].contains("1.00"), "{lines:?}");
        assert!(lines[2].ends_with("2.00  goal"), "{lines:?}");
        assert!(lines[3].ends_with("2.50"), "{lines:?}");
    }
}
