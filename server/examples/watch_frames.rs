//! Reads a run's frames from shared memory and prints rates and positions of robots and movable
//! objects once a second; a start for readers of your own. The run must have `"channels": true` in its spec.
//!
//! `cargo run --release --example watch_frames -- RUN_ID`
#![allow(clippy::print_stdout, reason = "a command line program")]

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use api::frames::{
    FrameHeader, ObjectState, RobotState, default_root, frames_service, objects_service,
    transport_config,
};
use clap::Parser;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

type Channel = PortFactory<ipc::Service, [RobotState], FrameHeader>;

/// Prints the rates and positions of a run's live frames.
#[derive(Parser)]
struct Arguments {
    /// The run.
    run_id: String,
    /// Stop after this many frames; status 1 if the channel closes before.
    #[arg(long)]
    frames: Option<u64>,
    /// Folder that the server uses for its channels.
    #[arg(long, default_value_os_t = default_root())]
    root: PathBuf,
    /// Seconds to wait for the channel to be opened.
    #[arg(long, default_value_t = 10.0)]
    wait_s: f64,
}

/// The movable objects of a run, on a channel of their own.
struct Objects {
    subscriber: Subscriber<ipc::Service, [ObjectState], FrameHeader>,
    /// Those of the latest moments, with the moment's step.
    recent: VecDeque<(u64, Vec<ObjectState>)>,
}

impl Objects {
    /// Opens the channel; `None` where the run has no objects. It is made before that of the robots.
    fn open(node: &Node<ipc::Service>, run_id: &str) -> anyhow::Result<Option<Self>> {
        let name = ServiceName::new(&objects_service(run_id))?;
        let opened = node
            .service_builder(&name)
            .publish_subscribe::<[ObjectState]>()
            .user_header::<FrameHeader>()
            .open();
        let channel = match opened {
            Err(PublishSubscribeOpenError::DoesNotExist) => return Ok(None),
            other => other.with_context(|| format!("no channel {name}"))?,
        };
        Ok(Some(Self {
            subscriber: channel.subscriber_builder().create()?,
            recent: VecDeque::new(),
        }))
    }

    /// The objects of the moment that a frame of robots shows; they are sent before it. Moments must
    /// come in order.
    fn at(&mut self, arena_step: u64) -> anyhow::Result<&[ObjectState]> {
        while let Some(sample) = self.subscriber.receive()? {
            let step = sample.user_header().arena_step;
            self.recent.push_back((step, sample.payload().to_vec()));
        }
        while self
            .recent
            .front()
            .is_some_and(|(step, _)| *step < arena_step)
        {
            self.recent.pop_front();
        }
        let front = self.recent.front().filter(|(step, _)| *step == arena_step);
        Ok(front.map_or(&[], |(_, objects)| objects))
    }
}

/// What happened since the last line was printed.
struct Window {
    since: Instant,
    frames: u64,
    first_step: u64,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    set_log_level(LogLevel::Error);
    let config = transport_config(&arguments.root)?;
    // A node of the default mode ends `wait` below on SIGINT and SIGTERM.
    let node = NodeBuilder::new()
        .config(&config)
        .create::<ipc::Service>()?;
    let channel = open(&node, &arguments)?;
    let subscriber = channel.subscriber_builder().create()?;
    let mut objects = Objects::open(&node, &arguments.run_id)?;
    println!("watching {}", frames_service(&arguments.run_id));

    let opened = Instant::now();
    let mut published = false;
    let mut received = 0;
    let mut window: Option<Window> = None;
    let mut cleaned_at = Instant::now();
    loop {
        // A server that was killed stays registered until somebody cleans up after it.
        if cleaned_at.elapsed() >= Duration::from_secs(1) {
            let _ = node.try_cleanup_dead_nodes();
            cleaned_at = Instant::now();
        }
        // Asked before the last look, so that frames sent before the end are still read.
        // A channel exists a moment before its publisher does: that is not its end.
        let publishers = channel.dynamic_config().number_of_publishers();
        published |= publishers > 0 || opened.elapsed().as_secs_f64() >= arguments.wait_s;
        let closed = published && publishers == 0;
        while let Some(sample) = subscriber.receive()? {
            received += 1;
            let (header, robots) = (sample.user_header(), sample.payload());
            let now = window.get_or_insert_with(|| Window {
                since: Instant::now(),
                frames: 0,
                first_step: header.arena_step,
            });
            now.frames += 1;
            let beside = match &mut objects {
                Some(objects) => objects.at(header.arena_step)?,
                None => &[],
            };
            let last = arguments.frames == Some(received);
            if last || now.since.elapsed() >= Duration::from_secs(1) {
                report(now, header, robots, beside);
                *now = Window {
                    since: Instant::now(),
                    frames: 0,
                    first_step: header.arena_step,
                };
            }
            if last {
                return Ok(());
            }
        }
        if closed {
            println!("the channel was closed after {received} frames");
            if arguments.frames.is_some() {
                bail!("fewer frames than asked for");
            }
            return Ok(());
        }
        if node.wait(Duration::from_millis(4)).is_err() {
            println!("stopped after {received} frames");
            return Ok(());
        }
    }
}

/// Opens the channel, waiting for the server to create it.
fn open(node: &Node<ipc::Service>, arguments: &Arguments) -> anyhow::Result<Channel> {
    let name = ServiceName::new(&frames_service(&arguments.run_id))?;
    let started = Instant::now();
    loop {
        let opened = node
            .service_builder(&name)
            .publish_subscribe::<[RobotState]>()
            .user_header::<FrameHeader>()
            .open();
        match opened {
            Err(PublishSubscribeOpenError::DoesNotExist)
                if started.elapsed().as_secs_f64() < arguments.wait_s =>
            {
                node.wait(Duration::from_millis(50))?;
            }
            other => return other.with_context(|| format!("no channel {name}")),
        }
    }
}

fn report(window: &Window, header: &FrameHeader, robots: &[RobotState], objects: &[ObjectState]) {
    let seconds = window.since.elapsed().as_secs_f64().max(1e-9);
    let steps = header.arena_step.saturating_sub(window.first_step);
    println!(
        "{:.1} frames/s  {:.0} steps/s  simulated {:.1} s  {} epoch {}/{}  {} robots",
        window.frames as f64 / seconds,
        steps as f64 / seconds,
        header.sim_time_s,
        header.phase_name(),
        header.epochs_done,
        header.epochs_total,
        header.robots,
    );
    for robot in robots.iter().take(3) {
        let heading_rad = robot.heading_sin.atan2(robot.heading_cos);
        println!(
            "  robot {}: x {:.3} m  y {:.3} m  heading {heading_rad:.2} rad",
            robot.number, robot.x_m, robot.y_m,
        );
    }
    for (number, object) in objects.iter().enumerate().take(3) {
        println!(
            "  object {number}: x {:.3} m  y {:.3} m  heading {:.2} rad  moved {:.3} m",
            object.x_m, object.y_m, object.heading_rad, object.moved_m,
        );
    }
}
