//! Steps a second of one run, in turn without channels and with readers of all kinds.
#![allow(clippy::print_stdout, reason = "the table is the program's output")]

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow};
use cpu_time::ThreadTime;
use iceoryx2::prelude::*;
use serde_json::json;
use server::channels::{ChannelSet, ChannelSettings, Desk, Extent, RunChannels};
use server::runner;
use swarm::run::Run;

use super::options::{Options, spec};
use super::others::Other;
use crate::measure::quantile;

/// A way to run.
#[derive(Clone, Copy)]
enum Way {
    Off,
    Readers(usize),
    /// Eight readers, of which one is stopped.
    Stopped,
    /// Eight readers, of which one is killed when the measurement begins.
    Killed,
}

const WAYS: [(&str, Way); 6] = [
    ("channels off", Way::Off),
    ("on, nobody reads", Way::Readers(0)),
    ("1 reader", Way::Readers(1)),
    ("8 readers", Way::Readers(8)),
    ("8 readers, one stopped", Way::Stopped),
    ("8 readers, one killed", Way::Killed),
];

pub fn print(options: &Options) -> Result<()> {
    let robots = options.robots.first().copied().unwrap_or(1_000);
    let spec = spec(robots, &json!({ "method": "brownian" }))?;
    let mut run = Run::new(spec.run_spec()).map_err(|errors| anyhow!("{errors:?}"))?;
    let home = tempfile::tempdir()?;
    let settings = ChannelSettings {
        root: home.path().join("channels"),
        ..ChannelSettings::default()
    };
    let mut measured: Vec<[Vec<f64>; 2]> = WAYS.iter().map(|_| Default::default()).collect();
    for round in 0..=options.rounds {
        for ((_, way), [rates, cpu]) in WAYS.iter().zip(&mut measured) {
            let (rate, ns) = measure(&mut run, *way, &settings, options.seconds)?;
            // The first round warms up.
            if round > 0 {
                rates.push(rate);
                cpu.push(ns);
            }
        }
    }
    println!(
        "| {robots} robots | Million robot-steps a second | Against off | CPU of the stepping \
         thread, ns a robot-step | Against off |\n|---|---|---|---|---|"
    );
    let median = |values: &[f64]| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        quantile(&sorted, 0.5)
    };
    let [rates, cpu] = &measured[0];
    let (off, off_ns) = (median(rates), median(cpu));
    for ((name, _), [rates, cpu]) in WAYS.iter().zip(&measured) {
        let (rate, ns) = (median(rates), median(cpu));
        println!(
            "| {name} | {:.2} | {:+.1} % | {ns:.1} | {:+.1} % |",
            rate / 1e6,
            100.0 * (rate / off - 1.0),
            100.0 * (ns / off_ns - 1.0),
        );
    }
    Ok(())
}

/// Steps on for so many seconds; robot-steps a second, and nanoseconds of this thread for each.
fn measure(
    run: &mut Run,
    way: Way,
    settings: &ChannelSettings,
    seconds: f64,
) -> Result<(f64, f64)> {
    let extent = Extent::of(run.spec());
    let is_on = !matches!(way, Way::Off);
    let set = ChannelSet::of_spec(is_on);
    let desk = Arc::<Desk>::default();
    let mut channels =
        RunChannels::new(settings, "measured", extent, set, desk, Arc::default(), &());
    // Opens the channels, so that readers find them.
    step(run, &mut channels, 0.01);
    let count = match way {
        Way::Off => 0,
        Way::Readers(count) => count,
        Way::Stopped | Way::Killed => 8,
    };
    let readers = (0..count).map(|_| Other::start("reader", "measured", &settings.root));
    let mut readers = readers.collect::<Result<Vec<_>>>()?;
    let since = Instant::now();
    while count > 0 && readers_of(&settings.root)? < count {
        step(run, &mut channels, 0.01);
        if since.elapsed() > Duration::from_secs(60) {
            return Err(anyhow!("the readers did not come"));
        }
    }
    match way {
        Way::Stopped => readers[0].stop()?,
        Way::Killed => readers[0].kill()?,
        Way::Off | Way::Readers(_) => {}
    }
    let before = run.progress().robot_steps_done;
    let (wall, cpu) = (Instant::now(), ThreadTime::now());
    step(run, &mut channels, seconds);
    let steps = (run.progress().robot_steps_done - before) as f64;
    let (wall_s, cpu_s) = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    Ok((steps / wall_s, cpu_s * 1e9 / steps))
}

fn step(run: &mut Run, channels: &mut RunChannels, seconds: f64) {
    let since = Instant::now();
    let is_over = || since.elapsed().as_secs_f64() >= seconds;
    runner::step(run, &is_over, &mut [channels]);
}

/// Readers of the frames that there are.
fn readers_of(root: &Path) -> Result<usize> {
    use iceoryx2::service::port_factory::PortFactory as _;
    let node = api::controller::node(root)?;
    let name = api::frames::frames_service("measured");
    let name = ServiceName::new(&name).ok().context("a name")?;
    let service = node
        .service_builder(&name)
        .publish_subscribe::<[api::frames::RobotState]>()
        .user_header::<api::frames::FrameHeader>()
        .open()?;
    Ok(service.dynamic_config().number_of_subscribers())
}
