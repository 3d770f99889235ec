//! The wheel commands that each action stands for: a bounded uniform sample of each cluster's.

use serde::{Deserialize, Serialize};

use super::are_sound;
use super::centres::Centres;
use crate::dimensions::WHEELS;
use crate::prefetch::prefetch;
use crate::random::{Stream, below};

/// For each actuator cluster at most `cap` of the commands that fell in it, equally likely.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Saved")]
pub struct ActuatorSamples {
    cap: u32,
    /// Commands offered to each cluster.
    offered: Vec<u64>,
    /// `cap` commands a cluster; the first is the centre until one was offered.
    commands: Vec<[f32; WHEELS]>,
    stream: Stream,
}

/// The same as saved, which may not fit together.
#[derive(Deserialize)]
struct Saved {
    cap: u32,
    offered: Vec<u64>,
    commands: Vec<[f32; WHEELS]>,
    stream: Stream,
}

impl TryFrom<Saved> for ActuatorSamples {
    type Error = &'static str;

    fn try_from(saved: Saved) -> Result<Self, Self::Error> {
        let Saved {
            cap,
            offered,
            commands,
            stream,
        } = saved;
        let wanted = offered.len().checked_mul(cap as usize);
        if cap == 0 || wanted != Some(commands.len()) {
            return Err("commands of actions do not fit their number");
        }
        if !are_sound(commands.as_flattened()) {
            return Err("commands of actions are out of range");
        }
        Ok(Self {
            cap,
            offered,
            commands,
            stream,
        })
    }
}

impl ActuatorSamples {
    /// Empty samples of the clusters with these centres; `cap` at least one.
    pub fn new(centres: &Centres<WHEELS>, cap: u32, stream: Stream) -> Self {
        let cap = cap.max(1);
        let mut commands = Vec::with_capacity(centres.len() as usize * cap as usize);
        for centre in centres.iter() {
            commands.extend(std::iter::repeat_n(centre, cap as usize));
        }
        Self {
            cap,
            offered: vec![0; centres.len() as usize],
            commands,
            stream,
        }
    }

    /// Offers a command that fell in a cluster (Algorithm R, J. Vitter 1985).
    #[inline(always)]
    pub fn offer(&mut self, cluster: u32, command: [f32; WHEELS]) {
        let offered = &mut self.offered[cluster as usize];
        let place = if *offered < u64::from(self.cap) {
            *offered
        } else {
            self.stream.below(*offered + 1)
        };
        *offered += 1;
        if place < u64::from(self.cap) {
            self.commands[cluster as usize * self.cap as usize + place as usize] = command;
        }
    }

    /// Place of a command of the cluster's sample, chosen by 32 uniform bits; that of its centre when
    /// the sample is empty.
    #[inline(always)]
    pub fn place(&self, cluster: u32, bits: u32) -> u32 {
        let held = self.offered[cluster as usize].clamp(1, u64::from(self.cap)) as u32;
        cluster * self.cap + below(bits, held)
    }

    /// The command of a place.
    #[inline(always)]
    pub fn command(&self, place: u32) -> [f32; WHEELS] {
        self.commands[place as usize]
    }

    /// Asks for the memory that choosing a place needs.
    #[inline(always)]
    pub fn expect_choice(&self) {
        prefetch(&self.offered[..]);
    }

    /// Asks for a command.
    #[inline(always)]
    pub fn expect_command(&self, place: u32) {
        prefetch(&self.commands[place as usize]);
    }

    /// Actions that there are samples of.
    pub fn clusters(&self) -> u32 {
        self.offered.len() as u32
    }

    /// Bytes held besides the value itself by samples of `cap` commands of each cluster.
    pub fn heap_bytes_for(clusters: u32, cap: u32) -> u64 {
        let cluster =
            size_of::<u64>() as u64 + u64::from(cap.max(1)) * size_of::<[f32; WHEELS]>() as u64;
        u64::from(clusters) * cluster
    }

    /// Bytes held besides the value itself, exactly counted.
    pub fn heap_bytes(&self) -> u64 {
        Self::heap_bytes_for(self.offered.len() as u32, self.cap)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn an_empty_sample_gives_the_centre() {
        let centres = Centres::from_points(&[[0.25, -0.5], [1.0, 0.0]]);
        let mut samples = ActuatorSamples::new(&centres, 4, Stream::new(1));
        samples.offer(1, [0.75, 0.0]);
        for bits in [0, 1 << 31, u32::MAX] {
            assert_eq!(samples.command(samples.place(0, bits)), [0.25, -0.5]);
            assert_eq!(samples.command(samples.place(1, bits)), [0.75, 0.0]);
        }
    }

    #[test]
    fn every_command_is_as_likely_to_be_kept_and_drawn() {
        let centres = Centres::from_points(&[[0.0; 2], [0.0; 2]]);
        let mut bits = Stream::new(99);
        let mut drawn = [0_i32; 50];
        for round in 0..50_000 {
            let mut samples = ActuatorSamples::new(&centres, 8, Stream::new(round));
            for i in 0..50 {
                samples.offer(0, [-1.0; 2]);
                samples.offer(1, [i as f32; 2]);
            }
            let place = samples.place(1, bits.bits() as u32);
            drawn[samples.command(place)[0] as usize] += 1;
        }
        assert!(drawn.iter().all(|n| (n - 1_000).abs() < 150), "{drawn:?}");
    }

    #[test]
    fn saved_samples_that_do_not_fit_together_are_refused() {
        let centres = Centres::from_points(&[[0.25, -0.5], [1.0, 0.0]]);
        let samples = ActuatorSamples::new(&centres, 4, Stream::new(1));
        let read = |samples: &ActuatorSamples| {
            postcard::from_bytes::<ActuatorSamples>(&postcard::to_stdvec(samples).unwrap())
        };
        assert_eq!(read(&samples).unwrap(), samples);
        for cap in [0, 3, 40, u32::MAX] {
            let wrong = ActuatorSamples {
                cap,
                ..samples.clone()
            };
            assert!(read(&wrong).is_err(), "{cap}");
        }
    }

    #[test]
    fn goes_on_after_a_snapshot_as_if_never_stopped() {
        let centres = Centres::from_points(&[[0.0; 2]]);
        let mut straight = ActuatorSamples::new(&centres, 5, Stream::new(2));
        (0..30).for_each(|i| straight.offer(0, [i as f32; 2]));
        let bytes = postcard::to_stdvec(&straight).unwrap();
        let mut restored: ActuatorSamples = postcard::from_bytes(&bytes).unwrap();
        assert_eq!(restored, straight);
        for i in 0..100 {
            straight.offer(0, [i as f32, 1.0]);
            restored.offer(0, [i as f32, 1.0]);
        }
        assert_eq!(restored, straight);
    }
}
