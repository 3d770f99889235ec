//! What a program must know to open the channels of a run.

use std::collections::BTreeMap;

use api::channels::{
    AskedBy, CHANNELS_VERSION, ChannelDescription, CoverageHeader, EVENTS, FieldNames, MetricValue,
    MetricsHeader, RunEvent, RunStatus, STATES, SquareEntries, run_service,
};
use api::external::{
    Answered, Asked, EXTERNAL_VERSION, RobotSense, Side, WheelCommand, external_bell,
    external_service, share,
};
use api::frames::{
    FRAMES_VERSION, FrameHeader, ObjectState, PHASES, RobotState, RootError, TypeLayout,
    frames_service, objects_service, transport_config,
};

use super::desk::{Desk, Fate};
use super::extent::Extent;
use super::port::{HISTORY, MAX_SUBSCRIBERS, subscriber_buffer};
use super::set::ChannelSet;
use super::settings::ChannelSettings;

/// Every channel that a run has or may have, in a fixed order. Those whose samples are too large for
/// a channel are left out.
///
/// # Errors
/// [`RootError`] when the configured root cannot be used.
pub fn describe(
    settings: &ChannelSettings,
    run_id: &str,
    extent: Extent,
    by_spec: ChannelSet,
    desk: Option<&Desk>,
) -> Result<Vec<ChannelDescription>, RootError> {
    let config = transport_config(&settings.root)?;
    let asked = desk.map(Desk::asked).unwrap_or_default();
    let of = Of {
        root_path: config.global.root_path().to_string(),
        prefix: config.global.prefix.to_string(),
        fates: desk.map(Desk::fates).unwrap_or_default(),
    };
    let Extent {
        robots, objects, ..
    } = extent;
    let by = |wants: fn(&ChannelSet) -> bool| match (wants(&by_spec), wants(&asked)) {
        (true, _) => Some(AskedBy::Spec),
        (false, true) => Some(AskedBy::Request),
        (false, false) => None,
    };
    let phases = names("phase", &PHASES);
    let frames = Some(settings.max_frames_per_second);
    let mut all = vec![
        of.latest::<RobotState>("frames", by(|set| set.frames), robots)
            .map(|it| it.service(frames_service(run_id)))
            .map(|it| it.of_frames(RobotState::layout(), &phases, frames)),
    ];
    if objects > 0 {
        let shown = of.latest::<ObjectState>("objects", by(|set| set.frames), objects);
        let shown = shown.map(|it| it.service(objects_service(run_id)));
        all.push(shown.map(|it| it.of_frames(ObjectState::layout(), &phases, frames)));
    }
    let lossless = of.latest::<RobotState>("lossless", by(|set| set.lossless.is_some()), robots);
    all.push(lossless.map(|mut it| {
        it.0.history = 0;
        it.service(run_service(run_id, "lossless"))
            .of_frames(RobotState::layout(), &phases, None)
    }));
    let coverage = of.latest::<SquareEntries>("coverage", by(|set| set.coverage), extent.squares);
    all.push(coverage.map(|mut it| {
        it.0.header = Some(CoverageHeader::layout());
        it.0.payload = SquareEntries::layout();
        it.0.max_per_second = Some(2);
        it.service(run_service(run_id, "coverage"))
    }));
    let values = 4 + swarm::metrics::over_time().count();
    let rows = of.latest::<MetricValue>("metrics", by(|set| set.metrics), values);
    all.push(rows.map(|mut it| {
        it.0.header = Some(MetricsHeader::layout());
        it.0.payload = MetricValue::layout();
        it.service(run_service(run_id, "metrics"))
    }));
    let events = of.latest::<RunEvent>("events", by(|set| set.metrics), 1);
    all.push(events.map(|mut it| {
        it.0.payload = RunEvent::layout();
        it.0.names = vec![names("kind", &EVENTS), names("value of ended", &STATES)];
        it.service(run_service(run_id, "events"))
    }));
    let status = of.latest::<RunStatus>("status", by(|set| set.status), 1);
    all.push(status.map(|mut it| {
        it.0.pattern = "blackboard".to_owned();
        it.0.payload = RunStatus::layout();
        it.0.max_per_second = Some(4);
        it.0.names = vec![phases.clone(), names("state", &STATES)];
        it.service(run_service(run_id, "status"))
    }));
    for controller in 0..extent.controllers {
        let (_, count) = share(robots, extent.controllers, controller);
        all.push(Some(of.external(run_id, controller, count)));
    }
    Ok(all.into_iter().flatten().map(|it| it.0).collect())
}

fn names(field: &str, names: &[&str]) -> FieldNames {
    FieldNames {
        field: field.to_owned(),
        names: names.iter().map(|&name| name.to_owned()).collect(),
    }
}

/// What all descriptions of a run have in common.
struct Of {
    root_path: String,
    prefix: String,
    fates: BTreeMap<&'static str, Fate>,
}

/// A description that is being made.
struct Described(ChannelDescription);

impl Of {
    /// A channel of slices of so many `T`; `None` where they are too large.
    fn latest<T>(&self, name: &str, by: Option<AskedBy>, elements: usize) -> Option<Described> {
        let mut described = self.any(name, by);
        described.0.subscriber_buffer = subscriber_buffer::<T>(elements)?;
        described.0.payload_elements = elements;
        described.0.payload_bytes = elements * size_of::<T>();
        Some(described)
    }

    fn any(&self, name: &str, by: Option<AskedBy>) -> Described {
        let fate = self.fates.get(name);
        Described(ChannelDescription {
            name: name.to_owned(),
            is_open: fate == Some(&Fate::Open),
            asked_by: by,
            closed_because: match fate {
                Some(Fate::Closed(why)) if by.is_some() => Some(why.clone()),
                _ => None,
            },
            transport: "iceoryx2 0.10".to_owned(),
            pattern: "publish-subscribe".to_owned(),
            service: String::new(),
            bells: Vec::new(),
            root_path: self.root_path.clone(),
            prefix: self.prefix.clone(),
            version: CHANNELS_VERSION,
            payload: TypeLayout::default(),
            payload_elements: 0,
            payload_bytes: 0,
            header: None,
            answer: None,
            answer_header: None,
            max_per_second: None,
            max_subscribers: MAX_SUBSCRIBERS,
            subscriber_buffer: 1,
            history: HISTORY,
            names: Vec::new(),
        })
    }

    /// The questions to a controller of so many robots.
    fn external(&self, run_id: &str, controller: usize, robots: usize) -> Described {
        let mut described = self.any("external", Some(AskedBy::Method));
        let it = &mut described.0;
        it.pattern = "request-response".to_owned();
        it.bells = [Side::Asked, Side::Answered]
            .map(|side| external_bell(run_id, controller, side))
            .to_vec();
        it.version = EXTERNAL_VERSION;
        it.payload = RobotSense::layout();
        it.payload_elements = robots;
        it.payload_bytes = robots * size_of::<RobotSense>();
        it.header = Some(Asked::layout());
        it.answer = Some(WheelCommand::layout());
        it.answer_header = Some(Answered::layout());
        it.max_subscribers = 1;
        it.history = 0;
        described.service(external_service(run_id, controller))
    }
}

impl Described {
    fn service(mut self, service: String) -> Self {
        self.0.service = service;
        self
    }

    fn of_frames(mut self, payload: TypeLayout, phases: &FieldNames, most: Option<u32>) -> Self {
        self.0.version = FRAMES_VERSION;
        self.0.payload = payload;
        self.0.header = Some(FrameHeader::layout());
        self.0.max_per_second = most;
        self.0.names = vec![phases.clone()];
        self
    }
}
