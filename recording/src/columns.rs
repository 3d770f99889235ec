//! Columns of samples to planes of bytes and back: poses as what dead reckoning got wrong, commands
//! by a list of those that occur, readings as differences.

use std::collections::HashMap;

use crate::error::RecordingError;
use crate::header::Header;
use crate::layout::Layout;
use crate::planes::{Numbers, put_signed};
use crate::predict::{Directions, Found, Guess, Reckoning};
use crate::samples::Samples;
use crate::units::SENSORS;

/// Most different commands that are listed: what occurs is then two bytes at most.
const MOST_LISTED: usize = 4_096;

/// How the next pose is expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expect {
    /// Where the robot was.
    Same,
    /// Where its commands take it.
    Reckoned,
}

/// Calls for each pose of a row with what is expected, gets what was found, in both directions.
pub fn follow(
    header: &Header,
    layout: &Layout,
    directions: &Directions,
    expect: Expect,
    row: Row<'_>,
    mut actual: impl FnMut(usize, Guess) -> Result<Found, RecordingError>,
) -> Result<(), RecordingError> {
    let mut reckoning = Reckoning::new(&header.drive, directions);
    let (mut start, mut before) = ([0; 3], [0; 3]);
    for sample in 0..row.count {
        let begins = layout.begins_epoch(row.first + sample as u64);
        let put_back = begins && header.resets;
        let expected = match expect {
            _ if put_back => Guess::Still(start),
            _ if begins || sample == 0 => Guess::Still(before),
            Expect::Same => Guess::Still(before),
            Expect::Reckoned => reckoning.step([row.left[sample], row.right[sample]]),
        };
        let found = actual(sample, expected)?;
        let is = found.is;
        if expect == Expect::Reckoned {
            if sample == 0 {
                reckoning.put(is, row.wheels.map(|ticks| f64::from(ticks) / 1_000.0));
            } else if put_back {
                reckoning.put(is, [0.0; 2]);
            } else {
                reckoning.correct(found);
            }
        }
        if put_back {
            start = is;
        }
        before = is;
    }
    Ok(())
}

/// A robot's or an object's part of a block.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    pub first: u64,
    pub count: usize,
    pub wheels: [i32; 2],
    pub left: &'a [i16],
    pub right: &'a [i16],
}

/// Bits that a number takes, about.
fn bits(value: i32) -> u64 {
    u64::from(33 - value.unsigned_abs().leading_zeros()) * u64::from(value != 0)
}

/// Poses as planes of what was not as expected.
pub fn pose_planes(
    header: &Header,
    layout: &Layout,
    directions: &Directions,
    expect: Expect,
    samples: &Samples,
) -> Result<([Vec<u8>; 3], u64), RecordingError> {
    let mut planes = [(); 3].map(|()| Vec::with_capacity(samples.pose[0].len() * 5 / 4));
    let mut cost = 0;
    for row in 0..samples.rows {
        let from = row * samples.count;
        let is = |sample: usize| [0, 1, 2].map(|axis: usize| samples.pose[axis][from + sample]);
        let of_row = robot_row(samples, row);
        follow(
            header,
            layout,
            directions,
            expect,
            of_row,
            |sample, expected| {
                let (off, found) = expected.off(is(sample));
                for (plane, off) in planes.iter_mut().zip(off) {
                    put_signed(plane, off);
                    cost += bits(off);
                }
                Ok(found)
            },
        )?;
    }
    Ok((planes, cost))
}

/// The part of a block that belongs to a robot; its commands must be known.
pub fn robot_row(samples: &Samples, row: usize) -> Row<'_> {
    let all = row * samples.count..(row + 1) * samples.count;
    let commands = |wheel: usize| samples.command[wheel].get(all.clone()).unwrap_or_default();
    Row {
        first: samples.first,
        count: samples.count,
        wheels: samples.wheels.get(row).copied().unwrap_or_default(),
        left: commands(0),
        right: commands(1),
    }
}

/// Poses of robots from their planes, into samples whose commands are known.
pub fn read_poses(
    header: &Header,
    layout: &Layout,
    directions: &Directions,
    expect: Expect,
    planes: &[Vec<u8>; 3],
    samples: &mut Samples,
) -> Result<(), RecordingError> {
    let mut numbers = [0, 1, 2].map(|axis: usize| Numbers(&planes[axis]));
    let mut poses = [(); 3].map(|()| Vec::with_capacity(samples.rows * samples.count));
    for row in 0..samples.rows {
        let of_row = robot_row(samples, row);
        follow(header, layout, directions, expect, of_row, |_, expected| {
            read_pose(&mut numbers, &mut poses, expected)
        })?;
    }
    samples.pose = poses;
    Ok(())
}

fn read_pose(
    numbers: &mut [Numbers<'_>; 3],
    poses: &mut [Vec<i32>; 3],
    expected: Guess,
) -> Result<Found, RecordingError> {
    let mut off = [0; 3];
    for (off, numbers) in off.iter_mut().zip(numbers) {
        *off = numbers.next_signed()?;
    }
    let found = expected.corrected(off);
    for (column, value) in poses.iter_mut().zip(found.is) {
        column.push(value);
    }
    Ok(found)
}

/// Poses of objects, which stay where they are unless they are pushed.
pub fn object_planes(
    header: &Header,
    layout: &Layout,
    directions: &Directions,
    samples: &Samples,
) -> Result<[Vec<u8>; 3], RecordingError> {
    let mut planes = [(); 3].map(|()| Vec::new());
    for object in 0..samples.objects {
        let from = object * samples.count;
        follow(
            header,
            layout,
            directions,
            Expect::Same,
            object_row(samples),
            |sample, expected| {
                let is = [0, 1, 2].map(|axis: usize| samples.object_pose[axis][from + sample]);
                let (off, found) = expected.off(is);
                for (plane, off) in planes.iter_mut().zip(off) {
                    put_signed(plane, off);
                }
                Ok(found)
            },
        )?;
    }
    Ok(planes)
}

fn object_row(samples: &Samples) -> Row<'_> {
    Row {
        first: samples.first,
        count: samples.count,
        wheels: [0; 2],
        left: &[],
        right: &[],
    }
}

