//! What is recorded is read back, whole, cut, damaged, in parts and after a break.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::Cursor;

use proptest::prelude::*;

use super::*;

fn header(robots: u32, steps_per_epoch: u32, every_steps: u32, epochs: u64) -> Header {
    Header {
        subject: "ab".repeat(32),
        results_version: 1,
        spec: serde_json::json!({ "seed": 1 }),
        arena: serde_json::json!({ "name": "a" }),
        training_arena: None,
        body_radius_m: 0.037,
        step_s: 0.064,
        steps_per_epoch,
        resets: true,
        stages: vec![StageMark {
            phase: "exploration".to_owned(),
            epochs: 1_000,
            in_training: false,
            shows: false,
        }],
        from_epoch: 0,
        epochs,
        every_steps,
        robots_total: robots,
        robots: Chosen::First(robots),
        objects: 2,
        fields: Fields::ALL,
        drive: DriveModel {
            top_speed_rad_s: 6.25,
            acceleration_rad_s_step: Some(0.64),
            advance_m_s: 0.02 * 0.064 / 2.0,
            turn_s: 0.02 * 0.064 / 0.052,
        },
    }
}

/// A number that looks random, from 0 to 1.
fn noise(keys: [u64; 4]) -> f64 {
    let mut word = 0x9E37_79B9_7F4A_7C15_u64;
    for key in keys {
        word = (word ^ key).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        word ^= word >> 29;
    }
    (word >> 11) as f64 / (1_u64 << 53) as f64
}

/// Robots that drive by few commands and now and then bump into something; as raw samples.
struct World {
    header: Header,
    layout: Layout,
    /// x, y, heading and wheel speeds.
    robots: Vec<[f64; 5]>,
}

impl World {
    fn new(header: &Header) -> Self {
        Self {
            header: header.clone(),
            layout: Layout::of(header),
            robots: Vec::new(),
        }
    }

    fn start(&mut self) {
        let start = |robot| [0.1 + 0.1 * f64::from(robot), 0.5, 0.3, 0.0, 0.0];
        self.robots = (0..self.header.robots_total).map(start).collect();
    }

    fn command(&self, sample: u64, robot: usize) -> [f32; 2] {
        if self.layout.begins_epoch(sample) {
            return [0.0; 2];
        }
        let which = |wheel| noise([sample / 3, robot as u64, 7, wheel]);
        [0, 1].map(|wheel| (((which(wheel) * 5.0).floor() - 2.0) / 2.0) as f32)
    }

    fn push(&mut self, raw: &mut Raw, sample: u64) {
        if self.layout.begins_epoch(sample) {
            self.start();
        }
        for robot in 0..self.robots.len() {
            let command = self.command(sample, robot);
            let drive = self.header.drive;
            let [x, y, h, left, right] = &mut self.robots[robot];
            for (speed, command) in [&mut *left, &mut *right].into_iter().zip(command) {
                let change = f64::from(command) * drive.top_speed_rad_s - *speed;
                *speed += change.clamp(-0.64, 0.64);
            }
            let turn = (*right - *left) * drive.turn_s;
            let way = (*left + *right) * drive.advance_m_s;
            if noise([sample, robot as u64, 9, 9]) > 0.01 {
                *x += way * (*h + turn / 2.0).cos();
                *y += way * (*h + turn / 2.0).sin();
            }
            *h += turn;
            raw.poses
                .push([*x as f32, *y as f32, h.cos() as f32, h.sin() as f32]);
            if raw.count == 0 {
                raw.wheels_rad_s.push([*left as f32, *right as f32]);
            }
            raw.commands.push(command);
            let state = (noise([sample, robot as u64, 1, 1]) * 30.0) as u16;
            raw.decisions.push([state, state / 2]);
            raw.sensors.push(std::array::from_fn(|sensor| {
                (noise([sample, robot as u64, 2, sensor as u64]) * 4_095.0) as f32
            }));
        }
        for object in 0..self.header.objects {
            let at = 0.5 + 0.001 * (sample / 50) as f32 + object as f32;
            raw.object_poses.push([at, at, 1.0, 0.0]);
        }
        raw.count += 1;
    }

    /// The recording, and what it was made from.
    fn record(&mut self) -> (Vec<u8>, Vec<Raw>) {
        let (mut writer, mut file) = Writer::new(&self.header).unwrap();
        let samples = self.layout.samples();
        // The simulation does not begin where the recording does.
        let mut sample = 0;
        let mut before = Raw::default();
        while sample < samples.start {
            self.push(&mut before, sample);
            sample += 1;
        }
        let mut all = Vec::new();
        while sample < samples.end {
            let (rows, objects) = (self.header.robots.len(), self.header.objects as usize);
            let mut raw = Raw::with_room(Fields::ALL, 1, rows, objects);
            raw.begin(sample);
            let end = self.layout.block_end(sample);
            while sample < end {
                self.push(&mut raw, sample);
                sample += 1;
            }
            let block = writer.encode(&raw).unwrap();
            writer.add(&block);
            file.extend(block);
            all.push(raw);
        }
        file.extend(writer.end());
        (file, all)
    }
}

