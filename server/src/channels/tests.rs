//! Channels against real shared memory: each test has a root path, and so a name space, of its own.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod lossless;
mod objects;

use std::fmt::Debug;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::publish_subscribe;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use api::frames::{
    FRAMES_VERSION, FrameHeader, PHASES, RobotState, frames_service, transport_config,
};
use swarm::run::{Phase, Progress};
use swarm::world::{Bodies, Body, Objects};

use super::frame::{FrameInfo, phase_code};
use super::publisher::{Copied, FramePublisher};
use super::*;

type FrameSample<T> = Sample<ipc::Service, [T], FrameHeader>;

/// Only robots, so many.
fn robots(robots: usize) -> Extent {
    Extent {
        robots,
        ..Extent::default()
    }
}

/// A temporary root; removes what the transport left behind, in shared memory too.
struct Root {
    folder: tempfile::TempDir,
    settings: ChannelSettings,
}

impl Root {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("channels");
        let settings = ChannelSettings {
            root,
            ..ChannelSettings::default()
        };
        Self { folder, settings }
    }

    fn shared_memory(&self) -> Vec<PathBuf> {
        let prefix = transport_config(&self.settings.root)
            .unwrap()
            .global
            .prefix
            .to_string();
        let entries = std::fs::read_dir("/dev/shm")
            .into_iter()
            .flatten()
            .flatten();
        entries
            .map(|entry| entry.path())
            .filter(|path| path.to_string_lossy().contains(&prefix))
            .collect()
    }
}

impl Drop for Root {
    fn drop(&mut self) {
        for path in self.shared_memory() {
            drop(std::fs::remove_file(path));
        }
        drop(std::fs::remove_dir_all(self.folder.path()));
    }
}

struct Reader<T: Copy + Debug + ZeroCopySend + 'static = RobotState> {
    subscriber: Subscriber<ipc::Service, [T], FrameHeader>,
    service: publish_subscribe::PortFactory<ipc::Service, [T], FrameHeader>,
    _node: Node<ipc::Service>,
}

impl Reader {
    fn open(settings: &ChannelSettings, run_id: &str) -> Self {
        Self::of_service(settings, &frames_service(run_id)).unwrap()
    }
}

impl<T: Copy + Debug + ZeroCopySend + 'static> Reader<T> {
    /// `None` where there is no such service.
    fn of_service(settings: &ChannelSettings, name: &str) -> Option<Self> {
        let node = NodeBuilder::new()
            .config(&transport_config(&settings.root).unwrap())
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .unwrap();
        let service = node
            .service_builder(&ServiceName::new(name).unwrap())
            .publish_subscribe::<[T]>()
            .user_header::<FrameHeader>()
            .open();
        let service = match service {
            Err(PublishSubscribeOpenError::DoesNotExist) => return None,
            service => service.unwrap(),
        };
        let subscriber = service.subscriber_builder().create().unwrap();
        Some(Self {
            subscriber,
            service,
            _node: node,
        })
    }

    /// The next frame that the condition holds for.
    fn wait_for(&self, wanted: impl Fn(&FrameSample<T>) -> bool) -> FrameSample<T> {
        eventually("a frame", || {
            self.subscriber
                .receive()
                .unwrap()
                .filter(|frame| wanted(frame))
        })
    }
}

