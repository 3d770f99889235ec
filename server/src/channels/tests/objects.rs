//! Movable objects beside the robots of the same moment.

use api::frames::{ObjectState, objects_service};
use swarm::run::Run;
use swarm::world::ObjectPose;

use super::*;

const BOTH: Extent = Extent {
    robots: 2,
    objects: 3,
    squares: 0,
    controllers: 0,
};

/// Objects whose every value tells the object and the step.
fn objects(step: u64, count: usize) -> Objects {
    let x_m = |object: usize| object as f32 + step as f32 * 1e-3;
    let pose = |object| ObjectPose {
        x_m: x_m(object),
        y_m: -x_m(object),
        cos: 0.0,
        sin: 1.0,
    };
    Objects {
        poses: (0..count).map(pose).collect(),
        moved_m: (0..count).map(|object| f64::from(x_m(object))).collect(),
    }
}

fn object_reader(root: &Root) -> Option<Reader<ObjectState>> {
    Reader::of_service(&root.settings, &objects_service("run"))
}

#[test]
fn objects_come_with_the_robots_of_their_moment() {
    let root = Root::new();
    let mut publisher = FramePublisher::open(&root.settings, "run", BOTH).unwrap();
    let robots = Reader::open(&root.settings, "run");
    let objects_of = object_reader(&root).unwrap();
    // Their number may change: the training arena has others than the target.
    for (step, count) in [(1, 3), (2, 0), (3, 1), (4, 3)] {
        publisher.put_moment(&bodies(step, 2), &objects(step, count), &info(step));
        let frame = robots.wait_for(|frame| frame.user_header().arena_step == step);
        // No waiting: whoever has the robots can have the objects.
        let beside = loop {
            let next = objects_of.subscriber.receive().unwrap().unwrap();
            if next.user_header().arena_step == step {
                break next;
            }
        };
        assert_eq!(beside.user_header(), frame.user_header());
        let expected: Vec<_> = (0..count)
            .map(|object| ObjectState {
                x_m: object as f32 + step as f32 * 1e-3,
                y_m: -(object as f32 + step as f32 * 1e-3),
                heading_rad: std::f32::consts::FRAC_PI_2,
                moved_m: object as f32 + step as f32 * 1e-3,
            })
            .collect();
        assert_eq!(beside.payload(), expected);
    }
}

#[test]
fn a_reader_of_objects_alone_is_served_too() {
    let root = Root::new();
    let mut publisher = FramePublisher::open(&root.settings, "run", BOTH).unwrap();
    publisher.put_moment(&bodies(7, 2), &objects(7, 3), &info(7));
    std::thread::sleep(Duration::from_millis(200));
    let late = object_reader(&root).unwrap();
    assert_eq!(late.wait_for(|_| true).user_header().arena_step, 7);
    eventually("watched state", || publisher.slot.watched().then_some(()));
}

#[test]
fn only_a_run_with_objects_has_a_channel_for_them() {
    let root = Root::new();
    let _publisher = FramePublisher::open(&root.settings, "run", robots(1)).unwrap();
    assert!(object_reader(&root).is_none());
    let described =
        |extent| describe(&root.settings, "run", extent, ChannelSet::default(), None).unwrap();
    assert!(described(robots(1)).iter().all(|it| it.name != "objects"));
    let channels = described(BOTH);
    let names: Vec<_> = channels.iter().map(|channel| &channel.name[..]).collect();
    assert_eq!(names[..2], ["frames", "objects"]);
    assert_eq!(channels[1].service, "swarm/run/objects");
    assert_eq!(channels[1].payload, ObjectState::layout());
    assert_eq!(channels[1].header, channels[0].header);
}

#[test]
fn a_runs_objects_are_sent_as_they_are() {
    let spec = serde_json::json!({ "engine": "rapier", "episodes": "continue", "robots": 3,
        "placement": "random", "controller": { "method": "brownian" }, "arena": {
            "name": "yard", "width_m": 0.6, "height_m": 0.6, "walls_m": [],
            "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.8 }],
            "objects": [
                { "kind": "box", "x_m": 0.2, "y_m": 0.2, "width_m": 0.06, "height_m": 0.04 },
                { "kind": "disc", "x_m": 0.35, "y_m": 0.3, "radius_m": 0.03 }
            ]
    } });
    let spec = crate::documents::resolve(&spec, &crate::documents::BuiltinArenas).unwrap();
    let mut run = Run::new(spec.run_spec()).unwrap();
    run.advance(3_000);
    let root = Root::new();
    let extent = Extent::of(run.spec());
    assert_eq!((extent.robots, extent.objects), (3, 2));
    let mut publisher = FramePublisher::open(&root.settings, "run", extent).unwrap();
    publisher.offer_now(&run);
    let reader = object_reader(&root).unwrap();
    let frame = reader.wait_for(|frame| frame.user_header().arena_step == 3_000);
    let known = run.objects();
    assert_eq!(frame.payload().len(), 2);
    for (sent, object) in frame.payload().iter().zip(&known) {
        assert_eq!([sent.x_m, sent.y_m], [object.pose.x_m, object.pose.y_m]);
        assert!((sent.heading_rad.sin() - object.pose.sin).abs() < 1e-6);
        assert_eq!(sent.moved_m, object.moved_m as f32);
    }
    assert!(known.iter().any(|object| object.moved_m > 0.0));
}
