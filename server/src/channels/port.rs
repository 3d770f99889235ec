//! One publishing end of the transport: how a channel is opened, how a sample is sent, and why either
//! may fail.

use std::fmt::Debug;
use std::path::Path;
use std::time::Duration;

use api::frames::{RootError, transport_config};
use iceoryx2::node::NodeCreationFailure;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::update_connections::{ConnectionFailure, UpdateConnections};
use iceoryx2::port::{LoanError, SendError};
use iceoryx2::prelude::*;
use iceoryx2::service::builder::blackboard::{BlackboardCreateError, BlackboardOpenError};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenOrCreateError;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::patience::Patience;
use super::room::{self, NoRoom};

/// Most readers of one channel at once.
pub(super) const MAX_SUBSCRIBERS: usize = 8;
/// Samples that a new reader gets at once.
pub(super) const HISTORY: usize = 1;
/// Samples that a reader of a small swarm may lag behind.
const LARGEST_BUFFER: usize = 16;
/// Samples that a reader may look at at the same time.
const BORROWED: usize = 2;
/// Samples that the publisher fills at the same time.
const LOANED: usize = 1;
/// Address space that a channel may take. Memory is used only as far as readers lag behind.
const LARGEST_CHANNEL_BYTES: usize = 512 << 20;
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
    /// One sample of so many elements leaves no room for readers.
    #[error("samples of {elements} robots or squares are too large for a channel")]
    TooLarge {
        /// Elements of a sample.
        elements: usize,
    },
    /// Shared memory is full.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// The transport has no node for this process.
    #[error("no node: {0:?}")]
    Node(NodeCreationFailure),
    /// A program that is there has the channel open with another layout.
    #[error(
        "{0} is open with another version of its layout: a reader or a server of another version \
         of the program holds it"
    )]
    OtherVersion(String),
    /// The service cannot be created.
    #[error("no service: {0:?}")]
    Service(PublishSubscribeOpenOrCreateError),
    /// The blackboard cannot be created.
    #[error("no blackboard: {0:?}")]
    Blackboard(BlackboardCreateError),
    /// The blackboard of an earlier process cannot be taken over.
    #[error("the blackboard cannot be opened: {0:?}")]
    TakeOver(BlackboardOpenError),
    /// The blackboard takes no writer, or none for its entry.
    #[error("no writer: {0}")]
    Writer(String),
    /// Another process, or another worker of this one, is at the same run.
    #[error("another process sends on this channel of the run")]
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

/// Why a sample was not sent. The next one may be.
#[derive(Debug, thiserror::Error)]
pub(super) enum SendFailure {
    /// Shared memory is full.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// No sample was free.
    #[error("no sample is free: {0:?}")]
    Loan(LoanError),
    /// The sample did not reach every reader.
    #[error("not sent: {0:?}")]
    Send(SendError),
    /// Some readers got the sample, others did not.
    #[error("a reader that never looked for a frame has lost one")]
    Missed,
    /// Readers cannot be looked up.
    #[error("a reader cannot be connected: {0:?}")]
    Connect(ConnectionFailure),
}

/// What is promised to the readers of a channel.
#[derive(Debug)]
pub(super) struct Quality {
    /// Samples that a reader may lag behind.
    pub(super) buffer: usize,
    /// Who waits for readers that lag behind further; nobody where they lose the oldest samples.
    pub(super) patience: Option<Patience>,
}

impl Quality {
    /// The latest sample wins; of so many elements of `T`.
    pub(super) fn latest<T>(elements: usize) -> Result<Self, ChannelError> {
        let buffer = subscriber_buffer::<T>(elements);
        Ok(Self {
            buffer: buffer.ok_or(ChannelError::TooLarge { elements })?,
            patience: None,
        })
    }

    /// No sample is lost.
    pub(super) fn lossless<T>(elements: usize, patience: Patience) -> Result<Self, ChannelError> {
        Ok(Self {
            patience: Some(patience),
            ..Self::latest::<T>(elements)?
        })
    }
}

/// Samples that a reader may lag behind where each has so many of `T`: as many as fit, up to
/// [`LARGEST_BUFFER`]; `None` when not even one does.
pub(super) fn subscriber_buffer<T>(elements: usize) -> Option<usize> {
    let sample_bytes = elements.max(1).checked_mul(size_of::<T>())?;
    let samples = (LARGEST_CHANNEL_BYTES / sample_bytes).checked_sub(HISTORY + LOANED)?;
    let buffer = (samples / MAX_SUBSCRIBERS).checked_sub(BORROWED)?;
    (buffer > 0).then_some(buffer.min(LARGEST_BUFFER))
}

