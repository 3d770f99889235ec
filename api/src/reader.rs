//! The reader's end of a run's channels: for programs that watch a run from outside the simulator.
//!
//! ```no_run
//! use api::reader::FrameReader;
//!
//! let root = api::frames::default_root();
//! let frames = FrameReader::open(&root, &api::frames::frames_service("RUN_ID"))?;
//! while let Some(frame) = frames.wait(std::time::Duration::from_secs(5))? {
//!     println!("step {}: {} robots", frame.user_header().arena_step, frame.payload().len());
//! }
//! # Ok::<(), api::reader::ReaderError>(())
//! ```

use std::cell::Cell;
use std::fmt::Debug;
use std::path::Path;
use std::time::{Duration, Instant};

use iceoryx2::port::reader::{EntryHandle, Reader as BlackboardReader};
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::service::builder::blackboard::BlackboardOpenError;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::{blackboard, publish_subscribe};

use crate::channels::{
    CoverageHeader, MetricValue, MetricsHeader, RunEvent, RunStatus, STATUS_KEY, SquareEntries,
};
use crate::controller::{ControllerError, node, transport};
use crate::frames::{FrameHeader, ObjectState, RobotState};

/// Time between two looks for a sample or a channel.
const LOOK: Duration = Duration::from_millis(1);
/// Time between two looks whether the sender was killed.
const CLEAN_UP_EVERY: Duration = Duration::from_secs(1);

/// Why a channel cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReaderError {
    /// It is not open.
    #[error("there is no channel {0}: is the run under way, and was the channel asked for?")]
    Absent(String),
    /// It is of another version.
    #[error("the channel {service} is of another version: this program reads {type_name}")]
    OtherVersion {
        /// The service.
        service: String,
        /// The type that this program reads.
        type_name: String,
    },
    /// The transport refused something.
    #[error(transparent)]
    Transport(#[from] ControllerError),
}

/// A reader of slices of `T` with a header. Fields are dropped in this order.
pub struct Reader<T, H>
where
    T: Copy + Debug + ZeroCopySend + 'static,
    H: Copy + Debug + ZeroCopySend + 'static,
{
    subscriber: Subscriber<ipc::Service, [T], H>,
    service: publish_subscribe::PortFactory<ipc::Service, [T], H>,
    node: Node<ipc::Service>,
    cleaned: Cell<Instant>,
}

/// Reads frames; of the service `frames` the latest, of `lossless` all.
pub type FrameReader = Reader<RobotState, FrameHeader>;
/// Reads movable objects.
pub type ObjectReader = Reader<ObjectState, FrameHeader>;
/// Reads covered squares.
pub type CoverageReader = Reader<SquareEntries, CoverageHeader>;
/// Reads rows of metrics.
pub type MetricsReader = Reader<MetricValue, MetricsHeader>;
/// Reads events.
pub type EventReader = Reader<RunEvent, ()>;

impl<T, H> Reader<T, H>
where
    T: Copy + Debug + ZeroCopySend + 'static,
    H: Copy + Debug + ZeroCopySend + 'static,
{
    /// Opens a channel by the name of its service.
    ///
    /// # Errors
    /// When it is not open, is of another version, or the transport refuses it.
    pub fn open(root: &Path, service: &str) -> Result<Self, ReaderError> {
        let node = node(root)?;
        let name = transport("the name of the service", ServiceName::new(service))?;
        let opened = node
            .service_builder(&name)
            .publish_subscribe::<[T]>()
            .user_header::<H>()
            .open();
        let factory = match opened {
            Err(PublishSubscribeOpenError::DoesNotExist) => {
                return Err(ReaderError::Absent(service.to_owned()));
            }
            Err(PublishSubscribeOpenError::IncompatibleTypes) => {
                return Err(ReaderError::OtherVersion {
                    service: service.to_owned(),
                    // SAFETY: reads a constant; the trait marks it unsafe for those who implement it.
                    type_name: unsafe { <T as ZeroCopySend>::type_name() }.to_owned(),
                });
            }
            opened => transport("the channel", opened)?,
        };
        // A channel exists a moment before its sender does. A reader that came before the sender is
        // connected to it only when it first looks for a sample; what is sent until then may be lost.
        if factory.dynamic_config().number_of_publishers() == 0 {
            return Err(ReaderError::Absent(service.to_owned()));
        }
        let subscriber = factory.subscriber_builder().create();
        Ok(Self {
            subscriber: transport("a reader (are there too many?)", subscriber)?,
            service: factory,
            node,
            cleaned: Cell::new(Instant::now()),
        })
    }

    /// As [`Self::open`], but waits for the channel to be opened.
    ///
    /// # Errors
    /// As there.
    pub fn open_within(root: &Path, service: &str, wait: Duration) -> Result<Self, ReaderError> {
        let since = Instant::now();
        loop {
            match Self::open(root, service) {
                Err(ReaderError::Absent(_)) if since.elapsed() < wait => std::thread::sleep(LOOK),
                opened => return opened,
            }
        }
    }

    /// The next sample that has come; `None` where there is none now.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn receive(&self) -> Result<Option<Sample<ipc::Service, [T], H>>, ReaderError> {
        Ok(transport("a sample", self.subscriber.receive())?)
    }

    /// Waits for the next sample; `None` where none comes in time, or the channel closes.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn wait(
        &self,
        wait: Duration,
    ) -> Result<Option<Sample<ipc::Service, [T], H>>, ReaderError> {
        let since = Instant::now();
        loop {
            // Asked before the last look, so that what was sent before the end is still read.
            let is_closed = self.is_closed();
            let sample = self.receive()?;
            if sample.is_some() || is_closed || since.elapsed() >= wait {
                return Ok(sample);
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Whether nobody sends any more. A sender that was killed is noticed within a second.
    pub fn is_closed(&self) -> bool {
        if self.cleaned.get().elapsed() >= CLEAN_UP_EVERY {
            self.node.try_cleanup_dead_nodes();
            self.cleaned.set(Instant::now());
        }
        self.service.dynamic_config().number_of_publishers() == 0
    }
}

/// Reads the status of a run from its blackboard. Fields are dropped in this order.
pub struct StatusReader {
    entry: EntryHandle<ipc::Service, u64, RunStatus>,
    _reader: BlackboardReader<ipc::Service, u64>,
    _service: blackboard::PortFactory<ipc::Service, u64>,
    _node: Node<ipc::Service>,
}

impl StatusReader {
    /// Opens the blackboard by the name of its service.
    ///
    /// # Errors
    /// When there is none, it is of another version, or the transport refuses it.
    pub fn open(root: &Path, service: &str) -> Result<Self, ReaderError> {
        let other_version = || ReaderError::OtherVersion {
            service: service.to_owned(),
            type_name: RunStatus::layout().type_name,
        };
        let node = node(root)?;
        let name = transport("the name of the service", ServiceName::new(service))?;
        let factory = match node
            .service_builder(&name)
            .blackboard_opener::<u64>()
            .open()
        {
            Err(BlackboardOpenError::DoesNotExist) => {
                return Err(ReaderError::Absent(service.to_owned()));
            }
            Err(BlackboardOpenError::IncompatibleKeys) => return Err(other_version()),
            opened => transport("the blackboard", opened)?,
        };
        let reader = transport("a reader", factory.reader_builder().create())?;
        let entry = reader.entry::<RunStatus>(&STATUS_KEY);
        Ok(Self {
            entry: entry.map_err(|_| other_version())?,
            _reader: reader,
            _service: factory,
            _node: node,
        })
    }

    /// The status as it was written last.
    pub fn get(&self) -> RunStatus {
        *self.entry.get()
    }
}
