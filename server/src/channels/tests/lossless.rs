//! Frames of which none is lost, where a reader is there before the sender.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, mpsc};

use api::channels::run_service;
use api::reader::{FrameReader, ReaderError};
use serde_json::json;
use swarm::run::Run;

use super::super::desk::Desks;
use super::super::lossless::Lossless;
use super::super::patience::Wanted;
use super::super::port::{SendFailure, open_node, open_service};
use super::super::set::{ChannelSet, LosslessSettings};
use super::*;

const ROBOTS: usize = 2;

/// Frames that are sent: several times what a buffer holds.
const FRAMES: u64 = 60;

/// A run, and its lossless channel under a root, whose service a reader has made already.
fn late_channel(root: &Path, timeout_ms: u32) -> (Run, Lossless) {
    let spec = json!({ "arena": "easy", "controller": { "method": "brownian" }, "robots": ROBOTS,
        "placement": "grid" });
    let spec = crate::documents::resolve(&spec, &crate::documents::BuiltinArenas).unwrap();
    let run = Run::new(spec.run_spec()).unwrap();
    let settings = LosslessSettings {
        every_steps: 1,
        timeout_ms,
        readers: 1,
    };
    let set = ChannelSet {
        lossless: Some(settings),
        ..ChannelSet::default()
    };
    let desk = Desks::default().ask("run", set).unwrap();
    let wanted = Wanted::new(&Arc::new(AtomicBool::new(false)), &desk, settings);
    let channel = Lossless::open(root, "run", robots(ROBOTS), settings, wanted).unwrap();
    (run, channel)
}

/// A reader that is there before anybody sends. It is not connected before it looks for a frame.
fn early_reader(root: &Path) -> Reader {
    let node = open_node(root).unwrap();
    let name = ServiceName::new(&run_service("run", "lossless")).unwrap();
    let buffer = super::super::port::subscriber_buffer::<RobotState>(ROBOTS).unwrap();
    let service = open_service(&node, &name, buffer, true).unwrap();
    Reader {
        subscriber: service.subscriber_builder().create().unwrap(),
        service,
        _node: node,
    }
}

#[test]
fn a_reader_that_came_before_the_sender_loses_no_frame() {
    let root = Root::new();
    let path = root.settings.root.clone();
    let (came, has_come) = mpsc::channel();
    let (sends, is_sent) = mpsc::channel::<()>();
    let reader = std::thread::spawn(move || {
        let reader = early_reader(&path);
        came.send(()).unwrap();
        is_sent.recv().unwrap();
        // It looks only when the run has long filled its buffer.
        std::thread::sleep(Duration::from_millis(300));
        for step in 0..FRAMES {
            let frame = reader.wait_for(|_| true);
            assert_eq!(frame.user_header().arena_step, step);
            assert_eq!(frame.user_header().sequence, step);
        }
    });
    has_come.recv().unwrap();
    let (mut run, mut channel) = late_channel(&root.settings.root, 20_000);
    sends.send(()).unwrap();
    for _ in 0..FRAMES {
        channel.offer(&run, &()).unwrap();
        run.advance(1);
    }
    reader.join().unwrap();
}

#[test]
fn a_reader_that_never_looks_is_not_waited_for_beyond_the_time() {
    let root = Root::new();
    let _reader = early_reader(&root.settings.root);
    let (mut run, mut channel) = late_channel(&root.settings.root, 200);
    let failed = (0..FRAMES).find_map(|_| {
        let offered = channel.offer(&run, &());
        run.advance(1);
        offered.err()
    });
    assert!(matches!(failed, Some(SendFailure::Send(_))), "{failed:?}");
    assert!((1..FRAMES).contains(&(run.step() - 1)));
}

#[test]
fn a_reader_that_loses_what_another_got_is_told_of() {
    let root = Root::new();
    let _early = early_reader(&root.settings.root);
    let (mut run, mut channel) = late_channel(&root.settings.root, 20_000);
    let service = run_service("run", "lossless");
    let other = Reader::<RobotState>::of_service(&root.settings, &service).unwrap();
    let mut sent = 0;
    let failed = loop {
        match channel.offer(&run, &()) {
            Ok(()) => sent += 1,
            Err(failed) => break failed,
        }
        assert!(other.subscriber.receive().unwrap().is_some());
        run.advance(1);
    };
    assert!(matches!(failed, SendFailure::Missed), "{failed:?}");
    assert!((1..FRAMES).contains(&sent));
}

#[test]
fn readers_of_our_own_wait_for_the_sender() {
    let root = Root::new();
    let path = &root.settings.root;
    let early = early_reader(path);
    let service = run_service("run", "lossless");
    let opened = FrameReader::open(path, &service);
    assert!(matches!(opened, Err(ReaderError::Absent(_))));
    drop(early);
    let (mut run, mut channel) = late_channel(path, 20_000);
    let reader = FrameReader::open(path, &service).unwrap();
    assert!(!reader.is_closed());
    // As many as it has room for, while it does not look.
    for _ in 0..16 {
        channel.offer(&run, &()).unwrap();
        run.advance(1);
    }
    drop(channel);
    let wait = || reader.wait(Duration::from_secs(20)).unwrap();
    let steps: Vec<_> = std::iter::from_fn(wait)
        .map(|frame| frame.user_header().arena_step)
        .collect();
    assert_eq!(steps, (0..16).collect::<Vec<_>>());
    assert!(reader.is_closed());
}