/// Asks again and again until there is an answer, for as long as a loaded machine may need.
fn eventually<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(
            started.elapsed() < Duration::from_secs(20),
            "no {what} came"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Robots whose every value tells the robot and the step.
fn bodies(step: u64, count: usize) -> Bodies {
    let start = swarm::world::StartPose {
        x_m: 0.0,
        y_m: 0.0,
        cos: 1.0,
        sin: 0.0,
    };
    (0..count)
        .map(|robot| {
            let x_m = robot as f32 + step as f32 * 1e-3;
            let mut body = Body::at_rest(&start);
            (body.x_m, body.y_m) = (x_m, x_m);
            (body.reading.proximity, body.command) = ([x_m; 8], [x_m, -x_m]);
            body
        })
        .collect::<Vec<_>>()
        .into()
}

fn info(step: u64) -> FrameInfo {
    let progress = Progress {
        phase: Phase::Exploration,
        epochs_done: 3,
        epochs_total: 20,
        robot_steps_done: 2 * step,
        robot_steps_total: 1_000_000,
    };
    FrameInfo {
        arena_step: step,
        progress,
        step_s: 0.064,
    }
}

/// Not by `offer_moment`, which skips a frame while the other side holds the slot: tests wait for
/// the very frame that they offered.
fn offer(publisher: &mut FramePublisher, step: u64, robots: usize) {
    let (bodies, objects) = (bodies(step, robots), Objects::default());
    publisher.put_moment(&bodies, &objects, &info(step));
}

#[test]
fn readers_see_what_was_offered() {
    let root = Root::new();
    let mut publisher = FramePublisher::open(&root.settings, "run", robots(2)).unwrap();
    let reader = Reader::open(&root.settings, "run");
    offer(&mut publisher, 500, 2);
    let frame = reader.wait_for(|_| true);
    let header = frame.user_header();
    assert_eq!(
        (header.arena_step, header.robot_steps_done, header.robots),
        (500, 1000, 2)
    );
    assert_eq!(
        (header.version, header.phase_name()),
        (FRAMES_VERSION, "exploration")
    );
    assert!((header.sim_time_s - 32.0).abs() < 1e-9);
    let robot = frame.payload()[1];
    assert_eq!((robot.number, robot.x_m, robot.sensors), (1, 1.5, [1.5; 8]));
    assert_eq!(robot.commands, [1.5, -1.5]);
}

#[test]
fn a_late_reader_of_a_silent_channel_gets_the_last_frame() {
    let root = Root::new();
    let mut publisher = FramePublisher::open(&root.settings, "run", robots(1)).unwrap();
    offer(&mut publisher, 41, 1);
    std::thread::sleep(Duration::from_millis(200));
    let reader = Reader::open(&root.settings, "run");
    assert_eq!(reader.wait_for(|_| true).user_header().arena_step, 41);
    eventually("watched state", || publisher.slot.watched().then_some(()));
}

#[test]
fn the_last_frame_arrives_although_the_channel_closes() {
    let root = Root::new();
    let mut publisher = FramePublisher::open(&root.settings, "run", robots(1)).unwrap();
    let reader = Reader::open(&root.settings, "run");
    offer(&mut publisher, 1, 1);
    reader.wait_for(|frame| frame.user_header().arena_step == 1);
    offer(&mut publisher, 2, 1);
    drop(publisher);
    reader.wait_for(|frame| frame.user_header().arena_step == 2);
}

#[test]
fn frames_may_outgrow_the_first_length() {
    let root = Root::new();
    let mut publisher = FramePublisher::open(&root.settings, "run", robots(1)).unwrap();
    let reader = Reader::open(&root.settings, "run");
    for (step, robots) in [(1, 1), (2, 3), (3, 1_000), (4, 20_000), (5, 2)] {
        offer(&mut publisher, step, robots);
        let frame = reader.wait_for(|frame| frame.user_header().arena_step == step);
        assert_eq!(frame.payload().len(), robots);
        assert_eq!(frame.payload()[robots - 1].number as usize, robots - 1);
    }
}

#[test]
fn two_runs_have_channels_of_their_own() {
    let root = Root::new();
    let names = ["first", "second"];
    let mut publishers =
        names.map(|name| FramePublisher::open(&root.settings, name, robots(1)).unwrap());
    let readers = names.map(|name| Reader::open(&root.settings, name));
    // Long enough that each has searched for dead nodes and must not have found the other.
    let started = Instant::now();
    let mut step = 0;
    while started.elapsed() < CLEAN_UPS {
        step += 2;
        for (i, publisher) in (0..).zip(&mut publishers) {
            offer(publisher, step + i, 1);
        }
        for (i, reader) in (0..).zip(&readers) {
            reader.wait_for(|frame| frame.user_header().arena_step == step + i);
        }
    }
}

#[test]
fn a_run_has_one_publisher_at_a_time() {
    let root = Root::new();
    let first = FramePublisher::open(&root.settings, "run", robots(1)).unwrap();
    let reader = Reader::open(&root.settings, "run");
    let error = FramePublisher::open(&root.settings, "run", robots(1)).unwrap_err();
    assert!(matches!(error, ChannelError::Taken), "{error}");
    drop(first);
    // The reader goes on when the run is paused and resumed.
    let mut second = FramePublisher::open(&root.settings, "run", robots(1)).unwrap();
    offer(&mut second, 9, 1);
    reader.wait_for(|frame| frame.user_header().arena_step == 9);
}

/// Time in which publishers have searched for dead nodes at least twice.
const CLEAN_UPS: Duration = Duration::from_millis(2_500);

#[test]
fn frames_are_rationed() {
    let root = Root::new();
    let mut publisher = FramePublisher::open(&root.settings, "run", robots(1)).unwrap();
    assert!(publisher.is_due(), "the first frame is sent at once");
    offer(&mut publisher, 1, 1);
    assert!(
        !publisher.is_due(),
        "unwatched, one frame a second is enough"
    );
    std::thread::sleep(Duration::from_millis(100));
    assert!(!publisher.is_due());
    let _reader = Reader::open(&root.settings, "run");
    eventually("due frame", || publisher.is_due().then_some(()));
    let copied = |took, before| {
        Some(Copied {
            at: Instant::now(),
            took,
            before,
        })
    };
    let (long, short) = (Duration::from_secs(10), Duration::from_micros(30));
    publisher.copied = copied(long, long);
    std::thread::sleep(Duration::from_millis(50));
    assert!(!publisher.is_due(), "long copies make frames rarer");
    publisher.copied = copied(long, short);
    eventually("due frame", || publisher.is_due().then_some(()));
}

#[test]
fn a_channel_that_cannot_be_opened_is_a_warning() {
    let root = Root::new();
    std::fs::write(&root.settings.root, "a file, not a folder").unwrap();
    let error = FramePublisher::open(&root.settings, "run", robots(1)).unwrap_err();
    assert!(matches!(error, ChannelError::Folder { .. }), "{error}");
    let relative = ChannelSettings {
        root: "channels".into(),
        ..root.settings.clone()
    };
    assert!(FramePublisher::open(&relative, "run", robots(1)).is_err());
    let endless = "x".repeat(5_000);
    let usable = ChannelSettings {
        root: root.folder.path().join("ok"),
        ..root.settings.clone()
    };
    assert!(FramePublisher::open(&usable, &endless, robots(1)).is_err());
    assert!(FramePublisher::open(&usable, "run", robots(100_000_000)).is_err());
}

#[test]
fn descriptions_match_the_channel() {
    let root = Root::new();
    let extent = Extent {
        objects: 2,
        squares: 10_000,
        controllers: 2,
        ..robots(3)
    };
    let described = |extent, desk| {
        let by_spec = ChannelSet::of_spec(true);
        describe(&root.settings, "run", extent, by_spec, desk).unwrap()
    };
    let desk = Desk::default();
    desk.say("frames", Some(Fate::Open));
    desk.say("coverage", Some(Fate::Closed("why".to_owned())));
    let channels = described(extent, Some(&desk));
    let names: Vec<_> = channels.iter().map(|it| it.name.as_str()).collect();
    let expected = [
        "frames", "objects", "lossless", "coverage", "metrics", "events", "status", "external",
        "external",
    ];
    assert_eq!(names, expected);
    let frames = &channels[0];
    assert_eq!(frames.service, "swarm/run/frames");
    assert_eq!(Path::new(&frames.root_path), root.settings.root);
    assert_eq!(frames.payload_bytes, 3 * size_of::<RobotState>());
    assert!(frames.is_open && frames.closed_because.is_none());
    let coverage = &channels[3];
    assert_eq!((coverage.is_open, coverage.payload_bytes), (false, 40_000));
    assert_eq!(coverage.closed_because.as_deref(), Some("why"));
    assert_eq!(channels[2].asked_by, None, "lossless has to be asked for");
    let asked = [&channels[7], &channels[8]].map(|it| (it.service.as_str(), it.payload_elements));
    assert_eq!(
        asked,
        [("swarm/run/external/0", 2), ("swarm/run/external/1", 1)]
    );
    for channel in &channels {
        let suffix = format!(".v{}", channel.version);
        assert!(channel.payload.type_name.ends_with(&suffix), "{channel:?}");
    }
    // Frames of so many robots do not fit; the other channels do.
    let large = described(robots(100_000_000), None);
    assert!(
        large
            .iter()
            .all(|it| it.name != "frames" && it.name != "lossless")
    );
    for (code, &phase) in Phase::ALL.iter().enumerate() {
        assert_eq!(phase_code(phase) as usize, code);
        assert_eq!(PHASES[code], phase.name());
    }
}

/// Name by which the test below finds itself, and the variable that makes it read.
const READER: (&str, &str) = (
    "channels::tests::reader_process",
    "EVSWARM_TEST_READER_ROOT",
);

/// Does nothing unless the test below starts it: then it is a reader in a process of its own, which
/// outlives the test that kills it only if that test itself was killed, and then not for long.
#[test]
fn reader_process() {
    let Some(root) = std::env::var_os(READER.1) else {
        return;
    };
    let reader = Reader::open(
        &ChannelSettings {
            root: root.into(),
            ..ChannelSettings::default()
        },
        "run",
    );
    let started = Instant::now();
    while started.elapsed() < Duration::from_secs(60) {
        drop(reader.subscriber.receive());
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn start_reader_process(root: &Path) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args([READER.0, "--exact", "--nocapture"])
        .env(READER.1, root)
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
fn a_reader_that_is_killed_does_not_hold_up_the_others() {
    let root = Root::new();
    let mut publisher = FramePublisher::open(&root.settings, "run", robots(100)).unwrap();
    let reader = Reader::open(&root.settings, "run");
    let mut doomed = start_reader_process(&root.settings.root);
    let readers = || reader.service.dynamic_config().number_of_subscribers();
    let mut step = 0;
    let mut slowest = Duration::ZERO;
    let mut exchange = |publisher: &mut FramePublisher| {
        step += 1;
        let started = Instant::now();
        offer(publisher, step, 100);
        reader.wait_for(|frame| frame.user_header().arena_step == step);
        slowest = slowest.max(started.elapsed());
        slowest
    };
    eventually("second reader", || {
        exchange(&mut publisher);
        (readers() == 2).then_some(())
    });
    doomed.kill().unwrap();
    doomed.wait().unwrap();
    // Many times the dead reader's buffer.
    let slowest = (0..500).map(|_| exchange(&mut publisher)).max().unwrap();
    assert!(slowest < Duration::from_secs(1), "a frame took {slowest:?}");
    eventually("clean-up", || {
        exchange(&mut publisher);
        (readers() == 1).then_some(())
    });
}

/// Nodes of processes that were killed, under a root.
fn dead_nodes(settings: &ChannelSettings) -> usize {
    let mut dead = 0;
    let config = transport_config(&settings.root).unwrap();
    Node::<ipc::Service>::list(&config, |node| {
        dead += usize::from(matches!(node, NodeState::Dead(_)));
        CallbackProgression::Continue
    })
    .unwrap();
    dead
}

#[test]
fn what_killed_processes_leave_is_removed_at_the_start_and_again_and_again() {
    let root = Root::new();
    let kill_a_reader = || {
        let publisher = FramePublisher::open(&root.settings, "run", robots(1)).unwrap();
        let mut doomed = start_reader_process(&root.settings.root);
        eventually("watched state", || publisher.slot.watched().then_some(()));
        drop(publisher);
        doomed.kill().unwrap();
        doomed.wait().unwrap();
    };
    kill_a_reader();
    assert_eq!(dead_nodes(&root.settings), 1);
    let _cleaner = cleaning::Cleaner::every(root.settings.root.clone(), Duration::from_millis(50));
    let clean = || {
        let left = root.shared_memory();
        (dead_nodes(&root.settings) == 0 && left.len() <= 1).then_some(())
    };
    eventually("clean shared memory", clean);
    // One that is killed later, with the cleaner's next round.
    kill_a_reader();
    eventually("clean shared memory", clean);
}
