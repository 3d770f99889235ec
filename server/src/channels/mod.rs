//! Live frames of a run for programs on the same machine, through shared memory. The run's thread
//! copies a frame now and then, a thread of its own sends it; a run's results never depend on it,
//! and a channel that cannot be opened is a warning.

mod extent;
mod external;
mod ports;
mod room;
mod slot;
#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use api::frames::{
    ChannelDescription, FRAMES_VERSION, FrameHeader, ObjectState, PHASES, RobotState, RootError,
    TypeLayout, default_root, frames_service, objects_service, transport_config,
};
use swarm::run::{Phase, Progress, Run};
use swarm::world::{Bodies, Body, Objects};

use crate::runner::{Ended, Observer, Stop};
pub use extent::Extent;
pub use external::{AskError, External, Lookout};
pub use ports::ChannelError;
use ports::{HISTORY, MAX_SUBSCRIBERS, Ports, subscriber_buffer};
use slot::{Frame, Slot};

/// Time between two frames that nobody reads; they are what a new reader sees at once.
const UNWATCHED_INTERVAL: Duration = Duration::from_secs(1);
/// A copy is followed by at least this many times its own duration without one, so that frames
/// never take more than about a twentieth of a run's time, however many robots there are.
const REST_AFTER_COPY: u32 = 19;

/// Where channels are and how often they send.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelSettings {
    /// Folder under which this user's servers and readers meet.
    pub root: PathBuf,
    /// Most frames sent a second of wall time, at least 1.
    pub max_frames_per_second: u32,
}

impl Default for ChannelSettings {
    fn default() -> Self {
        Self {
            root: default_root(),
            max_frames_per_second: 60,
        }
    }
}

/// What a frame shows beside robots and objects.
#[derive(Clone, Copy, Debug)]
pub struct FrameInfo {
    /// Steps of the arena so far, all phases.
    pub arena_step: u64,
    /// How far the run is.
    pub progress: Progress,
    /// Control step, simulated seconds.
    pub step_s: f64,
}

impl FrameInfo {
    /// Of the run as it is now.
    pub fn of(run: &Run) -> Self {
        Self {
            arena_step: run.step(),
            progress: run.progress(),
            step_s: run.spec().robot.parameters.step_s,
        }
    }

    fn header(&self, robots: usize) -> FrameHeader {
        let progress = &self.progress;
        FrameHeader {
            sequence: 0, // counted by the thread that sends
            arena_step: self.arena_step,
            robot_steps_done: progress.robot_steps_done,
            robot_steps_total: progress.robot_steps_total,
            sim_time_s: self.arena_step as f64 * self.step_s,
            step_s: self.step_s,
            version: FRAMES_VERSION,
            phase: phase_code(progress.phase),
            epochs_done: progress.epochs_done,
            epochs_total: progress.epochs_total,
            robots: u32::try_from(robots).unwrap_or(u32::MAX),
            reserved: 0,
        }
    }
}

/// Index of the phase in [`PHASES`].
fn phase_code(phase: Phase) -> u32 {
    match phase {
        Phase::Babbling => 0,
        Phase::Evolution => 1,
        Phase::Repository => 2,
        Phase::Exploration => 3,
        Phase::Done => 4,
    }
}

/// The sending side of one run's frames. Dropping it sends the last frame and closes the channel.
#[derive(Debug)]
pub struct FramePublisher {
    slot: Arc<Slot>,
    thread: Option<JoinHandle<()>>,
    interval: Duration,
    copied: Option<Copied>,
}

/// When the last frame was copied, and how long that and the copy before took.
#[derive(Clone, Copy, Debug)]
struct Copied {
    at: Instant,
    took: Duration,
    before: Duration,
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

    /// As [`FramePublisher::open`]; a failure is a warning in the log.
    pub fn open_or_warn(settings: &ChannelSettings, run_id: &str, extent: Extent) -> Option<Self> {
        Self::open(settings, run_id, extent)
            .inspect_err(|error| {
                tracing::warn!(run = run_id, %error, "the run goes on without its frames channel");
            })
            .ok()
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

    fn put_moment(&mut self, bodies: &Bodies, objects: &Objects, info: &FrameInfo) {
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
    fn is_due(&self) -> bool {
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

impl Observer for FramePublisher {
    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        self.offer(run);
        Ok(())
    }

    fn end(&mut self, run: &Run, _: &Ended) {
        self.offer_now(run);
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

fn fill(frame: &mut Frame, bodies: &Bodies, objects: &Objects, info: &FrameInfo) {
    frame.header = info.header(bodies.len());
    frame.robots.clear();
    let robot = |(number, body): (usize, &Body)| RobotState {
        number: number as u32,
        x_m: body.x_m,
        y_m: body.y_m,
        heading_cos: body.cos,
        heading_sin: body.sin,
        sensors: body.reading.proximity,
        commands: body.command,
    };
    frame.robots.extend(bodies.iter().enumerate().map(robot));
    frame.objects.clear();
    let figures = objects.poses.iter().zip(&objects.moved_m);
    frame
        .objects
        .extend(figures.map(|(pose, &moved_m)| ObjectState {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: libm::atan2f(pose.sin, pose.cos),
            moved_m: moved_m as f32,
        }));
}

/// What a reader must know to open the channels of a run: that of its frames, then that of its
/// movable objects where it has any. Empty when frames of so many robots do not fit a channel.
///
/// # Errors
/// [`RootError`] when the configured root cannot be used.
pub fn describe(
    settings: &ChannelSettings,
    run_id: &str,
    Extent { robots, objects }: Extent,
) -> Result<Vec<ChannelDescription>, RootError> {
    let config = transport_config(&settings.root)?;
    let describe = |name: &str, service, payload: TypeLayout, subscriber_buffer| {
        Some(ChannelDescription {
            name: name.to_owned(),
            transport: "iceoryx2 0.10".to_owned(),
            pattern: "publish-subscribe".to_owned(),
            service,
            root_path: config.global.root_path().to_string(),
            prefix: config.global.prefix.to_string(),
            version: FRAMES_VERSION,
            payload,
            header: FrameHeader::layout(),
            max_frames_per_second: settings.max_frames_per_second,
            max_subscribers: MAX_SUBSCRIBERS,
            subscriber_buffer: subscriber_buffer?,
            history: HISTORY,
            phases: PHASES.map(str::to_owned).to_vec(),
        })
    };
    let (service, payload) = (frames_service(run_id), RobotState::layout());
    let buffer = subscriber_buffer::<RobotState>(robots);
    let Some(frames) = describe("frames", service, payload, buffer) else {
        return Ok(Vec::new());
    };
    let (service, payload) = (objects_service(run_id), ObjectState::layout());
    let buffer = (objects > 0).then(|| subscriber_buffer::<ObjectState>(objects));
    let objects = describe("objects", service, payload, buffer.flatten());
    Ok(std::iter::once(frames).chain(objects).collect())
}
