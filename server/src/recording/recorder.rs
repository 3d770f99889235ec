//! Records a run while it is stepped: copies what is asked for into a block, hands full blocks over.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, channel};

use recording::{Chosen, Fields, Header, Layout, Raw};
use swarm::run::{Progress, Run, Witness};
use swarm::world::Body;

use super::open::{OpenError, empty_block, next_sample, open};
use super::paths::Paths;
use super::sink::{Job, Shared, Sink};
use crate::runner::{Observer, Stop};

/// Blocks that are filled, compressed or waiting.
const BLOCKS: usize = 3;

/// Takes samples of a run.
pub struct Recorder {
    header: Header,
    layout: Layout,
    raw: Raw,
    sink: Sink,
    /// Blocks that may still be made.
    unmade: usize,
    /// Next sample; what was seen before is not taken again.
    next: u64,
}

/// The block that is begun, on its way to a file.
pub struct Tail {
    raw: Box<Raw>,
    jobs: SyncSender<Job>,
}

impl Tail {
    /// Keeps it durably, after all blocks before it. Returns whether that worked; if not, a
    /// checkpoint of this moment is worth nothing.
    pub fn keep(self) -> bool {
        let (told, done) = channel();
        self.jobs.send(Job::Tail(self.raw, told)).is_ok() && done.recv().unwrap_or(false)
    }
}

impl Recorder {
    /// Begins the recording of a run, or goes on with it from where the run stands.
    ///
    /// # Errors
    /// `Short` when the run stands further on than what there is of the recording.
    pub fn open(
        header: Header,
        paths: &Paths,
        run: &Run,
        most_bytes: u64,
    ) -> Result<Self, OpenError> {
        let opened = open(&header, paths, run.place())?;
        let layout = Layout::of(&header);
        Ok(Self {
            next: opened.begun.first + opened.begun.count as u64,
            raw: opened.begun,
            sink: Sink::start(opened.writer, opened.file, paths.clone(), most_bytes)?,
            unmade: BLOCKS - 1,
            layout,
            header,
        })
    }

    /// What both the recording's thread and its owner see.
    pub fn shared(&self) -> Arc<Shared> {
        Arc::clone(&self.sink.shared)
    }

    /// Bytes written so far.
    pub fn bytes(&self) -> u64 {
        self.sink.shared.bytes()
    }

    /// Whether all samples are taken.
    pub fn is_complete(&self) -> bool {
        self.next >= self.layout.samples().end
    }

    /// The block that is begun, for whoever takes a checkpoint of this moment; `None` where nothing
    /// is recorded any more.
    pub fn tail(&self) -> Option<Tail> {
        let jobs = self.sink.jobs.clone()?;
        if self.sink.shared.failure().is_some() {
            return None;
        }
        Some(Tail {
            raw: Box::new(self.raw.clone()),
            jobs,
        })
    }

    /// Ends the recording of a run that is done.
    ///
    /// # Errors
    /// Why it is not whole.
    pub fn finish(mut self) -> Result<(), String> {
        if !self.is_complete() {
            return Err(format!("it ends at sample {}", self.next));
        }
        if self.sink.end() {
            return Ok(());
        }
        let failure = self.sink.shared.failure();
        Err(failure.unwrap_or_else(|| "it could not be ended".to_owned()))
    }

    fn take(&mut self, run: &Run) {
        let sample = next_sample(&self.layout, run.place());
        let sample = match run.place().step {
            0 => sample,
            _ => sample - 1,
        };
        if sample != self.next || !self.layout.samples().contains(&sample) {
            return;
        }
        self.push(run);
        self.next += 1;
        if self.layout.block_end(sample) == self.next {
            self.hand_over();
        }
    }