/// Poses of objects from their planes.
pub fn read_objects(
    header: &Header,
    layout: &Layout,
    directions: &Directions,
    planes: &[Vec<u8>; 3],
    samples: &mut Samples,
) -> Result<(), RecordingError> {
    let mut numbers = [0, 1, 2].map(|axis: usize| Numbers(&planes[axis]));
    let mut poses = [(); 3].map(|()| Vec::with_capacity(samples.objects * samples.count));
    for _ in 0..samples.objects {
        let row = object_row(samples);
        follow(
            header,
            layout,
            directions,
            Expect::Same,
            row,
            |_, expected| read_pose(&mut numbers, &mut poses, expected),
        )?;
    }
    samples.object_pose = poses;
    Ok(())
}

/// Commands: those that occur, and which of them at each sample, or else the commands themselves.
pub fn command_planes([left, right]: &[Vec<i16>; 2]) -> [Vec<u8>; 3] {
    let mut listed: Vec<[i16; 2]> = Vec::new();
    let mut places: HashMap<[i16; 2], u16> = HashMap::new();
    let mut which = Vec::with_capacity(left.len());
    // Robots hold commands: the last one is the likeliest.
    let mut last = None;
    for (&left, &right) in left.iter().zip(right) {
        let command = [left, right];
        let place = match last {
            Some((same, place)) if same == command => place,
            _ => *places.entry(command).or_insert_with(|| {
                listed.push(command);
                (listed.len() - 1) as u16
            }),
        };
        if listed.len() > MOST_LISTED {
            break;
        }
        last = Some((command, place));
        which.push(place);
    }
    if listed.len() > MOST_LISTED.min(left.len() / 2) {
        let ticks = left.iter().zip(right);
        let ticks = ticks.flat_map(|(&left, &right)| [left, right]);
        let [low, high] = halves(ticks.map(|ticks| ticks as u16));
        return [Vec::new(), low, high];
    }
    let list = listed.iter().flatten().flat_map(|t| t.to_le_bytes());
    let [low, high] = halves(which.into_iter());
    [list.collect(), low, high]
}

/// The bytes of 16-bit numbers, low ones and high ones apart.
pub fn halves(numbers: impl Iterator<Item = u16>) -> [Vec<u8>; 2] {
    let (mut low, mut high) = (Vec::new(), Vec::new());
    low.reserve(numbers.size_hint().0);
    high.reserve(numbers.size_hint().0);
    for number in numbers {
        low.push(number as u8);
        high.push((number >> 8) as u8);
    }
    [low, high]
}

/// Numbers from their bytes.
pub fn whole([low, high]: [&[u8]; 2], count: usize) -> Result<Vec<u16>, RecordingError> {
    if low.len() != count || high.len() != count {
        return Err(RecordingError::Damaged("a column is short"));
    }
    let both = low.iter().zip(high);
    Ok(both
        .map(|(&low, &high)| u16::from_le_bytes([low, high]))
        .collect())
}

/// Commands from their planes.
pub fn read_commands(
    [list, low, high]: &[Vec<u8>; 3],
    count: usize,
) -> Result<[Vec<i16>; 2], RecordingError> {
    if list.is_empty() {
        let ticks = whole([low, high], 2 * count)?;
        let of = |wheel: usize| ticks[wheel.min(ticks.len())..].iter().step_by(2);
        return Ok([0, 1].map(|wheel| of(wheel).map(|&ticks| ticks as i16).collect()));
    }
    let command = |place: u16| {
        let at = usize::from(place) * 4;
        let bytes = list.get(at..at + 4)?;
        Some([
            i16::from_le_bytes([bytes[0], bytes[1]]),
            i16::from_le_bytes([bytes[2], bytes[3]]),
        ])
    };
    let (mut left, mut right) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for place in whole([low, high], count)? {
        let [l, r] = command(place).ok_or(RecordingError::Damaged("an unlisted command"))?;
        left.push(l);
        right.push(r);
    }
    Ok([left, right])
}

/// Readings as differences from one sample to the next.
pub fn sensor_plane(sensors: &[u16], count: usize) -> Vec<u8> {
    let mut plane = Vec::with_capacity(sensors.len() * 5 / 4);
    for one in sensors.chunks(count.max(1)) {
        let mut before = 0;
        for &value in one {
            put_signed(&mut plane, i32::from(value) - before);
            before = i32::from(value);
        }
    }
    plane
}

/// Readings from their plane.
pub fn read_sensors(plane: &[u8], rows: usize, count: usize) -> Result<Vec<u16>, RecordingError> {
    let mut numbers = Numbers(plane);
    let mut sensors = Vec::with_capacity(rows * SENSORS * count);
    for _ in 0..rows * SENSORS {
        let mut value = 0_i32;
        for _ in 0..count {
            value = value.wrapping_add(numbers.next_signed()?);
            sensors.push(value as u16);
        }
    }
    Ok(sensors)
}
