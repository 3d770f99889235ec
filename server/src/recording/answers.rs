//! What programs answered that steered a run from outside, from a recording of it: the run is made
//! again without them, to the same bits.

use std::fs::File;
use std::path::Path;

use recording::{Lack, Reader, RecordingError, SamplePlace, Samples};
use swarm::run::Run;

use crate::documents::ResolvedRun;
use crate::runner::{Pilot, Stop};

/// Why a recording cannot steer a run.
#[derive(Debug, thiserror::Error)]
pub enum AnswersError {
    /// The file cannot be opened.
    #[error("the recording cannot be opened: {0}")]
    Io(#[from] std::io::Error),
    /// It is damaged, or none.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// It is of something else.
    #[error("it is a recording of another run (spec, seed and version must be the same)")]
    OtherRun,
    /// It does not hold every command.
    #[error(
        "it does not hold every command: record with every_steps 1, all robots and the field command"
    )]
    NotEvery,
    /// It was cut.
    #[error("it does not reach from the beginning to the end of the run")]
    Cut,
    /// It was cut or changed after its last block.
    #[error("it has every command, but its index at the end of the file is cut or damaged")]
    NoIndex,
    /// Something was added to it.
    #[error("{0} bytes that do not belong to it stand after its end")]
    Surplus(u64),
}

/// Steers a run by what was answered before.
pub struct Answers {
    reader: Reader<File>,
    block: Option<Samples>,
    commands: Vec<[f32; 2]>,
}

impl Answers {
    /// From a recording of this run.
    ///
    /// # Errors
    /// Why it cannot steer it.
    pub fn open(path: &Path, spec: &ResolvedRun) -> Result<Self, AnswersError> {
        let reader = Reader::open(File::open(path)?)?;
        let header = reader.header();
        if header.subject != spec.unrecorded().key() {
            return Err(AnswersError::OtherRun);
        }
        let robots = header.robots_total as usize;
        if header.every_steps != 1 || !header.fields.command || header.robots.len() != robots {
            return Err(AnswersError::NotEvery);
        }
        match reader.lack() {
            Some(Lack::Surplus(bytes)) => return Err(AnswersError::Surplus(bytes)),
            Some(Lack::Index) => return Err(AnswersError::NoIndex),
            Some(Lack::Samples) => return Err(AnswersError::Cut),
            None if header.from_epoch != 0 => return Err(AnswersError::Cut),
            None => {}
        }
        Ok(Self {
            commands: vec![[0.0; 2]; robots],
            reader,
            block: None,
        })
    }

    /// Reads the commands of the next step.
    fn read(&mut self, run: &Run) -> Result<(), RecordingError> {
        let place = run.place();
        // A moment shows the commands that led to it.
        let after = SamplePlace {
            arena_epoch: place.arena_epoch,
            step: place.step + 1,
        };
        let sample = self.reader.layout().at_or_after(after);
        let holds =
            |block: &Samples| (block.first..block.first + block.count as u64).contains(&sample);
        let block = match self.block.take().filter(holds) {
            Some(block) => block,
            None => self.reader.block(sample)?,
        };
        let at = (sample - block.first) as usize;
        for (row, command) in self.commands.iter_mut().enumerate() {
            *command = block.command(row, at).map(|wheel| wheel as f32);
        }
        self.block = Some(block);
        Ok(())
    }
}

impl Pilot for Answers {
    fn steer(&mut self, run: &mut Run) -> Result<(), Stop> {
        self.read(run)
            .map_err(|error| Stop::Fail(format!("what was answered cannot be read: {error}")))?;
        run.steer(&self.commands);
        Ok(())
    }
}
