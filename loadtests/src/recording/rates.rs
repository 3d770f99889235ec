//! Steps a second: one run, stepped in turn without and with each way of recording.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use cpu_time::ThreadTime;
use serde_json::{Value, json};

use super::options::Options;
use super::subject::{STEPS, Subject};
use crate::measure::quantile;

/// What is measured of a way of recording, in each round.
#[derive(Default)]
struct Measured {
    steps_per_s: Vec<f64>,
    cpu_ns: Vec<f64>,
    bytes: Vec<f64>,
}

/// Ways of recording; none first.
fn ways() -> [(&'static str, Option<Value>); 5] {
    let few = json!(["pose", "command"]);
    [
        ("off", None),
        ("every 10 steps", Some(json!({ "every_steps": 10 }))),
        ("every step", Some(json!({ "every_steps": 1 }))),
        (
            "every 10 steps, pose and command",
            Some(json!({ "every_steps": 10, "fields": few })),
        ),
        (
            "every step, pose and command",
            Some(json!({ "every_steps": 1, "fields": few })),
        ),
    ]
}

/// The rows of the table for so many robots.
pub fn rows(options: &Options, folder: &Path, robots: u64) -> Result<Vec<String>> {
    let mut subject = Subject::new(robots)?;
    // Warms up, and finds how many epochs take as long as wanted.
    let mut epochs = 1;
    loop {
        let start = Instant::now();
        subject.step(epochs)?;
        let took_s = start.elapsed().as_secs_f64();
        if took_s >= 0.5 * options.seconds {
            epochs = ((epochs as f64 * options.seconds / took_s) as u64).max(1);
            break;
        }
        epochs *= 2;
    }
    let ways = ways();
    let mut measured: Vec<Measured> = ways.iter().map(|_| Measured::default()).collect();
    for _ in 0..options.rounds.max(1) {
        for ((_, asked), measured) in ways.iter().zip(&mut measured) {
            let (wall, cpu) = (Instant::now(), ThreadTime::now());
            let bytes = match asked {
                None => subject.step(epochs).map(|()| 0)?,
                Some(asked) => subject.record(epochs, asked, folder)?,
            };
            let robot_steps = (epochs * u64::from(STEPS) * robots) as f64;
            measured
                .steps_per_s
                .push(robot_steps / wall.elapsed().as_secs_f64());
            measured
                .cpu_ns
                .push(cpu.elapsed().as_secs_f64() * 1e9 / robot_steps);
            let every = asked
                .as_ref()
                .map_or(1, |asked| asked["every_steps"].as_u64().unwrap_or(1));
            let samples = epochs * (u64::from(STEPS) / every + 1) * robots;
            measured.bytes.push(bytes as f64 / samples as f64);
        }
    }
    let median = |values: &[f64]| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        quantile(&sorted, 0.5)
    };
    let off = median(&measured[0].steps_per_s);
    let rows = ways.iter().zip(&measured).map(|((name, asked), measured)| {
        let rate = median(&measured.steps_per_s);
        let bytes = match asked {
            None => String::new(),
            Some(_) => format!("{:.2}", median(&measured.bytes)),
        };
        format!(
            "| {robots} | {name} | {:.2} | {:.0} % | {:.0} | {bytes} |",
            rate / 1e6,
            100.0 * rate / off,
            median(&measured.cpu_ns),
        )
    });
    Ok(rows.collect())
}
