//! Which sample stands where: arithmetic over a header, the same for every recording of a run.

use crate::header::Header;

/// Samples of robots in a block, where an epoch has so many.
const BLOCK_ROBOT_SAMPLES: u64 = 65_536;

/// Places of samples and of blocks. Samples are numbered over the whole run, also where only a part
/// of it is recorded, and blocks end where these numbers say so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    samples_per_epoch: u64,
    every_steps: u32,
    /// Whole epochs of a block, or, where that is 0, samples of a block within an epoch.
    epochs_per_block: u64,
    samples_per_block: u64,
    /// First sample, and the one after the last.
    first: u64,
    end: u64,
}

/// Where a sample was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SamplePlace {
    /// The epoch, counted from 0 over all stages.
    pub arena_epoch: u64,
    /// Steps of it that were done.
    pub step: u32,
}

impl Layout {
    /// The layout of a recording.
    pub fn of(header: &Header) -> Self {
        let every_steps = header.every_steps.max(1);
        let samples_per_epoch = u64::from(header.steps_per_epoch / every_steps) + 1;
        let rows = (header.robots.len() as u64 + u64::from(header.objects)).max(1);
        let samples_per_block = (BLOCK_ROBOT_SAMPLES / rows).max(1);
        Self {
            samples_per_epoch,
            every_steps,
            epochs_per_block: samples_per_block / samples_per_epoch,
            samples_per_block,
            first: header.from_epoch.saturating_mul(samples_per_epoch),
            end: (header.from_epoch.saturating_add(header.epochs))
                .saturating_mul(samples_per_epoch),
        }
    }

    /// First sample, and the one after the last.
    pub fn samples(&self) -> std::ops::Range<u64> {
        self.first..self.end
    }

    /// Steps between two samples.
    pub fn every_steps(&self) -> u32 {
        self.every_steps
    }

    /// Most samples of a block.
    pub fn longest_block(&self) -> usize {
        let most = match self.epochs_per_block {
            0 => self.samples_per_block.min(self.samples_per_epoch),
            epochs => epochs * self.samples_per_epoch,
        };
        most as usize
    }

    /// The number of the block that a sample is in.
    fn block(&self, sample: u64) -> u64 {
        match self.epochs_per_block {
            0 => {
                let (epoch, within) = (
                    sample / self.samples_per_epoch,
                    sample % self.samples_per_epoch,
                );
                let blocks = self.samples_per_epoch.div_ceil(self.samples_per_block);
                epoch * blocks + within / self.samples_per_block
            }
            epochs => sample / (epochs * self.samples_per_epoch),
        }
    }

    /// The place in this recording of the block that a sample of it is in.
    pub fn block_of(&self, sample: u64) -> usize {
        (self.block(sample) - self.block(self.first)) as usize
    }

    /// The first sample of the block that a sample is in.
    pub fn block_start(&self, sample: u64) -> u64 {
        let start = match self.epochs_per_block {
            0 => {
                let within = sample % self.samples_per_epoch;
                sample - within % self.samples_per_block
            }
            epochs => self.block(sample) * (epochs * self.samples_per_epoch),
        };
        start.max(self.first)
    }

    /// The sample after the last of the block that a sample is in.
    pub fn block_end(&self, sample: u64) -> u64 {
        let end = match self.epochs_per_block {
            0 => {
                let epoch = sample / self.samples_per_epoch * self.samples_per_epoch;
                let within = (sample - epoch) / self.samples_per_block + 1;
                epoch + (within * self.samples_per_block).min(self.samples_per_epoch)
            }
            epochs => (self.block(sample) + 1) * (epochs * self.samples_per_epoch),
        };
        end.min(self.end)
    }

    /// Where a sample was taken.
    pub fn place(&self, sample: u64) -> SamplePlace {
        SamplePlace {
            arena_epoch: sample / self.samples_per_epoch,
            step: (sample % self.samples_per_epoch) as u32 * self.every_steps,
        }
    }

    /// The number of the sample at a place, or of the next one after it.
    pub fn at_or_after(&self, place: SamplePlace) -> u64 {
        let within = u64::from(place.step).div_ceil(u64::from(self.every_steps));
        place.arena_epoch.saturating_mul(self.samples_per_epoch)
            + within.min(self.samples_per_epoch)
    }

    /// Whether an epoch begins with a sample.
    pub fn begins_epoch(&self, sample: u64) -> bool {
        sample.is_multiple_of(self.samples_per_epoch)
    }
}