fn open(file: &[u8]) -> Result<Reader<Cursor<&[u8]>>, RecordingError> {
    Reader::open(Cursor::new(file))
}

/// All samples of a recording, block by block.
fn read(file: &[u8]) -> Vec<Samples> {
    let mut reader = open(file).unwrap();
    let mut blocks = Vec::new();
    let mut sample = reader.samples().start;
    while sample < reader.samples().end {
        blocks.push(reader.block(sample).unwrap());
        sample = reader.layout().block_end(sample);
    }
    blocks
}

#[test]
fn what_is_recorded_is_read_back_to_a_tick() {
    for (robots, steps, every) in [(1, 50, 1), (3, 100, 10), (300, 400, 1), (70_000, 2, 1)] {
        let header = header(robots, steps, every, 5);
        let (file, raws) = World::new(&header).record();
        let mut reader = open(&file).unwrap();
        assert!(reader.is_complete());
        assert_eq!(*reader.header(), header);
        for raw in raws {
            let block = reader.block(raw.first).unwrap();
            assert_eq!(block.count, raw.count);
            for sample in 0..raw.count {
                for row in (0..raw.rows).step_by(1 + raw.rows / 20) {
                    let at = sample * raw.rows + row;
                    let [x_m, y_m, heading_rad] = block.pose(row, sample);
                    let [x, y, cos, sin] = raw.poses[at].map(f64::from);
                    assert!((x_m - x).abs() <= 0.51e-4 && (y_m - y).abs() <= 0.51e-4);
                    let off = (heading_rad - sin.atan2(cos)).abs();
                    assert!(off <= 0.6e-3, "{off}");
                    assert_eq!(
                        block.command(row, sample),
                        raw.commands[at].map(|c| (f64::from(c) * 1_000.0).round() / 1_000.0)
                    );
                    let values = raw.sensors[at].map(|v| f64::from(v).round() as u16);
                    assert_eq!(block.sensors(row, sample), values);
                    let Decision { state, action } = block.decision(row, sample);
                    let kept = [state, action].map(|n| n.map_or(0, |n| n + 1));
                    assert_eq!(kept, raw.decisions[at]);
                }
                let [x_m, ..] = block.object_pose(1, sample);
                let there = f64::from(raw.object_poses[sample * 2 + 1][0]);
                assert!((x_m - there).abs() <= 0.51e-4);
            }
        }
    }
}

#[test]
fn free_robots_with_few_commands_take_less_than_two_bytes_a_step() {
    let mut header = header(10, 2_000, 1, 10);
    header.objects = 0;
    header.fields.sensors = false;
    header.fields.decision = false;
    let (mut writer, _) = Writer::new(&header).unwrap();
    let (_, raws) = World::new(&header).record();
    let (mut bytes, mut robot_steps) = (0, 0);
    for mut raw in raws {
        raw.sensors.clear();
        raw.decisions.clear();
        raw.objects = 0;
        raw.object_poses.clear();
        bytes += writer.encode(&raw).unwrap().len();
        robot_steps += raw.count * raw.rows;
    }
    let each = bytes as f64 / robot_steps as f64;
    assert!(each < 1.5, "{each} bytes");
}

#[test]
fn a_cut_recording_is_read_up_to_its_last_whole_block() {
    let header = header(40, 1_000, 1, 2);
    let (file, raws) = World::new(&header).record();
    let mut reader = open(&file).unwrap();
    let whole = read(&file);
    assert!(whole.len() > 1 && whole.len() == raws.len());
    let (blocks, end) = reader.blocks();
    let mut ends: Vec<u64> = blocks[1..].to_vec();
    ends.push(end);
    let begin = blocks[0];
    for cut in (0..file.len())
        .step_by(file.len() / 200)
        .chain([file.len() - 1])
    {
        let Ok(mut cut_reader) = open(&file[..cut]) else {
            assert!((cut as u64) < begin, "cut at {cut}");
            continue;
        };
        assert!(!cut_reader.is_complete());
        let there = ends.iter().filter(|end| **end <= cut as u64).count();
        assert_eq!(cut_reader.blocks().0.len(), there, "cut at {cut}");
        let is_there = there == whole.len();
        let lack = if is_there { Lack::Index } else { Lack::Samples };
        assert_eq!(cut_reader.lack(), Some(lack), "cut at {cut}");
        let samples = cut_reader.samples();
        assert!(cut_reader.block(samples.end).is_err());
        if there > 0 {
            assert_eq!(cut_reader.block(samples.start).unwrap(), whole[0]);
        }
    }
    assert_eq!(
        reader.block(reader.samples().end - 1).unwrap(),
        whole[whole.len() - 1]
    );
    assert_eq!(reader.lack(), None);
    for surplus in [1, 8, 1_000] {
        let longer = [&file[..], &vec![0x45; surplus]].concat();
        let mut longer = open(&longer).unwrap();
        assert_eq!(longer.lack(), Some(Lack::Surplus(surplus as u64)));
        assert_eq!(longer.block(longer.samples().start).unwrap(), whole[0]);
    }
}

