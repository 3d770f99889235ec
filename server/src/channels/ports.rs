//! The publishing end: the transport's ports, owned by the one thread that uses them.

use std::fmt::Debug;
use std::path::Path;
use std::time::{Duration, Instant};

use api::frames::{
    FrameHeader, ObjectState, RobotState, RootError, frames_service, objects_service,
    transport_config,
};
use iceoryx2::node::NodeCreationFailure;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::update_connections::{ConnectionFailure, UpdateConnections};
use iceoryx2::port::{LoanError, SendError};
use iceoryx2::prelude::*;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenOrCreateError;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::extent::Extent;
use super::room::{self, NoRoom};
use super::slot::{Frame, Slot, Taken};

/// Most readers of one channel at once.
pub(super) const MAX_SUBSCRIBERS: usize = 8;
/// Frames that a new reader gets at once.
pub(super) const HISTORY: usize = 1;
/// Frames that a reader of a small swarm may lag behind.
const LARGEST_BUFFER: usize = 16;
/// Samples that a reader may look at at the same time.
const BORROWED: usize = 2;
/// Samples that the publisher fills at the same time.
const LOANED: usize = 1;
/// Address space that a channel may take. Memory is used only as far as readers lag behind.
const LARGEST_CHANNEL_BYTES: usize = 512 << 20;
/// How long a new reader of a silent channel waits to be noticed.
const TICK: Duration = Duration::from_millis(50);
/// Time between two searches for readers that died.
const CLEAN_UP_EVERY: Duration = Duration::from_secs(1);
/// Longest wait for another process that is removing a dead one.
const CLEAN_UP_LIMIT: Duration = Duration::from_millis(500);

/// Why a channel could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum ChannelError {
    /// The configured root path cannot be used.
    #[error(transparent)]
    Root(#[from] RootError),
    /// The root folder cannot be created.
    #[error("the folder {path} cannot be created: {source}")]
    Folder {
        /// The folder.
        path: String,
        /// Why not.
        source: std::io::Error,
    },
    /// The run's identifier cannot be part of a service name.
    #[error("{0:?} cannot be a service's name")]
    Name(String),
    /// One frame of so many robots leaves no room for readers.
    #[error("frames of {robots} robots are too large for a channel")]
    TooLarge {
        /// Robots in the run.
        robots: usize,
    },
    /// Shared memory is full.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// The transport has no node for this process.
    #[error("no node: {0:?}")]
    Node(NodeCreationFailure),
    /// The service cannot be created.
    #[error("no service: {0:?}")]
    Service(PublishSubscribeOpenOrCreateError),
    /// Another process, or another worker of this one, is at the same run.
    #[error("another process sends frames of this run")]
    Taken,
    /// The service takes no publisher.
    #[error("no publisher: {0:?}")]
    Publisher(PublisherCreateError),
    /// The publishing thread cannot be started.
    #[error("no publishing thread: {0}")]
    Thread(std::io::Error),
    /// The transport gave up inside.
    #[error("the transport panicked while it opened the channel")]
    Panicked,
}

/// Why a frame was not sent. The next one may be.
#[derive(Debug, thiserror::Error)]
pub(super) enum FrameError {
    /// Shared memory is full.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// No sample was free.
    #[error("no sample is free: {0:?}")]
    Loan(LoanError),
    /// The sample reached nobody.
    #[error("not sent: {0:?}")]
    Send(SendError),
    /// Readers cannot be looked up.
    #[error("a reader cannot be connected: {0:?}")]
    Connect(ConnectionFailure),
}

/// Frames that a reader may lag behind where each shows so many of `T`: as many as fit, up to
/// [`LARGEST_BUFFER`]; `None` when not even one does.
pub(super) fn subscriber_buffer<T>(count: usize) -> Option<usize> {
    let frame_bytes = count.max(1).checked_mul(size_of::<T>())?;
    let samples = (LARGEST_CHANNEL_BYTES / frame_bytes).checked_sub(HISTORY + LOANED)?;
    let buffer = (samples / MAX_SUBSCRIBERS).checked_sub(BORROWED)?;
    (buffer > 0).then_some(buffer.min(LARGEST_BUFFER))
}

/// One channel of a run. Fields are dropped in this order.
struct Channel<T: Copy + Debug + ZeroCopySend + 'static> {
    publisher: Publisher<ipc::Service, [T], FrameHeader>,
    service: PortFactory<ipc::Service, [T], FrameHeader>,
}

