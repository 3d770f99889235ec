//! Frames of a run, latest wins: the run's thread copies one now and then, a thread of its own sends
//! it.

use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use swarm::run::Run;
use swarm::world::{Bodies, Objects};

use super::extent::Extent;
use super::frame::{FrameInfo, fill};
use super::port::ChannelError;
use super::ports::Ports;
use super::settings::ChannelSettings;
use super::slot::Slot;

/// Time between two frames that nobody reads; they are what a new reader sees at once.
const UNWATCHED_INTERVAL: Duration = Duration::from_secs(1);
/// A copy is followed by at least this many times its own duration without one, so that frames
/// never take more than about a twentieth of a run's time, however many robots there are.
const REST_AFTER_COPY: u32 = 19;

/// The sending side of one run's frames. Dropping it sends the last frame and closes the channel.
#[derive(Debug)]
pub struct FramePublisher {
    pub(super) slot: Arc<Slot>,
    thread: Option<JoinHandle<()>>,
    interval: Duration,
    pub(super) copied: Option<Copied>,
}

/// When the last frame was copied, and how long that and the copy before took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Copied {
    pub(super) at: Instant,
    pub(super) took: Duration,
    pub(super) before: Duration,
}

impl Copied {
    /// What a copy costs: the shorter of two, as a single one may have lost its processor to
    /// another thread half way.
    fn cost(&self) -> Duration {
        self.took.min(self.before)
    }
}

impl FramePublisher {
    /// Opens the channels of a run.
    ///
    /// # Errors
    /// [`ChannelError`] says which part of the transport is not to be had.
    pub fn open(
        settings: &ChannelSettings,
        run_id: &str,
        extent: Extent,
    ) -> Result<Self, ChannelError> {
        let slot = Arc::new(Slot::with_room_for(extent));
        let (opened, outcome) = mpsc::sync_channel(1);
        // Ports belong to the thread that made them.
        let thread = std::thread::Builder::new()
            .name("frames".to_owned())
            .spawn({
                let (slot, root, run_id) =
                    (Arc::clone(&slot), settings.root.clone(), run_id.to_owned());
                move || match Ports::open(&root, &run_id, extent) {
                    Ok(ports) => {
                        #[allow(
                            clippy::let_underscore_must_use,
                            reason = "whoever opens may have given up"
                        )]
                        let _ = opened.send(Ok(()));
                        ports.serve(&slot);
                    }
                    Err(error) => {
                        #[allow(
                            clippy::let_underscore_must_use,
                            reason = "whoever opens may have given up"
                        )]
                        let _ = opened.send(Err(error));
                    }
                }
            })
            .map_err(ChannelError::Thread)?;
        outcome.recv().unwrap_or(Err(ChannelError::Panicked))?;
        let interval = Duration::from_secs(1) / settings.max_frames_per_second.max(1);
        Ok(Self {
            slot,
            thread: Some(thread),
            interval,
            copied: None,
        })
    }

    /// Offers the run's present moment; call it between blocks of steps, as often as you like.
    /// Most calls do nothing but read the clock.
    pub fn offer(&mut self, run: &Run) {
        if self.is_due() {
            self.offer_moment(run.robots(), run.objects_here(), &FrameInfo::of(run));
        }
    }

    /// Offers the present moment whatever the time since the last one: for a run that pauses or
    /// ends, whose readers should see where it stands.
    pub fn offer_now(&mut self, run: &Run) {
        self.put_moment(run.robots(), run.objects_here(), &FrameInfo::of(run));
    }

    pub(super) fn put_moment(&mut self, bodies: &Bodies, objects: &Objects, info: &FrameInfo) {
        let started = Instant::now();
        self.slot.put(|frame| fill(frame, bodies, objects, info));
        self.note_copy(started);
    }

    fn offer_moment(&mut self, bodies: &Bodies, objects: &Objects, info: &FrameInfo) {
        let started = Instant::now();
        if self
            .slot
            .try_put(|frame| fill(frame, bodies, objects, info))
        {
            self.note_copy(started);
        }
    }

    fn note_copy(&mut self, started: Instant) {
        let took = started.elapsed();
        let before = self.copied.map_or(took, |last| last.took);
        self.copied = Some(Copied {
            at: started,
            took,
            before,
        });
    }

    /// Whether it is time for another frame.
    pub(super) fn is_due(&self) -> bool {
        let Some(copied) = self.copied else {
            return true;
        };
        let interval = if self.slot.watched() {
            self.interval
        } else {
            UNWATCHED_INTERVAL
        };
        copied.at.elapsed() >= interval.max(copied.cost() * (REST_AFTER_COPY + 1))
    }
}

impl Drop for FramePublisher {
    fn drop(&mut self) {
        self.slot.close();
        if self
            .thread
            .take()
            .is_some_and(|thread| thread.join().is_err())
        {
            tracing::warn!("the thread that sends frames panicked; the run is not affected");
        }
    }
}