    fn push(&mut self, run: &Run) {
        let Self { header, raw, .. } = self;
        let bodies = run.robots();
        let is_first = raw.count == 0;
        match &header.robots {
            Chosen::First(count) => {
                let chosen = bodies.iter().take(*count as usize);
                chosen.for_each(|body| push_body(raw, header.fields, body, is_first));
            }
            Chosen::List(list) => {
                for &number in list {
                    push_body(raw, header.fields, &bodies[number as usize], is_first);
                }
            }
        }
        if header.fields.decision {
            push_decisions(raw, &header.robots, run);
        }
        let objects = header.objects as usize;
        let here = run.objects_here().poses.iter();
        let poses = here.map(|pose| [pose.x_m, pose.y_m, pose.cos, pose.sin]);
        let none = std::iter::repeat([0.0, 0.0, 1.0, 0.0]);
        raw.object_poses.extend(poses.chain(none).take(objects));
        raw.count += 1;
    }

    /// Gives the full block away and takes an empty one: waits for one where all are full.
    fn hand_over(&mut self) {
        let empty = if self.unmade > 0 {
            self.unmade -= 1;
            Some(empty_block(&self.header, &self.layout, self.next))
        } else {
            self.sink.spare.recv().ok()
        };
        let (Some(mut empty), Some(jobs)) = (empty, &self.sink.jobs) else {
            // The thread is gone and has said why.
            self.raw.begin(self.next);
            return;
        };
        empty.begin(self.next);
        let full = std::mem::replace(&mut self.raw, empty);
        // A thread that is gone has said why.
        drop(jobs.send(Job::Block(full)));
    }
}

#[inline]
fn push_body(raw: &mut Raw, fields: Fields, body: &Body, is_first: bool) {
    if fields.pose {
        raw.poses.push([body.x_m, body.y_m, body.cos, body.sin]);
        if is_first {
            raw.wheels_rad_s.push(body.wheels_rad_s);
        }
    }
    if fields.command {
        raw.commands.push(body.command);
    }
    if fields.sensors {
        raw.sensors.push(body.reading.proximity);
    }
}

fn push_decisions(raw: &mut Raw, chosen: &Chosen, run: &Run) {
    // One more than the number; what does not fit is none.
    let kept = |number: u32| u16::try_from(number + 1).unwrap_or(0);
    let whole = (raw.count + 1) * raw.rows;
    let mut number = 0;
    let mut listed = match chosen {
        Chosen::First(_) => &[][..],
        Chosen::List(list) => list,
    };
    run.each_decision(&mut |decision| {
        let wanted = match chosen {
            Chosen::First(count) => number < *count,
            Chosen::List(_) => listed.first() == Some(&number),
        };
        if wanted {
            listed = listed.get(1..).unwrap_or_default();
            raw.decisions
                .push([kept(decision.state), kept(decision.action)]);
        }
        number += 1;
    });
    raw.decisions.resize(whole, [0; 2]);
}

/// A recorder that both the stepping loop and whoever takes checkpoints have.
#[derive(Clone)]
pub struct SharedRecorder(Rc<RefCell<Option<Recorder>>>, u32);

impl SharedRecorder {
    /// Of a recorder, or of none.
    pub fn new(recorder: Option<Recorder>) -> Self {
        let every_steps = recorder.as_ref().map_or(0, |r| r.header.every_steps);
        Self(Rc::new(RefCell::new(recorder)), every_steps)
    }

    /// As [`Recorder::tail`].
    pub fn tail(&self) -> Option<Tail> {
        self.0.borrow().as_ref()?.tail()
    }

    /// The recorder, which then records no more.
    pub fn take(&self) -> Option<Recorder> {
        self.0.borrow_mut().take()
    }
}

impl Witness for SharedRecorder {
    fn every_steps(&self) -> u32 {
        self.1
    }

    fn see(&mut self, run: &Run) {
        if let Some(recorder) = &mut *self.0.borrow_mut() {
            recorder.take(run);
        }
    }
}

impl Observer for SharedRecorder {
    fn after_block(&mut self, _: &Run, _: &Progress) -> Result<(), Stop> {
        Ok(())
    }

    fn witness(&mut self) -> Option<&mut dyn Witness> {
        (self.1 > 0).then_some(self)
    }
}
