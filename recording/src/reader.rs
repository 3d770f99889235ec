//! Reading a recording, whole or cut: by its index, or else block by block up to the first that is
//! not whole.

use std::io::{ErrorKind, Read, Seek, SeekFrom};

use crate::block::{Coder, HEAD_BYTES, Head};
use crate::error::RecordingError;
use crate::file::{END_MAGIC, MAGIC, MOST_HEADER_BYTES};
use crate::header::Header;
use crate::layout::Layout;
use crate::samples::Samples;

/// Most bytes that a header may come to.
const MOST_HEADER_JSON: usize = 1 << 30;
/// Most robots and objects of a recording.
const MOST_ROWS: u64 = 1 << 22;
/// Bytes after the index: number of blocks, checksum, magic.
const FOOTER_BYTES: usize = 20;

/// A recording that is open.
pub struct Reader<F> {
    file: F,
    header: Header,
    layout: Layout,
    coder: Coder,
    /// Where each block begins, and what its head says; the heads are read when they are needed.
    offsets: Vec<u64>,
    /// Where blocks end.
    end: u64,
    /// The sample after the last that is there.
    samples_end: u64,
    /// Bytes of the file.
    length: u64,
    complete: bool,
}

/// What is wrong with a recording that is not complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lack {
    /// Samples are missing, or damaged.
    Samples,
    /// All samples are there, and the index after them is not, or is damaged.
    Index,
    /// All samples are there, and so many bytes stand after where the index ends.
    Surplus(u64),
}

fn read_exact<const N: usize>(file: &mut impl Read) -> Result<[u8; N], RecordingError> {
    let mut bytes = [0; N];
    match file.read_exact(&mut bytes) {
        Ok(()) => Ok(bytes),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
            Err(RecordingError::Damaged("it is cut short"))
        }
        Err(error) => Err(error.into()),
    }
}

fn read_part(file: &mut impl Read, length: usize) -> Result<Vec<u8>, RecordingError> {
    let mut bytes = Vec::new();
    file.take(length as u64).read_to_end(&mut bytes)?;
    if bytes.len() == length {
        Ok(bytes)
    } else {
        Err(RecordingError::Damaged("it is cut short"))
    }
}

fn header(file: &mut impl Read) -> Result<Header, RecordingError> {
    let magic: [u8; 8] = read_exact(file).map_err(|_| RecordingError::Foreign)?;
    if magic != MAGIC {
        return Err(RecordingError::Foreign);
    }
    let length = u32::from_le_bytes(read_exact(file)?);
    let checksum = u32::from_le_bytes(read_exact(file)?);
    let damaged = RecordingError::Damaged("its header was changed");
    if length > MOST_HEADER_BYTES {
        return Err(damaged);
    }
    let packed = read_part(file, length as usize)?;
    if crc32fast::hash(&packed) != checksum {
        return Err(damaged);
    }
    let mut json = Vec::new();
    let unpacked = zstd::stream::read::Decoder::new(&packed[..])?;
    unpacked
        .take(MOST_HEADER_JSON as u64)
        .read_to_end(&mut json)?;
    let header: Header = serde_json::from_slice(&json).map_err(|_| damaged)?;
    let sound = header.steps_per_epoch > 0
        && header.every_steps > 0
        && !header.robots.is_empty()
        && header.robots.len() <= header.robots_total as usize
        && header.robots.len() as u64 + u64::from(header.objects) <= MOST_ROWS
        && header.robots.is_ascending_below(header.robots_total)
        && header.from_epoch.checked_add(header.epochs).is_some();
    sound
        .then_some(header)
        .ok_or(RecordingError::Damaged("its header makes no sense"))
}

impl<F: Read + Seek> Reader<F> {
    /// Opens a recording. One that was cut is read up to its last whole block; of the blocks before
    /// that only the heads are looked at, so that it is as quick where the recording is long.
    ///
    /// # Errors
    /// When it is none, or its header is damaged.
    pub fn open(file: F) -> Result<Self, RecordingError> {
        Self::open_as(file, false)
    }

    /// Opens a recording, of which one that was cut is read up to its first damaged block: for
    /// whoever goes on with it.
    ///
    /// # Errors
    /// When it is none, or its header is damaged.
    pub fn open_checked(file: F) -> Result<Self, RecordingError> {
        Self::open_as(file, true)
    }

    fn open_as(mut file: F, checked: bool) -> Result<Self, RecordingError> {
        file.seek(SeekFrom::Start(0))?;
        let header = header(&mut file)?;
        let begin = file.stream_position()?;
        let length = file.seek(SeekFrom::End(0))?;
        let mut reader = Self {
            layout: Layout::of(&header),
            coder: Coder::new(&header)?,
            samples_end: 0,
            offsets: Vec::new(),
            end: begin,
            length,
            complete: false,
            header,
            file,
        };
        reader.samples_end = reader.layout.samples().start;
        match reader.index(begin)? {
            Some((offsets, end)) => {
                reader.offsets = offsets;
                reader.end = end;
                reader.samples_end = reader.layout.samples().end;
                reader.complete = true;
            }
            None => reader.scan(begin, checked)?,
        }
        Ok(reader)
    }

