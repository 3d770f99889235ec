//! Beginning a recording, or going on with one that broke off: with the samples up to where the run
//! stands and no others, from the file and from the block that was begun.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use recording::{Header, Layout, Raw, Reader, RecordingError, SamplePlace, Writer};
use swarm::run::Place;

use super::paths::{Paths, remove};
use super::sink::{cut, write_tail};

/// Why a recording cannot be begun or gone on with.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// What there is of it does not reach to where the run stands.
    #[error("what there is of the recording does not reach to where the run stands")]
    Short,
    /// It was given up.
    #[error("the recording was given up")]
    GivenUp,
    /// It cannot be written.
    #[error("the recording cannot be written: {0}")]
    Io(#[from] io::Error),
    /// The compressor cannot be had.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// A recording that samples can be added to.
pub struct Opened {
    pub writer: Writer,
    pub file: File,
    /// The block that is begun, with the samples that it has.
    pub begun: Raw,
}

/// The sample that a run takes next which stands here.
pub fn next_sample(layout: &Layout, place: Place) -> u64 {
    let epoch = SamplePlace {
        arena_epoch: place.arena_epoch,
        step: 0,
    };
    let first = layout.at_or_after(epoch);
    let Place { step, .. } = place;
    match step {
        // Seen when the epoch's first step is taken.
        0 => first,
        step => first + u64::from(step / layout.every_steps()) + 1,
    }
}

/// Opens the recording of a run that stands at `place`.
pub fn open(header: &Header, paths: &Paths, place: Place) -> Result<Opened, OpenError> {
    let layout = Layout::of(header);
    let samples = layout.samples();
    let next = next_sample(&layout, place).clamp(samples.start, samples.end);
    if next == samples.start {
        return begin(header, &layout, paths);
    }
    if paths.given_up.exists() || paths.cut.exists() {
        return Err(OpenError::GivenUp);
    }
    go_on(header, &layout, paths, next)
}

fn room(header: &Header, layout: &Layout) -> Raw {
    let (rows, objects) = (header.robots.len(), header.objects as usize);
    Raw::with_room(header.fields, layout.longest_block(), rows, objects)
}

/// An empty block with room for all that a block of the recording can hold.
pub fn empty_block(header: &Header, layout: &Layout, first: u64) -> Raw {
    let mut raw = room(header, layout);
    raw.begin(first);
    raw
}

fn begin(header: &Header, layout: &Layout, paths: &Paths) -> Result<Opened, OpenError> {
    paths.remove();
    let (writer, bytes) = Writer::new(header)?;
    let mut file = File::create(&paths.part)?;
    file.write_all(&bytes)?;
    Ok(Opened {
        writer,
        file,
        begun: empty_block(header, layout, layout.samples().start),
    })
}

fn go_on(header: &Header, layout: &Layout, paths: &Paths, next: u64) -> Result<Opened, OpenError> {
    let mut reader = match OpenOptions::new().read(true).write(true).open(&paths.part) {
        Ok(file) => Reader::open_checked(file).map_err(|_| OpenError::Short)?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(OpenError::Short),
        Err(error) => return Err(error.into()),
    };
    if reader.header() != header {
        return Err(OpenError::Short);
    }
    let there = reader.samples();
    let block_start = layout.block_start(next - 1);
    let ends_block = layout.block_end(next - 1) == next;
    let mut begun = if ends_block {
        if there.end < next {
            return Err(OpenError::Short);
        }
        empty_block(header, layout, next)
    } else {
        let samples = if there.end >= next {
            reader.block(next - 1).map_err(|_| OpenError::Short)?
        } else if there.end == block_start {
            tail(&reader, &paths.tail)?
        } else {
            return Err(OpenError::Short);
        };
        let reaches = samples.first == block_start && samples.first + samples.count as u64 >= next;
        if !reaches {
            return Err(OpenError::Short);
        }
        samples.to_raw(header.fields, layout.longest_block())
    };
    begun.truncate((next - begun.first) as usize);
    let (blocks, end) = reader.blocks();
    let keep = match ends_block {
        true => layout.block_of(next - 1) + 1,
        false => layout.block_of(next - 1),
    };
    let length = blocks.get(keep).copied().unwrap_or(end);
    let offsets = blocks[..keep].to_vec();
    let mut writer = Writer::going_on(header, offsets, length)?;
    // Before the file is cut: what is cut off may be all that there is of the block that is begun.
    let block = writer.encode(&begun)?;
    write_tail(paths, &block)?;
    let mut file = reader.into_file();
    cut(&mut file, length)?;
    remove(&paths.whole);
    Ok(Opened {
        writer,
        file,
        begun,
    })
}

fn tail(reader: &Reader<File>, path: &Path) -> Result<recording::Samples, OpenError> {
    let block = std::fs::read(path).map_err(|_| OpenError::Short)?;
    reader.decode(&block).map_err(|_| OpenError::Short)
}
