//! A slice of a recording, as the page and other clients read it: bounded in what it holds and in
//! what it takes to find.

use std::io::{Read, Seek};

use api::recording::{
    MOST_MOMENTS, MOST_SLICE_POSES, RecordedEpoch, RecordedPhase, RecordedPoses, RecordedRobot,
    RecordingHead, RecordingSlice, RecordingState,
};
use recording::{Chosen, Header, Layout, Reader, RecordingError, SamplePlace, Samples};

use super::paths::Stage;
use crate::documents::names_of;

/// Most blocks that are read for a slice.
const MOST_BLOCKS: usize = 64;
/// Robots of a slice that names none.
const ROBOTS: usize = 100;

/// What of a recording is wanted.
#[derive(Clone, Debug, Default)]
pub struct SliceQuery {
    /// From this step on, counted over all phases; from the beginning where there is none.
    pub from_step: Option<u64>,
    /// Before this many steps more.
    pub steps: Option<u64>,
    /// Only every so many steps.
    pub every: Option<u64>,
    /// Only these robots.
    pub robots: Option<Vec<u32>>,
}

/// Why there is no slice.
#[derive(Debug, thiserror::Error)]
pub enum SliceError {
    /// A robot is asked for that is not recorded.
    #[error("robot {0} is not recorded")]
    NotRecorded(u32),
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// What a recording is of.
pub fn head<F: Read + Seek>(reader: &Reader<F>, stage: Stage) -> RecordingHead {
    let header = reader.header();
    let mut from_epoch = 0;
    let phases = header.stages.iter().map(|stage| {
        let epochs = u64::from(stage.epochs) * if stage.shows { 2 } else { 1 };
        let phase = RecordedPhase {
            phase: stage.phase.clone(),
            from_epoch,
            epochs,
            in_training: stage.in_training,
            shows: stage.shows,
        };
        from_epoch += epochs;
        phase
    });
    let (layout, samples) = (reader.layout(), reader.samples());
    RecordingHead {
        state: match stage {
            Stage::Whole => RecordingState::Done,
            Stage::Part => RecordingState::Recording,
            Stage::Cut => RecordingState::Cut,
        },
        subject: header.subject.clone(),
        from_epoch: header.from_epoch,
        epochs: header.epochs,
        steps_per_epoch: header.steps_per_epoch,
        every_steps: header.every_steps,
        to_step: match samples.end.checked_sub(1) {
            Some(last) if last >= samples.start => step_of(header, layout.place(last)) + 1,
            _ => header.from_epoch * u64::from(header.steps_per_epoch),
        },
        step_s: header.step_s,
        resets: header.resets,
        body_radius_m: header.body_radius_m,
        robots_total: header.robots_total,
        robots: header.robots.len() as u32,
        robot_numbers: match &header.robots {
            Chosen::First(_) => None,
            Chosen::List(list) => Some(list.clone()),
        },
        objects: header.objects,
        fields: names_of(header.fields)
            .into_iter()
            .map(str::to_owned)
            .collect(),
        phases: phases.collect(),
    }
}

/// Steps of the arena that were done, over all phases.
pub fn step_of(header: &Header, place: SamplePlace) -> u64 {
    place.arena_epoch * u64::from(header.steps_per_epoch) + u64::from(place.step)
}

/// What the epoch of this number is.
pub fn epoch_of(header: &Header, epoch: u64) -> RecordedEpoch {
    let mut within = epoch;
    for stage in &header.stages {
        let each = if stage.shows { 2 } else { 1 };
        let epochs = u64::from(stage.epochs) * each;
        if within < epochs {
            return RecordedEpoch {
                epoch,
                phase: stage.phase.clone(),
                phase_epoch: within / each,
                in_training: stage.in_training && within.is_multiple_of(each),
            };
        }
        within -= epochs;
    }
    RecordedEpoch {
        epoch,
        phase: String::new(),
        phase_epoch: within,
        in_training: false,
    }
}

/// Every so many samples of each epoch, from its beginning on, or the beginnings of every so many
/// epochs.
pub struct Moments {
    samples_per_epoch: u64,
    /// Samples from one to the next.
    stride: u64,
    /// Epochs from one to the next.
    epochs: u64,
    epoch: u64,
    within: u64,
}

impl Moments {
    /// From a step on, every so many steps.
    pub fn new(header: &Header, layout: &Layout, from_step: u64, every: u64) -> Self {
        let steps = u64::from(header.steps_per_epoch);
        let recorded = u64::from(layout.every_steps());
        let samples_per_epoch = steps / recorded + 1;
        let (stride, epochs) = match every <= steps {
            true => (every.div_ceil(recorded), 1),
            false => (samples_per_epoch, every.div_ceil(steps)),
        };
        let (mut epoch, within_steps) = (from_step / steps, from_step % steps);
        let mut within = within_steps.div_ceil(recorded).next_multiple_of(stride);
        if within >= samples_per_epoch {
            (epoch, within) = (epoch + 1, 0);
        }
        Self {
            samples_per_epoch,
            stride,
            epochs,
            epoch: epoch.div_ceil(epochs).saturating_mul(epochs),
            within,
        }
    }
}

impl Iterator for Moments {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        let first = self.epoch.checked_mul(self.samples_per_epoch)?;
        let sample = first.checked_add(self.within)?;
        self.within += self.stride;
        if self.within >= self.samples_per_epoch {
            self.within = 0;
            self.epoch = self.epoch.checked_add(self.epochs)?;
        }
        Some(sample)
    }
}

