//! The channels of a run that is being stepped: opened and closed as they are wanted, between two
//! blocks of steps, by the run's thread.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use iceoryx2::prelude::{Node, ipc};
use swarm::run::{Progress, Run};

use super::desk::{Desk, Fate};
use super::extent::Extent;
use super::lossless::Lossless;
use super::patience::Wanted;
use super::port::{ChannelError, SendFailure, open_node};
use super::publisher::FramePublisher;
use super::reports::{Coverage, Metrics, Status};
use super::set::ChannelSet;
use super::settings::ChannelSettings;
use crate::runner::{Attendant, Ended, Observer, Stop};

/// Time after which a channel that could not be opened is tried again.
const AGAIN: Duration = Duration::from_secs(10);
/// Time between two looks at what is seldom sent.
const LOOK: Duration = Duration::from_millis(50);

/// The channels of a run. Fields are dropped in this order; ports before their node.
pub struct RunChannels<'a> {
    settings: ChannelSettings,
    run_id: String,
    extent: Extent,
    by_spec: ChannelSet,
    desk: Arc<Desk>,
    stopping: Arc<AtomicBool>,
    attendant: &'a dyn Attendant,
    seen: Option<u64>,
    again: Option<Instant>,
    looked: Option<Instant>,
    complained: bool,
    frames: Option<FramePublisher>,
    lossless: Option<Lossless>,
    coverage: Option<Coverage>,
    metrics: Option<Metrics>,
    status: Option<Status>,
    node: Option<Node<ipc::Service>>,
}

impl<'a> RunChannels<'a> {
    /// The channels of a run of which the spec wants some; `desk` says what else is wanted, and
    /// `stopping` that the run is to be let go; the attendant has it while it waits for readers.
    pub fn new(
        settings: &ChannelSettings,
        run_id: &str,
        extent: Extent,
        by_spec: ChannelSet,
        desk: Arc<Desk>,
        stopping: Arc<AtomicBool>,
        attendant: &'a dyn Attendant,
    ) -> Self {
        Self {
            settings: settings.clone(),
            run_id: run_id.to_owned(),
            extent,
            by_spec,
            desk,
            stopping,
            attendant,
            seen: None,
            again: None,
            looked: None,
            complained: false,
            frames: None,
            lossless: None,
            coverage: None,
            metrics: None,
            status: None,
            node: None,
        }
    }

    /// Opens and closes what has changed.
    fn reconcile(&mut self, run: &Run) {
        let changes = self.desk.changes();
        let is_due = self.again.is_some_and(|again| Instant::now() >= again);
        if self.seen == Some(changes) && !is_due {
            return;
        }
        let is_asked_anew = self.seen.replace(changes) != Some(changes);
        self.again = None;
        let wanted = self.by_spec.or(self.desk.asked());
        if !wanted.frames {
            self.frames = None;
        } else if self.frames.is_none() {
            let opened = FramePublisher::open(&self.settings, &self.run_id, self.extent);
            self.frames = self.told(&["frames", "objects"], opened);
        }
        if !wanted.coverage {
            self.coverage = None;
        } else if self.coverage.is_none() {
            let opened = self.on_node(|of, node| Coverage::open(node, &of.run_id, of.extent));
            self.coverage = self.told(&["coverage"], opened);
        }
        if !wanted.metrics {
            self.metrics = None;
        } else if self.metrics.is_none() {
            let opened = self.on_node(|of, node| Metrics::open(node, &of.run_id, run));
            self.metrics = self.told(&["metrics", "events"], opened);
        }
        if !wanted.status {
            self.status = None;
        } else if self.status.is_none() {
            let opened = self.on_node(|of, node| Status::open(node, &of.run_id));
            self.status = self.told(&["status"], opened);
        }
        if self.status.is_none() && self.metrics.is_none() && self.coverage.is_none() {
            self.node = None;
        }
        let is_other = self.lossless.as_ref().map(Lossless::settings) != wanted.lossless;
        if is_other && is_asked_anew {
            self.lossless = None;
            if let Some(settings) = wanted.lossless {
                let asked = Wanted::new(&self.stopping, &self.desk, settings);
                let root = &self.settings.root;
                let opened = Lossless::open(root, &self.run_id, self.extent, settings, asked);
                self.lossless = self.told(&["lossless"], opened);
                self.await_readers(run);
            }
        }
        let kept = [
            ("frames", wanted.frames),
            ("objects", wanted.frames && self.extent.objects > 0),
            ("coverage", wanted.coverage),
            ("metrics", wanted.metrics),
            ("events", wanted.metrics),
            ("status", wanted.status),
            ("lossless", wanted.lossless.is_some()),
        ];
        for (name, _) in kept.into_iter().filter(|(_, is_wanted)| !is_wanted) {
            self.desk.say(name, None);
        }
    }

