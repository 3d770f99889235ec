//! Frames of which none is lost: sent by the run's thread, which waits for readers that lag behind.
//! A reader that is stopped cannot hold a run: after a time the channel is closed, and the run goes on.

use std::cell::RefCell;
use std::path::Path;
use std::time::{Duration, Instant};

use api::WaitsFor;
use api::channels::run_service;
use api::frames::{FrameHeader, RobotState};
use iceoryx2::port::SendError;
use iceoryx2::prelude::*;
use swarm::run::Run;

use super::extent::Extent;
use super::frame::{FrameInfo, robot_state};
use super::patience::{LOOK_AROUND, LOOK_FOR_DEAD, Patience, REST, Wanted, remove_dead};
use super::port::{Channel, ChannelError, Quality, SendFailure, open_node};
use super::room;
use super::set::LosslessSettings;
use crate::runner::{Attendant, Wait};

/// The channel of a run. Fields are dropped in this order.
pub(super) struct Lossless {
    channel: Channel<RobotState, FrameHeader>,
    node: Node<ipc::Service>,
    settings: LosslessSettings,
    wanted: Wanted,
    sent: u64,
    /// Step of the last frame.
    last: Option<u64>,
    is_watched: bool,
}

impl Lossless {
    /// Opens the channel `swarm/<run>/lossless`.
    pub(super) fn open(
        root: &Path,
        run_id: &str,
        extent: Extent,
        settings: LosslessSettings,
        wanted: Wanted,
    ) -> Result<Self, ChannelError> {
        room::for_bytes(extent.robots * size_of::<RobotState>())?;
        let node = open_node(root)?;
        let timeout = Duration::from_millis(u64::from(settings.timeout_ms));
        let patience = Patience::new(timeout, wanted.clone(), node.config().clone());
        let quality = Quality::lossless::<RobotState>(extent.robots, patience)?;
        let name = run_service(run_id, "lossless");
        Ok(Self {
            channel: Channel::open(&node, &name, extent.robots, quality)?,
            node,
            settings,
            wanted,
            sent: 0,
            last: None,
            is_watched: false,
        })
    }

    /// How it was asked for.
    pub(super) fn settings(&self) -> LosslessSettings {
        self.settings
    }

    /// Whether it is still asked for, and the run not to be let go.
    pub(super) fn is_wanted(&self) -> bool {
        self.wanted.is_so()
    }

    /// Waits for the readers that were asked for, before this moment of the run. Returns whether all
    /// came in time, or are not wanted any more.
    pub(super) fn await_readers(&mut self, run: &Run, attendant: &dyn Attendant) -> bool {
        let mut wait = Wait::new(attendant, run, WaitsFor::LosslessReaders);
        let since = Instant::now();
        let timeout = Duration::from_millis(u64::from(self.settings.timeout_ms));
        while self.channel.readers() < self.settings.readers as usize {
            if !wait.look_around() || !self.wanted.is_so() {
                return true;
            }
            if since.elapsed() >= timeout {
                return false;
            }
            std::thread::sleep(REST);
        }
        true
    }

    /// The next step that must be seen.
    pub(super) fn next_step_wanted(&self, step: u64) -> Option<u64> {
        let every = u64::from(self.settings.every_steps);
        self.is_watched.then(|| (step / every + 1) * every)
    }

    /// Sends the present moment, if it is one of those that were asked for. Somebody attends to the
    /// run while it waits for readers.
    pub(super) fn offer(
        &mut self,
        run: &Run,
        attendant: &dyn Attendant,
    ) -> Result<(), SendFailure> {
        self.is_watched = self.channel.is_watched();
        let step = run.step();
        let is_due = step.is_multiple_of(u64::from(self.settings.every_steps));
        if !self.is_watched || !is_due || self.last == Some(step) {
            return Ok(());
        }
        self.last = Some(step);
        let robots = run.robots();
        let mut header = FrameInfo::of(run).header(robots.len());
        header.sequence = self.sent;
        let wait = RefCell::new(Wait::new(attendant, run, WaitsFor::LosslessReaders));
        let look_around = || wait.borrow_mut().look_around();
        LOOK_AROUND.set(&look_around, || {
            self.send_to_all(&look_around, || {
                self.channel.send_each(header, robots.len(), |number| {
                    robot_state(number, &robots[number])
                })
            })
        })?;
        self.sent += 1;
        Ok(())
    }

    /// Sends a frame until it reaches the readers that there are. The transport waits for full buffers
    /// of readers that are connected; one that came before its sender is connected only when it looks
    /// for a frame, and what it has no room for until then would be lost.
    fn send_to_all(
        &self,
        goes_on: &dyn Fn() -> bool,
        send: impl Fn() -> Result<usize, SendFailure>,
    ) -> Result<(), SendFailure> {
        let timeout = Duration::from_millis(u64::from(self.settings.timeout_ms));
        let since = Instant::now();
        let mut looked = since;
        loop {
            let before = self.channel.reader_ids();
            let reached = send()?;
            if reached >= before.len() || reached >= self.channel.readers_still_there(&before) {
                return Ok(());
            }
            if reached > 0 {
                return Err(SendFailure::Missed);
            }
            // Nobody got it, so that nobody gets it twice.
            if !goes_on() || !self.is_wanted() || since.elapsed() >= timeout {
                return Err(SendFailure::Send(SendError::UnableToDeliver));
            }
            if looked.elapsed() >= LOOK_FOR_DEAD {
                looked = Instant::now();
                remove_dead(self.node.config());
            }
            std::thread::sleep(REST);
        }
    }
}
