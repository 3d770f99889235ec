//! Writing a recording: its header, blocks one after the other, at the end their index.
//!
//! ```text
//! magic (8), length and CRC-32 of the header (4, 4), the header (zstd of JSON)
//! blocks: magic (4), first sample (8), samples (4), bytes (4), CRC-32 (4), planes
//! index: offset of each block (8 each), number of blocks (8), CRC-32 of both (4), magic (8)
//! ```

use std::io::Write;

use crate::block::Coder;
use crate::error::RecordingError;
use crate::header::Header;
use crate::layout::Layout;
use crate::raw::Raw;
use crate::samples::Samples;

pub(crate) const MAGIC: [u8; 8] = *b"EVSWREC2";
pub(crate) const END_MAGIC: [u8; 8] = *b"EVSWEND1";
/// Most bytes of a header.
pub(crate) const MOST_HEADER_BYTES: u32 = 1 << 28;
const HEADER_LEVEL: i32 = 9;

/// Makes the bytes of a recording, part by part; whoever has it writes them.
pub struct Writer {
    coder: Coder,
    layout: Layout,
    /// Where each block begins.
    offsets: Vec<u64>,
    length: u64,
}

/// The bytes that a recording begins with.
pub(crate) fn beginning(header: &Header) -> Result<Vec<u8>, RecordingError> {
    let json = serde_json::to_vec(header)
        .map_err(|_| RecordingError::Damaged("a header that is no JSON"))?;
    let packed = zstd::bulk::compress(&json, HEADER_LEVEL)?;
    let mut bytes = MAGIC.to_vec();
    bytes.write_all(&(packed.len() as u32).to_le_bytes())?;
    bytes.write_all(&crc32fast::hash(&packed).to_le_bytes())?;
    bytes.write_all(&packed)?;
    Ok(bytes)
}

impl Writer {
    /// A recording, and the bytes that it begins with.
    ///
    /// # Errors
    /// When the compressor cannot be had.
    pub fn new(header: &Header) -> Result<(Self, Vec<u8>), RecordingError> {
        let bytes = beginning(header)?;
        let writer = Self {
            coder: Coder::new(header)?,
            layout: Layout::of(header),
            offsets: Vec::new(),
            length: bytes.len() as u64,
        };
        Ok((writer, bytes))
    }

    /// One that goes on after the blocks that are there.
    ///
    /// # Errors
    /// When the compressor cannot be had.
    pub fn going_on(
        header: &Header,
        offsets: Vec<u64>,
        length: u64,
    ) -> Result<Self, RecordingError> {
        Ok(Self {
            coder: Coder::new(header)?,
            layout: Layout::of(header),
            offsets,
            length,
        })
    }

    /// Which sample stands where.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Bytes so far.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Samples as a block that is part of no file yet.
    ///
    /// # Errors
    /// When the compressor fails.
    pub fn encode(&mut self, raw: &Raw) -> Result<Vec<u8>, RecordingError> {
        let samples = Samples::of(raw, self.layout.longest_block());
        self.coder.encode(&samples)
    }

    /// The next block of the file is of so many bytes.
    pub fn add(&mut self, block: &[u8]) {
        self.offsets.push(self.length);
        self.length += block.len() as u64;
    }

    /// The bytes that it ends with.
    pub fn end(&self) -> Vec<u8> {
        let mut bytes: Vec<u8> = self.offsets.iter().flat_map(|o| o.to_le_bytes()).collect();
        bytes.extend((self.offsets.len() as u64).to_le_bytes());
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes.extend(END_MAGIC);
        bytes
    }
}