    /// The index and where it begins, where a whole one is at the end.
    fn index(&mut self, begin: u64) -> Result<Option<(Vec<u64>, u64)>, RecordingError> {
        let length = self.length;
        let samples = self.layout.samples();
        let blocks = match samples.end.checked_sub(1) {
            Some(last) if last >= samples.start => self.layout.block_of(last) as u64 + 1,
            _ => 0,
        };
        let bytes = blocks.saturating_mul(8).saturating_add(FOOTER_BYTES as u64);
        let Some(from) = length.checked_sub(bytes).filter(|from| *from >= begin) else {
            return Ok(None);
        };
        self.file.seek(SeekFrom::Start(length - 8))?;
        if read_exact::<8>(&mut self.file)? != END_MAGIC {
            return Ok(None);
        }
        self.file.seek(SeekFrom::Start(from))?;
        let index = read_part(&mut self.file, bytes as usize)?;
        let (summed, rest) = index.split_at(index.len() - 12);
        if crc32fast::hash(summed).to_le_bytes() != rest[..4]
            || blocks.to_le_bytes() != summed[summed.len() - 8..]
        {
            return Ok(None);
        }
        let offsets = summed[..summed.len() - 8].chunks_exact(8);
        let offsets = offsets.map(|o| o.iter().rev().fold(0, |n, b| n << 8 | u64::from(*b)));
        Ok(Some((offsets.collect(), from)))
    }

    /// Finds the blocks that are there, each after the one before.
    fn scan(&mut self, begin: u64, checked: bool) -> Result<(), RecordingError> {
        let length = self.length;
        let mut offset = begin;
        while let Some(head) = self.next_head(offset, length)? {
            let after = offset + HEAD_BYTES as u64 + u64::from(head.bytes);
            if checked && !self.is_whole(&head)? {
                break;
            }
            self.offsets.push(offset);
            offset = after;
            self.end = after;
            self.samples_end = head.first + u64::from(head.count);
        }
        // What a crash left at the end may have its length but not its bytes.
        while let Some(&last) = self.offsets.last() {
            let head = self.next_head_at(last)?;
            match head {
                Some(head) if checked || self.is_whole(&head)? => break,
                _ => {}
            }
            self.offsets.pop();
            self.end = last;
            self.samples_end = self.layout.block_start(self.samples_end - 1);
        }
        Ok(())
    }

    /// The head at an offset, where it is that of the block that is due and all of its bytes are
    /// there; they are read next.
    fn next_head(&mut self, offset: u64, length: u64) -> Result<Option<Head>, RecordingError> {
        let due = self.samples_end;
        if due >= self.layout.samples().end {
            return Ok(None);
        }
        let ends = |head: &Head| offset + HEAD_BYTES as u64 + u64::from(head.bytes);
        let head = self.next_head_at(offset)?;
        Ok(head.filter(|head| {
            head.first == due
                && due.checked_add(u64::from(head.count)) == Some(self.layout.block_end(due))
                && ends(head) <= length
        }))
    }

    fn next_head_at(&mut self, offset: u64) -> Result<Option<Head>, RecordingError> {
        self.file.seek(SeekFrom::Start(offset))?;
        match read_exact(&mut self.file) {
            Ok(bytes) => Ok(Head::read(&bytes)),
            Err(RecordingError::Io(error)) => Err(RecordingError::Io(error)),
            Err(_) => Ok(None),
        }
    }

    /// Whether the bytes that follow a head, which are read next, are what was written.
    fn is_whole(&mut self, head: &Head) -> Result<bool, RecordingError> {
        let mut payload = Vec::new();
        let file = &mut self.file;
        file.take(u64::from(head.bytes)).read_to_end(&mut payload)?;
        Ok(head.fits(&payload))
    }

    fn read_block(&mut self) -> Result<(Head, Vec<u8>), RecordingError> {
        let bytes = read_exact(&mut self.file)?;
        let head =
            Head::read(&bytes).ok_or(RecordingError::Damaged("no block where one is due"))?;
        let payload = read_part(&mut self.file, head.bytes as usize)?;
        Ok((head, payload))
    }

    /// What it is of.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Which sample stands where.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The samples that are there.
    pub fn samples(&self) -> std::ops::Range<u64> {
        self.layout.samples().start..self.samples_end
    }

    /// Whether all of it is there.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// What is wrong with it, where it is not complete.
    pub fn lack(&self) -> Option<Lack> {
        if self.complete {
            return None;
        }
        if self.samples_end < self.layout.samples().end {
            return Some(Lack::Samples);
        }
        let whole = self.end + self.offsets.len() as u64 * 8 + FOOTER_BYTES as u64;
        Some(match self.length.checked_sub(whole) {
            None | Some(0) => Lack::Index,
            Some(surplus) => Lack::Surplus(surplus),
        })
    }

    /// Where each block begins, and where the last one ends.
    pub fn blocks(&self) -> (&[u64], u64) {
        (&self.offsets, self.end)
    }

    /// The file.
    pub fn into_file(self) -> F {
        self.file
    }

    /// The block that a sample is in.
    ///
    /// # Errors
    /// When the sample is not there, or the block is damaged.
    pub fn block(&mut self, sample: u64) -> Result<Samples, RecordingError> {
        if !self.samples().contains(&sample) {
            return Err(RecordingError::Beyond(sample));
        }
        let offset = self.offsets[self.layout.block_of(sample)];
        self.file.seek(SeekFrom::Start(offset))?;
        let (head, payload) = self.read_block()?;
        let samples = self.coder.decode(&head, &payload)?;
        let fits = head.first <= sample && sample < head.first + u64::from(head.count);
        fits.then_some(samples)
            .ok_or(RecordingError::Damaged("a block is not where it should be"))
    }

    /// A block that is by itself: what a recording that goes on keeps beside it.
    ///
    /// # Errors
    /// When it is damaged.
    pub fn decode(&self, block: &[u8]) -> Result<Samples, RecordingError> {
        let damaged = RecordingError::Damaged("a block that is cut short");
        let (head, payload) = block.split_first_chunk().ok_or(damaged)?;
        let head = Head::read(head).ok_or(RecordingError::Foreign)?;
        self.coder.decode(&head, payload)
    }
}