/// The slice that is wanted, or its beginning.
///
/// # Errors
/// When a robot is not recorded, or the recording is damaged.
pub fn slice<F: Read + Seek>(
    reader: &mut Reader<F>,
    stage: Stage,
    query: &SliceQuery,
) -> Result<RecordingSlice, SliceError> {
    let header = reader.header().clone();
    let layout = *reader.layout();
    let rows = rows(&header, query.robots.as_deref())?;
    let start = header.from_epoch * u64::from(header.steps_per_epoch);
    let from = query.from_step.unwrap_or(start).max(start);
    let end = query
        .steps
        .map_or(u64::MAX, |steps| from.saturating_add(steps));
    let every = query.every.unwrap_or(1).max(1);
    let mut slice = empty(reader, stage, &rows);
    let poses = (rows.len() + slice.objects.len()).max(1);
    let most = (MOST_SLICE_POSES as usize / poses).clamp(1, MOST_MOMENTS as usize);
    let (mut block, mut blocks) = (Samples::default(), 0);
    let moments = Moments::new(&header, &layout, from, every);
    let there = reader.samples();
    // The very end stands at the step at which another epoch would begin.
    let last = there.end.checked_sub(1).filter(|_| !there.is_empty());
    let end_alone = last.filter(|last| {
        let place = layout.place(*last);
        place.step == header.steps_per_epoch && step_of(&header, place) == from
    });
    for sample in end_alone.into_iter().chain(moments) {
        let place = layout.place(sample);
        let step = step_of(&header, place);
        if step >= end || sample >= there.end {
            break;
        }
        let is_in =
            block.count > 0 && (block.first..block.first + block.count as u64).contains(&sample);
        let is_full = slice.step.len() >= most || !is_in && blocks >= MOST_BLOCKS;
        // The end of an epoch is at the same step as the beginning of the next, from which the next
        // slice would go on.
        if is_full && place.step < header.steps_per_epoch {
            slice.next_step = Some(step);
            break;
        }
        if !is_in {
            block = reader.block(sample)?;
            blocks += 1;
        }
        push(&mut slice, &header, &rows, &block, (sample, step, place));
    }
    Ok(slice)
}

fn rows(header: &Header, wanted: Option<&[u32]>) -> Result<Vec<usize>, SliceError> {
    match wanted {
        None => Ok((0..header.robots.len().min(ROBOTS)).collect()),
        Some(numbers) => numbers
            .iter()
            .map(|&number| {
                let row = header.robots.row(number);
                row.ok_or(SliceError::NotRecorded(number))
            })
            .collect(),
    }
}

fn empty<F: Read + Seek>(reader: &Reader<F>, stage: Stage, rows: &[usize]) -> RecordingSlice {
    let header = reader.header();
    let robot = |row: &usize| RecordedRobot {
        robot: header.robots.number(*row),
        ..RecordedRobot::default()
    };
    RecordingSlice {
        recording: head(reader, stage),
        epochs: Vec::new(),
        step: Vec::new(),
        epoch: Vec::new(),
        epoch_step: Vec::new(),
        robots: rows.iter().map(robot).collect(),
        objects: vec![RecordedPoses::default(); header.objects as usize],
        next_step: None,
    }
}

fn push(
    slice: &mut RecordingSlice,
    header: &Header,
    rows: &[usize],
    block: &Samples,
    (sample, step, place): (u64, u64, SamplePlace),
) {
    let at = (sample - block.first) as usize;
    if slice.epoch.last() != Some(&place.arena_epoch) {
        slice.epochs.push(epoch_of(header, place.arena_epoch));
    }
    slice.step.push(step);
    slice.epoch.push(place.arena_epoch);
    slice.epoch_step.push(place.step);
    for (robot, &row) in slice.robots.iter_mut().zip(rows) {
        if header.fields.pose {
            push_pose(&mut robot.poses, block.pose(row, at));
        }
        if header.fields.command {
            let [left, right] = block.command(row, at);
            robot.left.push(left);
            robot.right.push(right);
        }
        if header.fields.decision {
            let decision = block.decision(row, at);
            robot.state.push(decision.state);
            robot.action.push(decision.action);
        }
        if header.fields.sensors {
            robot.sensors.push(block.sensors(row, at));
        }
    }
    for (object, poses) in slice.objects.iter_mut().enumerate() {
        push_pose(poses, block.object_pose(object, at));
    }
}

fn push_pose(poses: &mut RecordedPoses, [x_m, y_m, heading_rad]: [f64; 3]) {
    poses.x_m.push(x_m);
    poses.y_m.push(y_m);
    poses.heading_rad.push(heading_rad);
}