/// A node of this process under a root, whose folder is made where it is missing.
pub(super) fn open_node(root: &Path) -> Result<Node<ipc::Service>, ChannelError> {
    let config = transport_config(root)?;
    // A node has a segment of its own.
    room::for_bytes(0)?;
    create_private_folder(root)?;
    NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .map_err(ChannelError::Node)
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

/// One channel of a run. Fields are dropped in this order.
#[derive(Debug)]
pub(super) struct Channel<T, H>
where
    T: Copy + Debug + ZeroCopySend + 'static,
    H: Copy + Debug + Default + ZeroCopySend + 'static,
{
    publisher: Publisher<ipc::Service, [T], H>,
    service: PortFactory<ipc::Service, [T], H>,
}

impl<T, H> Channel<T, H>
where
    T: Copy + Debug + ZeroCopySend + 'static,
    H: Copy + Debug + Default + ZeroCopySend + 'static,
{
    /// Opens the channel of this name for slices of about this length; where nothing is lost, of at
    /// most this length.
    pub(super) fn open(
        node: &Node<ipc::Service>,
        name: &str,
        length: usize,
        quality: Quality,
    ) -> Result<Self, ChannelError> {
        let name = ServiceName::new(name).map_err(|_| ChannelError::Name(name.to_owned()))?;
        // A server that was killed may still be registered as the publisher.
        let _ = node.blocking_cleanup_dead_nodes(CLEAN_UP_LIMIT);
        let service = open_service(node, &name, quality.buffer, quality.patience.is_some())?;
        // Memory that grows is mapped by a reader only when it takes its first sample, and lost to it
        // when the sender has gone by then.
        let allocation = match quality.patience {
            None => AllocationStrategy::PowerOfTwo,
            Some(_) => AllocationStrategy::Static,
        };
        let builder = service
            .publisher_builder()
            .initial_max_slice_len(length.max(1))
            .allocation_strategy(allocation)
            .max_loaned_samples(LOANED);
        let builder = match quality.patience {
            None => builder.backpressure_strategy(BackpressureStrategy::DiscardData),
            Some(mut patience) => {
                let readers = open_service::<T, H>(node, &name, quality.buffer, true)?;
                patience.ask_whether(move |port| reader_ids(&readers).contains(&port));
                builder
                    .backpressure_strategy(BackpressureStrategy::RetryUntilDelivered)
                    .set_backpressure_handler(move |info| patience.decide(info))
            }
        };
        let publisher = builder.create().map_err(|error| match error {
            PublisherCreateError::ExceedsMaxSupportedPublishers => ChannelError::Taken,
            error => ChannelError::Publisher(error),
        })?;
        Ok(Self { publisher, service })
    }

    /// Sends a slice.
    pub(super) fn send(&self, header: H, slice: &[T]) -> Result<(), SendFailure> {
        self.send_each(header, slice.len(), |place| slice[place])?;
        Ok(())
    }

    /// Sends so many elements, each made by its place. Returns how many readers got them.
    pub(super) fn send_each(
        &self,
        header: H,
        length: usize,
        element: impl FnMut(usize) -> T,
    ) -> Result<usize, SendFailure> {
        room::for_bytes(length * size_of::<T>() + size_of::<H>())?;
        let sample = self
            .publisher
            .loan_slice_uninit(length)
            .map_err(SendFailure::Loan)?;
        let mut sample = sample.write_from_fn(element);
        *sample.user_header_mut() = header;
        sample.send().map_err(SendFailure::Send)
    }

    /// A silent channel, of a paused run perhaps, still gives new readers its history.
    pub(super) fn greet(&self) -> Result<(), SendFailure> {
        room::for_bytes(0)?;
        self.publisher
            .update_connections()
            .map_err(SendFailure::Connect)
    }

    /// Readers that there are.
    pub(super) fn readers(&self) -> usize {
        self.service.dynamic_config().number_of_subscribers()
    }

    /// Those of the readers that are there now and were there before.
    pub(super) fn readers_still_there(&self, before: &[u128]) -> usize {
        let now = self.reader_ids();
        before.iter().filter(|id| now.contains(id)).count()
    }

    /// The readers that there are.
    pub(super) fn reader_ids(&self) -> Vec<u128> {
        reader_ids(&self.service)
    }

    /// Whether there is a reader.
    pub(super) fn is_watched(&self) -> bool {
        self.readers() > 0
    }
}

/// The service of a channel, opened or made.
pub(super) fn open_service<T, H>(
    node: &Node<ipc::Service>,
    name: &ServiceName,
    buffer: usize,
    is_lossless: bool,
) -> Result<PortFactory<ipc::Service, [T], H>, ChannelError>
where
    T: Copy + Debug + ZeroCopySend + 'static,
    H: Copy + Debug + Default + ZeroCopySend + 'static,
{
    node.service_builder(name)
        .publish_subscribe::<[T]>()
        .user_header::<H>()
        // Without overflow a reader that died would hold its samples and stop the publisher.
        .enable_safe_overflow(!is_lossless)
        .subscriber_max_buffer_size(buffer)
        .subscriber_max_borrowed_samples(BORROWED)
        .history_size(if is_lossless { 0 } else { HISTORY })
        .max_subscribers(MAX_SUBSCRIBERS)
        // Samples of two processes at the same run would be told apart by nobody.
        .max_publishers(1)
        .max_nodes(MAX_SUBSCRIBERS + 2)
        .open_or_create()
        .map_err(|error| {
            let text = format!("{error:?}");
            match text.contains("IncompatibleTypes") {
                true => ChannelError::OtherVersion(name.to_string()),
                false => ChannelError::Service(error),
            }
        })
}

/// The readers of a channel: those that were killed are not among them, once they are cleaned up.
fn reader_ids<T, H>(service: &PortFactory<ipc::Service, [T], H>) -> Vec<u128>
where
    T: Copy + Debug + ZeroCopySend + 'static,
    H: Copy + Debug + Default + ZeroCopySend + 'static,
{
    let mut ids = Vec::new();
    service.dynamic_config().list_subscribers(|reader| {
        ids.push(reader.subscriber_id.value());
        CallbackProgression::Continue
    });
    ids
}

#[cfg(test)]
mod tests {
    use api::frames::RobotState;

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