    fn on_node<T>(
        &mut self,
        open: impl FnOnce(&Self, &Node<ipc::Service>) -> Result<T, ChannelError>,
    ) -> Result<T, ChannelError> {
        let node = match self.node.take() {
            Some(node) => node,
            None => open_node(&self.settings.root)?,
        };
        let opened = open(self, &node);
        self.node = Some(node);
        opened
    }

    /// Tells what became of channels that were opened together.
    fn told<T>(&mut self, names: &[&'static str], opened: Result<T, ChannelError>) -> Option<T> {
        let fate = match &opened {
            Ok(_) => Fate::Open,
            Err(error) => {
                let channel = names[0];
                tracing::warn!(
                    run = self.run_id, %error,
                    "the run goes on without its channel {channel}"
                );
                self.again = Some(Instant::now() + AGAIN);
                Fate::Closed(error.to_string())
            }
        };
        for name in names {
            self.desk.say(name, Some(fate.clone()));
        }
        opened.ok()
    }

    fn await_readers(&mut self, run: &Run) {
        let Some(lossless) = &mut self.lossless else {
            return;
        };
        if !lossless.await_readers(run, self.attendant) {
            let settings = lossless.settings();
            self.close_lossless(&format!(
                "{} readers did not come within {} ms",
                settings.readers, settings.timeout_ms
            ));
        }
    }

    fn close_lossless(&mut self, why: &str) {
        self.lossless = None;
        tracing::warn!(
            run = self.run_id,
            why,
            "the lossless channel is closed; the run goes on"
        );
        self.desk
            .say("lossless", Some(Fate::Closed(why.to_owned())));
    }

    fn offer_lossless(&mut self, run: &Run) {
        let Some(lossless) = &mut self.lossless else {
            return;
        };
        let timeout_ms = lossless.settings().timeout_ms;
        match lossless.offer(run, self.attendant) {
            Ok(()) => {}
            // It will be closed.
            Err(_) if !lossless.is_wanted() => {}
            Err(SendFailure::Send(_)) => self.close_lossless(&format!(
                "a reader took no frame for {timeout_ms} ms (step {})",
                run.step()
            )),
            Err(error) => self.close_lossless(&error.to_string()),
        }
    }

    fn offer_reports(&mut self, run: &Run) {
        if self.looked.is_some_and(|looked| looked.elapsed() < LOOK) {
            return;
        }
        self.looked = Some(Instant::now());
        if let Some(status) = &mut self.status {
            status.offer(run);
        }
        let metrics = self.metrics.as_mut().map_or(Ok(()), |it| it.offer(run));
        let coverage = self.coverage.as_mut().map_or(Ok(()), |it| it.offer(run));
        for sent in [metrics, coverage] {
            self.complain(sent);
        }
    }

    fn complain(&mut self, sent: Result<(), SendFailure>) {
        if let Err(error) = sent
            && !std::mem::replace(&mut self.complained, true)
        {
            let run = &self.run_id;
            tracing::warn!(run, %error, "a sample was lost; further losses are not reported");
        }
    }
}

impl Observer for RunChannels<'_> {
    fn begin(&mut self, run: &Run) -> Result<(), Stop> {
        self.after_block(run, &run.progress())
    }

    fn next_step_wanted(&self, step: u64) -> Option<u64> {
        self.lossless.as_ref()?.next_step_wanted(step)
    }

    fn after_block(&mut self, run: &Run, _: &Progress) -> Result<(), Stop> {
        self.reconcile(run);
        if let Some(frames) = &mut self.frames {
            frames.offer(run);
        }
        self.offer_lossless(run);
        self.offer_reports(run);
        Ok(())
    }

    fn end(&mut self, run: &Run, ended: &Ended) {
        if let Some(frames) = &mut self.frames {
            frames.offer_now(run);
        }
        let state = match ended {
            Ended::Stopped => 1,
            Ended::Done => 2,
            Ended::Waiting(_) => 3,
            Ended::Failed(_) => 4,
        };
        if let Some(status) = &mut self.status {
            status.put(run, state);
        }
        let metrics = self
            .metrics
            .as_mut()
            .map_or(Ok(()), |it| it.end(run, state));
        let coverage = self.coverage.as_mut().map_or(Ok(()), |it| it.send(run));
        for sent in [metrics, coverage] {
            self.complain(sent);
        }
    }
}

impl Drop for RunChannels<'_> {
    fn drop(&mut self) {
        self.desk.close_all();
    }
}
