//! Slices at random places of a long recording, each opened anew as the service does it.

use std::fs::File;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use recording::Reader;
use rustix::fs::{Advice, fadvise};
use serde_json::json;
use server::recording::{Paths, SliceQuery, Stage, slice};

use super::options::Options;
use super::subject::{STEPS, Subject};
use crate::measure::quantile;

const ROBOTS: u64 = 1_000;
/// What a slice holds.
const MOMENTS: u64 = 100;
const ROBOTS_SHOWN: u32 = 10;

/// What was found, in Markdown.
pub fn lines(options: &Options, folder: &Path) -> Result<Vec<String>> {
    let epochs = options
        .robot_steps
        .div_ceil(ROBOTS * u64::from(STEPS))
        .max(1);
    let mut subject = Subject::new(ROBOTS)?;
    let begun = Instant::now();
    let from = subject.run.step();
    let bytes = subject.record(epochs, &json!({ "every_steps": 1 }), folder)?;
    let made_s = begun.elapsed().as_secs_f64();
    let robot_steps = epochs * u64::from(STEPS) * ROBOTS;
    let path = Paths::new(folder, "measured").whole;
    let mut random = fastrand::Rng::with_seed(1);
    let mut look = |is_dropped: bool| -> Result<[f64; 3]> {
        let mut times_ms = Vec::new();
        for _ in 0..options.slices.max(1) {
            if is_dropped {
                // Written out and forgotten: the next read is of the disk.
                let file = File::open(&path)?;
                file.sync_all()?;
                fadvise(&file, 0, None, Advice::DontNeed)?;
            }
            let first = random.u32(0..(ROBOTS as u32 - ROBOTS_SHOWN));
            let steps = epochs * u64::from(STEPS);
            let query = SliceQuery {
                from_step: Some(from + random.u64(0..steps.saturating_sub(MOMENTS).max(1))),
                steps: Some(MOMENTS),
                every: None,
                robots: Some((first..first + ROBOTS_SHOWN).collect()),
            };
            let start = Instant::now();
            let mut reader = Reader::open(File::open(&path)?)?;
            let slice = slice(&mut reader, Stage::Whole, &query)?;
            times_ms.push(start.elapsed().as_secs_f64() * 1e3);
            // An epoch's end and the next one's beginning are at the same step.
            let moments = slice.step.len() as u64;
            anyhow::ensure!(
                (MOMENTS..=MOMENTS + 1).contains(&moments),
                "{moments} moments"
            );
        }
        times_ms.sort_by(f64::total_cmp);
        Ok([0.5, 0.99, 1.0].map(|q| quantile(&times_ms, q)))
    };
    let (warm, cold) = (look(false)?, look(true)?);
    let row = |name: &str, [median, p99, most]: [f64; 3]| {
        format!("| {name} | {median:.2} | {p99:.2} | {most:.2} |")
    };
    Ok(vec![
        format!(
            "A recording of {robot_steps} robot-steps, {ROBOTS} robots with all fields, has {:.0} \
             MB ({:.2} bytes a robot-step) and was stepped and written in {made_s:.0} s. {} slices \
             of {MOMENTS} moments of {ROBOTS_SHOWN} robots at random places, each opened anew:",
            bytes as f64 / 1e6,
            bytes as f64 / robot_steps as f64,
            options.slices.max(1),
        ),
        String::new(),
        "| Pages of the file | Median, ms | 99th percentile, ms | Most, ms |".to_owned(),
        "|---|---|---|---|".to_owned(),
        row("in memory", warm),
        row("on the disk", cold),
    ])
}
