//! What a run tells of itself beside its frames: covered squares, rows of metrics, events, and its
//! status on a blackboard. The run's thread sends them itself, seldom enough that it does not notice.

use std::fmt::Debug;
use std::time::{Duration, Instant};

use api::channels::{
    CHANNELS_VERSION, CoverageHeader, MetricValue, MetricsHeader, RunEvent, RunStatus, STATUS_KEY,
    SquareEntries, run_service,
};
use iceoryx2::port::writer::{EntryHandleMut, Writer, WriterCreateError};
use iceoryx2::prelude::*;
use iceoryx2::service::builder::blackboard::{BlackboardCreateError, BlackboardOpenError};
use iceoryx2::service::port_factory::blackboard;
use swarm::metrics::Value;
use swarm::run::{MetricsRow, Run};

use super::extent::Extent;
use super::frame::{FrameInfo, phase_code};
use super::port::{Channel, ChannelError, MAX_SUBSCRIBERS, Quality, SendFailure};
use super::room;

/// Time between two pictures of the covered squares.
const COVERAGE_EVERY: Duration = Duration::from_millis(500);
/// The same while nobody reads them.
const UNWATCHED_EVERY: Duration = Duration::from_secs(5);
/// Time between two entries of the status.
const STATUS_EVERY: Duration = Duration::from_millis(250);
/// A sending is followed by at least this many times its own duration without one.
const REST: u32 = 50;
/// Most values of a row of metrics: four shares and what the table shows over time.
const MAX_VALUES: usize = 64;

/// When something is due again.
#[derive(Debug, Default)]
struct Due {
    last: Option<(Instant, Duration)>,
}

impl Due {
    fn is_due(&self, interval: Duration) -> bool {
        self.last
            .is_none_or(|(at, took)| at.elapsed() >= interval.max(took * (REST + 1)))
    }

    fn note(&mut self, started: Instant) {
        self.last = Some((started, started.elapsed()));
    }
}

/// The covered squares.
pub(super) struct Coverage {
    channel: Channel<SquareEntries, CoverageHeader>,
    due: Due,
    sent: u64,
}

impl Coverage {
    pub(super) fn open(
        node: &Node<ipc::Service>,
        run_id: &str,
        extent: Extent,
    ) -> Result<Self, ChannelError> {
        room::for_bytes(extent.squares * size_of::<SquareEntries>())?;
        let quality = Quality::latest::<SquareEntries>(extent.squares)?;
        let name = run_service(run_id, "coverage");
        Ok(Self {
            channel: Channel::open(node, &name, extent.squares, quality)?,
            due: Due::default(),
            sent: 0,
        })
    }

    pub(super) fn offer(&mut self, run: &Run) -> Result<(), SendFailure> {
        self.channel.greet()?;
        let interval = match self.channel.is_watched() {
            true => COVERAGE_EVERY,
            false => UNWATCHED_EVERY,
        };
        match self.due.is_due(interval) {
            true => self.send(run),
            false => Ok(()),
        }
    }

    pub(super) fn send(&mut self, run: &Run) -> Result<(), SendFailure> {
        let started = Instant::now();
        let visits = run.visits();
        let arena = &run.spec().arena;
        let [columns, rows] = arena.squares();
        let header = CoverageHeader {
            sequence: self.sent,
            arena_step: run.step(),
            counted_steps: run.counted_steps(),
            width_m: arena.width_m(),
            height_m: arena.height_m(),
            columns,
            rows,
            // An arena has at most 1,000,000 squares.
            entered: visits.iter().filter(|&&entries| entries > 0).count() as u32,
            version: CHANNELS_VERSION,
        };
        let reached = self.channel.send_each(header, visits.len(), |square| {
            let entries = visits[square];
            SquareEntries { entries }
        });
        self.due.note(started);
        self.sent += 1;
        reached.map(|_| ())
    }
}

/// Rows of metrics, and events.
pub(super) struct Metrics {
    rows: Channel<MetricValue, MetricsHeader>,
    events: Channel<RunEvent, ()>,
    sent_rows: usize,
    sent_events: u64,
    phase: Option<u32>,
    epochs: u32,
    values: Vec<MetricValue>,
}

impl Metrics {
    pub(super) fn open(
        node: &Node<ipc::Service>,
        run_id: &str,
        run: &Run,
    ) -> Result<Self, ChannelError> {
        room::for_bytes(MAX_VALUES * size_of::<MetricValue>())?;
        let rows = Quality::latest::<MetricValue>(MAX_VALUES)?;
        let events = Quality::latest::<RunEvent>(1)?;
        let (row_name, event_name) = (
            run_service(run_id, "metrics"),
            run_service(run_id, "events"),
        );
        Ok(Self {
            rows: Channel::open(node, &row_name, MAX_VALUES, rows)?,
            events: Channel::open(node, &event_name, 1, events)?,
            // The last row that there is comes first.
            sent_rows: run.metrics_rows().len().saturating_sub(1),
            sent_events: 0,
            phase: None,
            epochs: run.progress().epochs_done,
            values: Vec::with_capacity(MAX_VALUES),
        })
    }

