//! Bytes of one kind, compressed by themselves, and whole numbers of changing length in them.

use crate::error::RecordingError;

/// Level of compression: higher ones take much longer for little.
const LEVEL: i32 = 1;

/// Appends a number: small ones, of either sign, take one byte.
pub fn put_signed(plane: &mut Vec<u8>, value: i32) {
    put(plane, ((value << 1) ^ (value >> 31)) as u32);
}

/// Appends a number: small ones take one byte.
pub fn put(plane: &mut Vec<u8>, mut value: u32) {
    while value >= 0x80 {
        plane.push(value as u8 | 0x80);
        value >>= 7;
    }
    plane.push(value as u8);
}

/// Reads numbers one after the other.
pub struct Numbers<'a>(pub &'a [u8]);

impl Numbers<'_> {
    pub fn next(&mut self) -> Result<u32, RecordingError> {
        let mut value = 0_u32;
        for place in 0..5 {
            let (&byte, rest) = self
                .0
                .split_first()
                .ok_or(RecordingError::Damaged("a column is short"))?;
            self.0 = rest;
            value |= u32::from(byte & 0x7F) << (7 * place);
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(RecordingError::Damaged("a number has no end"))
    }

    pub fn next_signed(&mut self) -> Result<i32, RecordingError> {
        let value = self.next()?;
        Ok((value >> 1) as i32 ^ -((value & 1) as i32))
    }
}

/// Compresses planes and appends them to a block.
pub struct Packer {
    compressor: zstd::bulk::Compressor<'static>,
    packed: Vec<u8>,
}

impl Packer {
    pub fn new() -> Result<Self, RecordingError> {
        Ok(Self {
            compressor: zstd::bulk::Compressor::new(LEVEL)?,
            packed: Vec::new(),
        })
    }

    pub fn append(&mut self, block: &mut Vec<u8>, plane: &[u8]) -> Result<(), RecordingError> {
        put(block, plane.len() as u32);
        if plane.is_empty() {
            return Ok(());
        }
        self.packed.clear();
        self.packed
            .reserve(zstd::zstd_safe::compress_bound(plane.len()));
        self.compressor
            .compress_to_buffer(plane, &mut self.packed)?;
        put(block, self.packed.len() as u32);
        block.extend_from_slice(&self.packed);
        Ok(())
    }
}

/// Takes the next plane off a block; one of more than `most` bytes is damage.
pub fn take(block: &mut &[u8], most: usize) -> Result<Vec<u8>, RecordingError> {
    let mut numbers = Numbers(block);
    let length = numbers.next()? as usize;
    if length > most {
        return Err(RecordingError::Damaged("a column is too long"));
    }
    if length == 0 {
        *block = numbers.0;
        return Ok(Vec::new());
    }
    let packed = numbers.next()? as usize;
    let (packed, rest) = numbers
        .0
        .split_at_checked(packed)
        .ok_or(RecordingError::Damaged("a column is short"))?;
    *block = rest;
    let plane = zstd::bulk::decompress(packed, length)?;
    if plane.len() == length {
        Ok(plane)
    } else {
        Err(RecordingError::Damaged("a column is short"))
    }
}