impl<T: Copy + Debug + ZeroCopySend + 'static> Channel<T> {
    /// Opens the channel of this name for slices of about this length.
    fn open(node: &Node<ipc::Service>, name: &str, length: usize) -> Result<Self, ChannelError> {
        let buffer =
            subscriber_buffer::<T>(length).ok_or(ChannelError::TooLarge { robots: length })?;
        let name = ServiceName::new(name).map_err(|_| ChannelError::Name(name.to_owned()))?;
        let service = node
            .service_builder(&name)
            .publish_subscribe::<[T]>()
            .user_header::<FrameHeader>()
            // Without overflow a reader that died would hold its frames and stop the publisher.
            .enable_safe_overflow(true)
            .subscriber_max_buffer_size(buffer)
            .subscriber_max_borrowed_samples(BORROWED)
            .history_size(HISTORY)
            .max_subscribers(MAX_SUBSCRIBERS)
            // Frames of two processes at the same run would be told apart by nobody.
            .max_publishers(1)
            .max_nodes(MAX_SUBSCRIBERS + 2)
            .open_or_create()
            .map_err(ChannelError::Service)?;
        // A server that was killed may still be registered as the publisher.
        let _ = node.blocking_cleanup_dead_nodes(CLEAN_UP_LIMIT);
        let publisher = service
            .publisher_builder()
            .initial_max_slice_len(length.max(1))
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .max_loaned_samples(LOANED)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|error| match error {
                PublisherCreateError::ExceedsMaxSupportedPublishers => ChannelError::Taken,
                error => ChannelError::Publisher(error),
            })?;
        Ok(Self { publisher, service })
    }

    fn send(&self, header: FrameHeader, slice: &[T]) -> Result<(), FrameError> {
        room::for_bytes(size_of_val(slice) + size_of::<FrameHeader>())?;
        let sample = self
            .publisher
            .loan_slice_uninit(slice.len())
            .map_err(FrameError::Loan)?;
        let mut sample = sample.write_from_slice(slice);
        *sample.user_header_mut() = header;
        sample.send().map_err(FrameError::Send)?;
        Ok(())
    }

    /// A silent channel, of a paused run perhaps, still gives new readers its history.
    fn greet(&self) -> Result<(), FrameError> {
        room::for_bytes(0)?;
        self.publisher
            .update_connections()
            .map_err(FrameError::Connect)
    }

    fn is_watched(&self) -> bool {
        self.service.dynamic_config().number_of_subscribers() > 0
    }
}

/// A run's ports. The node is dropped last.
pub(super) struct Ports {
    /// Where the run has movable objects.
    objects: Option<Channel<ObjectState>>,
    robots: Channel<RobotState>,
    node: Node<ipc::Service>,
    sent: u64,
}

impl Ports {
    /// Opens the channel `swarm/<run>/frames` under `root`, and before it `swarm/<run>/objects` where
    /// there are objects: whoever finds the frames finds the objects.
    pub(super) fn open(root: &Path, run_id: &str, extent: Extent) -> Result<Self, ChannelError> {
        let config = transport_config(root)?;
        create_private_folder(root)?;
        room::for_bytes(
            extent.robots * size_of::<RobotState>() + extent.objects * size_of::<ObjectState>(),
        )?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(ChannelError::Node)?;
        let objects = (extent.objects > 0)
            .then(|| Channel::open(&node, &objects_service(run_id), extent.objects))
            .transpose()?;
        Ok(Self {
            objects,
            robots: Channel::open(&node, &frames_service(run_id), extent.robots)?,
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

    fn greet(&self) -> Result<(), FrameError> {
        self.objects.as_ref().map_or(Ok(()), Channel::greet)?;
        self.robots.greet()
    }

    /// Sends objects before robots, so that whoever has the robots of a moment can have its objects.
    fn send(&mut self, frame: &mut Frame) -> Result<(), FrameError> {
        frame.header.sequence = self.sent;
        if let Some(objects) = &self.objects {
            objects.send(frame.header, &frame.objects)?;
        }
        self.robots.send(frame.header, &frame.robots)?;
        self.sent += 1;
        Ok(())
    }
}

/// Creates the root folder, closed to other users if it is new.
pub(super) fn create_private_folder(root: &Path) -> Result<(), ChannelError> {
    let mut builder = std::fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(root).map_err(|source| ChannelError::Folder {
        path: root.display().to_string(),
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_shrink_as_swarms_grow() {
        assert_eq!(subscriber_buffer::<RobotState>(0), Some(LARGEST_BUFFER));
        assert_eq!(subscriber_buffer::<RobotState>(1_000), Some(LARGEST_BUFFER));
        let large = subscriber_buffer::<RobotState>(100_000);
        assert!(
            large.is_some_and(|frames| (1..LARGEST_BUFFER).contains(&frames)),
            "{large:?}"
        );
        assert_eq!(subscriber_buffer::<RobotState>(10_000_000), None);
    }
}
