//! The publishing end of frames: the transport's ports, owned by the one thread that uses them.

use std::path::Path;
use std::time::{Duration, Instant};

use api::frames::{FrameHeader, ObjectState, RobotState, frames_service, objects_service};
use iceoryx2::prelude::*;

use super::extent::Extent;
use super::port::{Channel, ChannelError, Quality, SendFailure, open_node};
use super::room;
use super::slot::{Frame, Slot, Taken};

/// How long a new reader of a silent channel waits to be noticed.
const TICK: Duration = Duration::from_millis(50);
/// Time between two searches for readers that died.
const CLEAN_UP_EVERY: Duration = Duration::from_secs(1);

/// A run's ports. The node is dropped last.
pub(super) struct Ports {
    /// Where the run has movable objects.
    objects: Option<Channel<ObjectState, FrameHeader>>,
    robots: Channel<RobotState, FrameHeader>,
    node: Node<ipc::Service>,
    sent: u64,
}

impl Ports {
    /// Opens the channel `swarm/<run>/frames` under `root`, and before it `swarm/<run>/objects` where
    /// there are objects: whoever finds the frames finds the objects.
    pub(super) fn open(root: &Path, run_id: &str, extent: Extent) -> Result<Self, ChannelError> {
        room::for_bytes(
            extent.robots * size_of::<RobotState>() + extent.objects * size_of::<ObjectState>(),
        )?;
        let node = open_node(root)?;
        let objects = (extent.objects > 0)
            .then(|| {
                let quality = Quality::latest::<ObjectState>(extent.objects)?;
                Channel::open(&node, &objects_service(run_id), extent.objects, quality)
            })
            .transpose()?;
        let quality = Quality::latest::<RobotState>(extent.robots)?;
        Ok(Self {
            objects,
            robots: Channel::open(&node, &frames_service(run_id), extent.robots, quality)?,
            node,
            sent: 0,
        })
    }

    /// Sends what comes through the slot until it is closed.
    pub(super) fn serve(mut self, slot: &Slot) {
        let mut frame = Frame::default();
        let mut cleaned_at = Instant::now();
        let mut complained = false;
        loop {
            let done = match slot.take(&mut frame, TICK) {
                Taken::Fresh => self.send(&mut frame),
                Taken::Nothing => self.greet(),
                Taken::Closed => return,
            };
            match done {
                Ok(()) => {}
                Err(error) if complained => tracing::debug!(%error, "frame lost"),
                Err(error) => {
                    complained = true;
                    tracing::warn!(%error, "a frame was lost; further losses are not reported");
                }
            }
            let objects_watched = self.objects.as_ref().is_some_and(Channel::is_watched);
            slot.set_watched(self.robots.is_watched() || objects_watched);
            if cleaned_at.elapsed() >= CLEAN_UP_EVERY {
                let _ = self.node.try_cleanup_dead_nodes();
                cleaned_at = Instant::now();
            }
        }
    }

    fn greet(&self) -> Result<(), SendFailure> {
        self.objects.as_ref().map_or(Ok(()), Channel::greet)?;
        self.robots.greet()
    }

    /// Sends objects before robots, so that whoever has the robots of a moment can have its objects.
    fn send(&mut self, frame: &mut Frame) -> Result<(), SendFailure> {
        frame.header.sequence = self.sent;
        if let Some(objects) = &self.objects {
            objects.send(frame.header, &frame.objects)?;
        }
        self.robots.send(frame.header, &frame.robots)?;
        self.sent += 1;
        Ok(())
    }
}