    pub(super) fn offer(&mut self, run: &Run) -> Result<(), SendFailure> {
        self.rows.greet()?;
        self.events.greet()?;
        let progress = run.progress();
        let phase = phase_code(progress.phase);
        if self.phase != Some(phase) {
            let kind = u32::from(self.phase.replace(phase).is_some());
            self.event(run, kind, phase)?;
        }
        if self.epochs != progress.epochs_done {
            self.epochs = progress.epochs_done;
            self.event(run, 2, self.epochs)?;
        }
        let rows = run.metrics_rows();
        while let Some(row) = rows.get(self.sent_rows) {
            self.values.clear();
            fill(&mut self.values, row, run.reachable().count);
            let header = MetricsHeader {
                row: self.sent_rows as u64,
                counted_steps: row.steps,
                epoch: row.epoch,
                version: CHANNELS_VERSION,
            };
            self.rows.send(header, &self.values)?;
            self.sent_rows += 1;
        }
        Ok(())
    }

    /// The run is let go, in a state of `STATES`.
    pub(super) fn end(&mut self, run: &Run, state: u32) -> Result<(), SendFailure> {
        self.offer(run)?;
        self.event(run, 3, state)
    }

    fn event(&mut self, run: &Run, kind: u32, value: u32) -> Result<(), SendFailure> {
        let event = RunEvent {
            sequence: self.sent_events,
            arena_step: run.step(),
            kind,
            value,
        };
        self.sent_events += 1;
        self.events.send((), &[event])
    }
}

/// Names and values of a row, those of `metrics.csv`.
fn fill(values: &mut Vec<MetricValue>, row: &MetricsRow, reachable: u32) {
    let names = ["fraction_1", "fraction_2", "fraction_5", "fraction_10"];
    for (name, entered) in names.into_iter().zip(row.entered) {
        let share = f64::from(entered) / f64::from(reachable.max(1));
        values.push(MetricValue::new(name, share));
    }
    for (name, value) in row.values.iter() {
        let value = value.map_or(f64::NAN, |value| match value {
            Value::Count(count) => count as f64,
            Value::Real(real) => real,
        });
        values.push(MetricValue::new(name, value));
    }
}

/// The status on a blackboard. Fields are dropped in this order.
pub(super) struct Status {
    entry: EntryHandleMut<ipc::Service, u64, RunStatus>,
    _writer: Writer<ipc::Service, u64>,
    _service: blackboard::PortFactory<ipc::Service, u64>,
    due: Due,
    /// When it was written last, and the robot-steps then.
    last: Option<(Instant, u64)>,
}

impl Status {
    pub(super) fn open(node: &Node<ipc::Service>, run_id: &str) -> Result<Self, ChannelError> {
        room::for_bytes(size_of::<RunStatus>())?;
        let text = run_service(run_id, "status");
        let name = ServiceName::new(&text).map_err(|_| ChannelError::Name(text.clone()))?;
        // A server that was killed may still be registered as the writer.
        let _ = node.blocking_cleanup_dead_nodes(Duration::from_millis(500));
        let created = node
            .service_builder(&name)
            .blackboard_creator::<u64>()
            .max_readers(MAX_SUBSCRIBERS)
            .max_nodes(MAX_SUBSCRIBERS + 2)
            .add::<RunStatus>(STATUS_KEY, RunStatus::default())
            .create();
        let service = match created {
            Ok(service) => service,
            // Readers keep the blackboard of a run that was let go.
            Err(BlackboardCreateError::AlreadyExists) => node
                .service_builder(&name)
                .blackboard_opener::<u64>()
                .open()
                .map_err(|error| match error {
                    BlackboardOpenError::IncompatibleKeys => ChannelError::OtherVersion(text),
                    error => ChannelError::TakeOver(error),
                })?,
            Err(error) => return Err(ChannelError::Blackboard(error)),
        };
        let failed = |error: &dyn Debug| ChannelError::Writer(format!("{error:?}"));
        let writer = service.writer_builder().create();
        let writer = writer.map_err(|error| match error {
            WriterCreateError::ExceedsMaxSupportedWriters => ChannelError::Taken,
            error => failed(&error),
        })?;
        let entry = writer.entry::<RunStatus>(&STATUS_KEY);
        Ok(Self {
            entry: entry.map_err(|error| failed(&error))?,
            _writer: writer,
            _service: service,
            due: Due::default(),
            last: None,
        })
    }

    pub(super) fn offer(&mut self, run: &Run) {
        if self.due.is_due(STATUS_EVERY) {
            self.put(run, 0);
        }
    }

    /// Writes a state of `STATES`.
    pub(super) fn put(&mut self, run: &Run, state: u32) {
        let started = Instant::now();
        let (progress, info) = (run.progress(), FrameInfo::of(run));
        let done = progress.robot_steps_done;
        let speed = self.last.map_or(0.0, |(at, before)| {
            let seconds = started.duration_since(at).as_secs_f64();
            done.saturating_sub(before) as f64 / seconds.max(1e-9)
        });
        self.last = Some((started, done));
        self.entry.update_with_copy(RunStatus {
            arena_step: info.arena_step,
            robot_steps_done: done,
            robot_steps_total: progress.robot_steps_total,
            sim_time_s: info.arena_step as f64 * info.step_s,
            robot_steps_per_s: speed,
            phase: phase_code(progress.phase),
            state,
            epochs_done: progress.epochs_done,
            epochs_total: progress.epochs_total,
            robots: run.spec().robots,
            version: CHANNELS_VERSION,
        });
        self.due.note(started);
    }
}