#[test]
fn a_changed_byte_is_noticed_and_never_a_panic() {
    let header = header(2, 30, 1, 3);
    let (file, _) = World::new(&header).record();
    let whole = read(&file);
    for at in 0..file.len() {
        let mut changed = file.clone();
        changed[at] ^= 0x41;
        let Ok(mut reader) = open(&changed) else {
            continue;
        };
        let mut sample = reader.samples().start;
        while sample < reader.samples().end {
            // What can be read is what was written.
            if let Ok(block) = reader.block(sample) {
                assert!(whole.contains(&block), "byte {at}");
            }
            sample = reader.layout().block_end(sample);
        }
    }
}

#[test]
fn blocks_of_a_part_are_those_of_the_whole() {
    for (robots, steps) in [(2, 5_000), (40, 1_000), (1, 300)] {
        let whole_header = header(robots, steps, 1, 12);
        let mut part_header = whole_header.clone();
        (part_header.from_epoch, part_header.epochs) = (3, 6);
        let (whole, _) = World::new(&whole_header).record();
        let (part, _) = World::new(&part_header).record();
        let (whole, part) = (read(&whole), read(&part));
        let pose = |blocks: &[Samples], sample: u64| {
            let block = blocks
                .iter()
                .find(|b| (b.first..b.first + b.count as u64).contains(&sample));
            let block = block.unwrap();
            let at = (sample - block.first) as usize;
            (
                block.pose(0, at),
                block.command(0, at),
                block.decision(0, at),
            )
        };
        let samples = Layout::of(&part_header).samples();
        for sample in samples.clone().step_by(97) {
            assert_eq!(pose(&whole, sample), pose(&part, sample));
        }
        // But for the first and the last, blocks are the same to the last bit.
        let inner = part.iter().skip(1).take(part.len().saturating_sub(2));
        for block in inner {
            assert!(whole.contains(block));
        }
        let covered: usize = part.iter().map(|block| block.count).sum();
        assert_eq!(covered as u64, samples.end - samples.start);
    }
}

#[test]
fn a_recording_goes_on_after_a_break_with_the_same_bytes() {
    let header = header(5, 700, 1, 9);
    let (_, raws) = World::new(&header).record();
    let (mut writer, _) = Writer::new(&header).unwrap();
    for raw in raws {
        let whole = writer.encode(&raw).unwrap();
        for cut in [1, 7, 15, 16, raw.count / 2, raw.count - 1, raw.count] {
            let mut begun = raw.clone();
            begun.truncate(cut);
            let tail = writer.encode(&begun).unwrap();
            let reader = open(&Writer::new(&header).unwrap().1).map(drop);
            reader.unwrap();
            let (_, bytes) = Writer::new(&header).unwrap();
            let read = open(&bytes).unwrap().decode(&tail).unwrap();
            let mut gone_on = read.to_raw(header.fields, raw.count);
            assert_eq!(gone_on.count, cut);
            let robots = cut * raw.rows;
            gone_on.count = raw.count;
            gone_on.poses.extend(&raw.poses[robots..]);
            gone_on.commands.extend(&raw.commands[robots..]);
            gone_on.decisions.extend(&raw.decisions[robots..]);
            gone_on.sensors.extend(&raw.sensors[robots..]);
            let objects = cut * raw.objects;
            gone_on.object_poses.extend(&raw.object_poses[objects..]);
            let same = writer.encode(&gone_on).unwrap() == whole;
            assert!(same, "broken at {cut}");
        }
    }
}

