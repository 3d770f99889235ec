//! One block of samples as bytes: a head of fixed size with a checksum, then planes.

use crate::columns::{
    Expect, command_planes, halves, object_planes, pose_planes, read_commands, read_objects,
    read_poses, read_sensors, sensor_plane, whole,
};
use crate::error::RecordingError;
use crate::header::Header;
use crate::layout::Layout;
use crate::planes::{Numbers, Packer, put_signed, take};
use crate::predict::Directions;
use crate::samples::Samples;
use crate::units::SENSORS;

const MAGIC: [u8; 4] = *b"EVRB";
/// Bytes of a block's head.
pub const HEAD_BYTES: usize = 24;
/// Most bytes of a block, whatever a head says.
const MOST_BYTES: u32 = 1 << 30;

/// A block's head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// Number of the first sample.
    pub first: u64,
    /// Samples.
    pub count: u32,
    /// Bytes that follow.
    pub bytes: u32,
    checksum: u32,
}

impl Head {
    /// Reads a head; `None` where none is.
    pub fn read(bytes: &[u8; HEAD_BYTES]) -> Option<Self> {
        let rest = bytes.strip_prefix(&MAGIC)?;
        let head = Self {
            first: u64::from_le_bytes(rest[..8].try_into().ok()?),
            count: u32::from_le_bytes(rest[8..12].try_into().ok()?),
            bytes: u32::from_le_bytes(rest[12..16].try_into().ok()?),
            checksum: u32::from_le_bytes(rest[16..20].try_into().ok()?),
        };
        (head.bytes <= MOST_BYTES).then_some(head)
    }

    /// Whether what follows is what was written.
    pub fn fits(&self, payload: &[u8]) -> bool {
        payload.len() == self.bytes as usize && self.checksum == self.checksum_of(payload)
    }

    fn checksum_of(&self, payload: &[u8]) -> u32 {
        let mut sum = crc32fast::Hasher::new();
        sum.update(&self.first.to_le_bytes());
        sum.update(&self.count.to_le_bytes());
        sum.update(payload);
        sum.finalize()
    }
}

/// Turns samples into blocks and back.
pub struct Coder {
    header: Header,
    layout: Layout,
    directions: &'static Directions,
    packer: Packer,
}

impl Coder {
    /// For blocks of a recording.
    pub fn new(header: &Header) -> Result<Self, RecordingError> {
        Ok(Self {
            header: header.clone(),
            layout: Layout::of(header),
            directions: Directions::get(),
            packer: Packer::new()?,
        })
    }

    /// Samples as a block, head and all.
    pub fn encode(&mut self, samples: &Samples) -> Result<Vec<u8>, RecordingError> {
        let mut block = vec![0; HEAD_BYTES];
        let fields = self.header.fields;
        if fields.command {
            for plane in command_planes(&samples.command) {
                self.packer.append(&mut block, &plane)?;
            }
        }
        if fields.pose {
            let (expect, planes) = self.poses(samples)?;
            block.push(u8::from(expect == Expect::Reckoned));
            let mut wheels = Vec::new();
            for ticks in samples.wheels.iter().flatten() {
                put_signed(&mut wheels, *ticks);
            }
            self.packer.append(&mut block, &wheels)?;
            for plane in planes {
                self.packer.append(&mut block, &plane)?;
            }
        }
        if fields.decision {
            for column in &samples.decision {
                for plane in halves(column.iter().copied()) {
                    self.packer.append(&mut block, &plane)?;
                }
            }
        }
        if fields.sensors {
            let plane = sensor_plane(&samples.sensors, samples.count);
            self.packer.append(&mut block, &plane)?;
        }
        if samples.objects > 0 {
            let planes = object_planes(&self.header, &self.layout, self.directions, samples)?;
            for plane in planes {
                self.packer.append(&mut block, &plane)?;
            }
        }
        let mut head = Head {
            first: samples.first,
            count: samples.count as u32,
            bytes: u32::try_from(block.len() - HEAD_BYTES)
                .map_err(|_| RecordingError::Damaged("a block is too large"))?,
            checksum: 0,
        };
        head.checksum = head.checksum_of(&block[HEAD_BYTES..]);
        block[..4].copy_from_slice(&MAGIC);
        block[4..12].copy_from_slice(&head.first.to_le_bytes());
        block[12..16].copy_from_slice(&head.count.to_le_bytes());
        block[16..20].copy_from_slice(&head.bytes.to_le_bytes());
        block[20..24].copy_from_slice(&head.checksum.to_le_bytes());
        Ok(block)
    }

    /// Poses in whichever way takes fewer bits.
    fn poses(&self, samples: &Samples) -> Result<(Expect, [Vec<u8>; 3]), RecordingError> {
        let by = |expect| pose_planes(&self.header, &self.layout, self.directions, expect, samples);
        let (same, cost) = by(Expect::Same)?;
        let can_reckon = self.header.every_steps == 1
            && self.header.fields.command
            && !samples.wheels.is_empty();
        if can_reckon {
            let (reckoned, less) = by(Expect::Reckoned)?;
            if less < cost {
                return Ok((Expect::Reckoned, reckoned));
            }
        }
        Ok((Expect::Same, same))
    }

    /// The samples of a block.
    pub fn decode(&self, head: &Head, payload: &[u8]) -> Result<Samples, RecordingError> {
        if !head.fits(payload) {
            return Err(RecordingError::Damaged("a block's checksum does not fit"));
        }
        let header = &self.header;
        let (rows, objects) = (header.robots.len(), header.objects as usize);
        let count = head.count as usize;
        if count > self.layout.longest_block() {
            return Err(RecordingError::Damaged("a block is too long"));
        }
        let n = rows * count;
        let mut samples = Samples {
            first: head.first,
            count,
            rows,
            objects,
            ..Samples::default()
        };
        let rest = &mut &*payload;
        let fields = header.fields;
        if fields.command {
            let planes = [take(rest, 4 * n)?, take(rest, 2 * n)?, take(rest, 2 * n)?];
            samples.command = read_commands(&planes, n)?;
        }
        if fields.pose {
            let (&way, after) = rest
                .split_first()
                .ok_or(RecordingError::Damaged("a block is short"))?;
            *rest = after;
            let expect = match way {
                0 => Expect::Same,
                _ if fields.command => Expect::Reckoned,
                _ => return Err(RecordingError::Damaged("no commands to reckon with")),
            };
            let wheels = take(rest, rows * 10)?;
            let mut numbers = Numbers(&wheels);
            while !numbers.0.is_empty() {
                let both = [numbers.next_signed()?, numbers.next_signed()?];
                samples.wheels.push(both);
            }
            let planes = [take(rest, 5 * n)?, take(rest, 5 * n)?, take(rest, 5 * n)?];
            let (layout, directions) = (&self.layout, self.directions);
            read_poses(header, layout, directions, expect, &planes, &mut samples)?;
        }
        if fields.decision {
            for column in &mut samples.decision {
                let planes = [take(rest, n)?, take(rest, n)?];
                *column = whole([&planes[0], &planes[1]], n)?;
            }
        }
        if fields.sensors {
            let plane = take(rest, 5 * n * SENSORS)?;
            samples.sensors = read_sensors(&plane, rows, count)?;
        }
        if objects > 0 {
            let n = objects * count;
            let planes = [take(rest, 5 * n)?, take(rest, 5 * n)?, take(rest, 5 * n)?];
            read_objects(header, &self.layout, self.directions, &planes, &mut samples)?;
        }
        if rest.is_empty() {
            Ok(samples)
        } else {
            Err(RecordingError::Damaged("a block has bytes left over"))
        }
    }
}