#[test]
fn a_cut_recording_is_opened_by_its_heads_and_its_last_block() {
    let (whole, _) = World::new(&header(3, 400, 1, 100)).record();
    let reader = open(&whole).unwrap();
    let (offsets, end) = (reader.blocks().0.to_vec(), reader.blocks().1 as usize);
    assert!(offsets.len() >= 4);
    let last = *offsets.last().unwrap() as usize;
    // A crash has left the length of the last block, but not its bytes.
    let mut zeroed = whole[..end].to_vec();
    zeroed[last + 100..].fill(0);
    let mut reader = open(&zeroed).unwrap();
    let there = reader.samples();
    assert_eq!(reader.blocks().0, &offsets[..offsets.len() - 1]);
    assert_eq!(there.end, reader.layout().block_start(there.end));
    reader.block(there.end - 1).unwrap();
    assert!(reader.block(there.end).is_err());
    // One in the middle is damaged: what is behind it can be read, but is not gone on with.
    let mut flipped = whole[..end].to_vec();
    flipped[offsets[1] as usize + 100] ^= 1;
    let mut reader = open(&flipped).unwrap();
    let second = reader.layout().block_end(0);
    assert!(matches!(
        reader.block(second),
        Err(RecordingError::Damaged(_))
    ));
    reader.block(reader.samples().end - 1).unwrap();
    let checked = Reader::open_checked(Cursor::new(&flipped[..])).unwrap();
    assert_eq!(checked.samples().end, second);
}

#[test]
fn a_header_that_makes_no_sense_is_refused() {
    let sound = header(3, 50, 1, 2);
    let wrong: [fn(&mut Header); 7] = [
        |header| header.steps_per_epoch = 0,
        |header| header.every_steps = 0,
        |header| header.robots = Chosen::First(4),
        |header| header.robots = Chosen::List(vec![2, 1]),
        |header| header.robots = Chosen::List(vec![1, 3]),
        |header| (header.from_epoch, header.epochs) = (u64::MAX, 2),
        |header| header.objects = u32::MAX,
    ];
    for (place, change) in wrong.into_iter().enumerate() {
        let mut header = sound.clone();
        change(&mut header);
        let (_, bytes) = Writer::new(&sound).unwrap();
        assert!(open(&bytes).is_ok());
        let bytes = crate::file::beginning(&header).unwrap();
        assert!(open(&bytes).is_err(), "{place}");
    }
    // So many epochs that no number holds its samples: it is empty, not a panic.
    let endless = Header {
        epochs: u64::MAX,
        ..sound
    };
    let bytes = crate::file::beginning(&endless).unwrap();
    let mut reader = open(&bytes).unwrap();
    assert!(reader.samples().is_empty() && reader.block(0).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever the numbers, also such as no simulation gives.
    #[test]
    fn any_samples_are_read_back(
        poses in prop::collection::vec(prop::array::uniform4(any::<f32>()), 12),
        commands in prop::collection::vec(prop::array::uniform2(any::<f32>()), 12),
        sensors in prop::collection::vec(prop::array::uniform8(any::<f32>()), 12),
        decisions in prop::collection::vec(prop::array::uniform2(any::<u16>()), 12),
        wheels in prop::collection::vec(prop::array::uniform2(any::<f32>()), 3),
    ) {
        let mut header = header(3, 3, 1, 1);
        header.objects = 0;
        let raw = Raw {
            first: 0,
            count: 4,
            rows: 3,
            objects: 0,
            poses,
            wheels_rad_s: wheels,
            commands,
            decisions,
            sensors,
            object_poses: Vec::new(),
        };
        let (mut writer, bytes) = Writer::new(&header).unwrap();
        let block = writer.encode(&raw).unwrap();
        let read = open(&bytes).unwrap().decode(&block).unwrap();
        prop_assert_eq!(read, Samples::of(&raw, writer.layout().longest_block()));
    }

    #[test]
    fn samples_are_found_where_they_stand(
        robots in 1_u32..3_000,
        steps in 1_u32..5_000,
        every in 1_u32..200,
        from in 0_u64..50,
        epochs in 1_u64..50,
        at in any::<u64>(),
    ) {
        let mut header = header(robots, steps, every, epochs);
        header.from_epoch = from;
        let layout = Layout::of(&header);
        let samples = layout.samples();
        let sample = samples.start + at % (samples.end - samples.start);
        let place = layout.place(sample);
        prop_assert!((from..from + epochs).contains(&place.arena_epoch));
        prop_assert!(place.step <= steps && place.step.is_multiple_of(every));
        prop_assert_eq!(layout.at_or_after(place), sample);
        prop_assert_eq!(layout.begins_epoch(sample), place.step == 0);
        let end = layout.block_end(sample);
        prop_assert!(end > sample && end <= samples.end);
        prop_assert_eq!(layout.block_of(end - 1), layout.block_of(sample));
        if end < samples.end {
            prop_assert_eq!(layout.block_of(end), layout.block_of(sample) + 1);
        }
        let start = layout.block_start(sample);
        prop_assert!(start <= sample && layout.block_of(start) == layout.block_of(sample));
        if start > samples.start {
            prop_assert_eq!(layout.block_end(start - 1), start);
        }
        prop_assert!(end - start <= layout.longest_block() as u64);
    }
}
