//! Where movable objects were over time, how far each had been moved, and what became of them.

use serde::{Deserialize, Serialize};

use crate::bodies::{ObjectPose, Objects};

/// Most samples that are kept, objects times moments: 2.4 MB.
pub(super) const MOST_SAMPLES: usize = 100_000;

/// An object at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectSample {
    /// Where it was.
    pub pose: ObjectPose,
    /// Way that it had been moved while visits counted, metres.
    pub moved_m: f64,
}

/// A time at which objects were looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Time {
    pub steps: u64,
    pub epoch: u32,
}

/// All objects at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment<'a> {
    /// Counted steps of the arena that were done.
    pub steps: u64,
    /// Counted epochs that were complete.
    pub epoch: u32,
    /// The objects in the arena's order.
    pub objects: &'a [ObjectSample],
}

/// The movable objects of a run over time; empty where it has none.
///
/// There is a moment where visits begin to count, and one for each row of metrics. At most
/// `MOST_SAMPLES` samples are kept: before there are more, every second moment is dropped, and
/// from then on only every second one is taken. The first always stays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tracks {
    pub(super) times: Vec<Time>,
    /// Of each moment all objects.
    samples: Vec<ObjectSample>,
    /// Moments that there have been, kept or not.
    offered: u64,
    /// Every 2^this of them is kept.
    halvings: u32,
}

/// What [`Tracks`] are made of, for whoever stores them.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackParts {
    /// Counted steps and complete counted epochs of each moment.
    pub times: Vec<(u64, u32)>,
    /// Of each moment all objects.
    pub samples: Vec<ObjectSample>,
    /// Moments that there have been, kept or not.
    pub offered: u64,
    /// Every 2^this of them is kept.
    pub halvings: u32,
}

pub(super) fn samples(objects: &Objects) -> impl Iterator<Item = ObjectSample> {
    let figures = objects.poses.iter().zip(&objects.moved_m);
    figures.map(|(&pose, &moved_m)| ObjectSample { pose, moved_m })
}

impl Tracks {
    /// A copy of their parts.
    pub fn parts(&self) -> TrackParts {
        let Self {
            times,
            samples,
            offered,
            halvings,
        } = self;
        TrackParts {
            times: times.iter().map(|time| (time.steps, time.epoch)).collect(),
            samples: samples.clone(),
            offered: *offered,
            halvings: *halvings,
        }
    }

    /// From their parts; `None` where moments do not have equally many objects.
    pub fn from_parts(parts: TrackParts) -> Option<Self> {
        let TrackParts {
            times,
            samples,
            offered,
            halvings,
        } = parts;
        let fits = match times.len() {
            0 => samples.is_empty(),
            moments => !samples.is_empty() && samples.len().is_multiple_of(moments),
        };
        let time = |(steps, epoch)| Time { steps, epoch };
        fits.then(|| Self {
            times: times.into_iter().map(time).collect(),
            samples,
            offered,
            halvings,
        })
    }

    /// Whether there is nothing to tell.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Moments in order of time.
    pub fn moments(&self) -> impl DoubleEndedIterator<Item = Moment<'_>> {
        let each = self.samples.chunks_exact(self.objects().max(1));
        self.times
            .iter()
            .zip(each)
            .map(|(&Time { steps, epoch }, objects)| Moment {
                steps,
                epoch,
                objects,
            })
    }

    /// Number of objects.
    pub fn objects(&self) -> usize {
        self.samples.len() / self.times.len().max(1)
    }

    /// Takes a moment in, if it is one of those that are kept.
    pub(super) fn offer(&mut self, time: Time, objects: &Objects, most: usize) {
        if objects.poses.is_empty() {
            return;
        }
        let number = self.offered;
        self.offered += 1;
        if !number.is_multiple_of(1 << self.halvings) {
            return;
        }
        // A first moment and one more are always kept.
        if self.times.len() > 1 && self.samples.len() + objects.poses.len() > most {
            self.halve();
            if !number.is_multiple_of(1 << self.halvings) {
                return;
            }
        }
        self.push(time, objects);
    }

    pub(super) fn push(&mut self, time: Time, objects: &Objects) {
        self.times.push(time);
        self.samples.extend(samples(objects));
    }

    /// Drops every second moment.
    fn halve(&mut self) {
        let objects = self.objects();
        self.times = self.times.iter().copied().step_by(2).collect();
        let moments = self.samples.chunks_exact(objects).step_by(2);
        self.samples = moments.flatten().copied().collect();
        self.halvings += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn objects(count: usize, moved_m: f64) -> Objects {
        let pose = ObjectPose {
            x_m: moved_m as f32,
            y_m: 0.0,
            cos: 1.0,
            sin: 0.0,
        };
        Objects {
            poses: vec![pose; count],
            moved_m: vec![moved_m; count],
        }
    }

    #[test]
    fn moments_are_thinned_evenly_and_bounded() {
        for (count, most) in [(1, 10), (3, 10), (4, 100), (7, 2)] {
            let mut tracks = Tracks::default();
            for step in 0..1_000_u64 {
                let time = Time {
                    steps: 5 * step,
                    epoch: 0,
                };
                tracks.offer(time, &objects(count, step as f64), most);
                assert!(tracks.samples.len() <= most.max(2 * count));
                assert_eq!(tracks.objects(), count);
                // The oracle: every 2^n-th moment so far, all samples of the same time.
                let spacing = 1_u64 << tracks.halvings;
                let expected = (0..=step).filter(|step| step % spacing == 0);
                assert!(tracks.moments().map(|m| m.steps / 5).eq(expected));
                for moment in tracks.moments() {
                    assert_eq!(moment.objects.len(), count);
                    let moved_m = (moment.steps / 5) as f64;
                    assert!(moment.objects.iter().all(|o| o.moved_m == moved_m));
                }
            }
            // No more is dropped than must be.
            assert!(
                4 * tracks.samples.len() >= most.min(1_000 * count),
                "{most}"
            );
        }
        let mut none = Tracks::default();
        none.offer(Time { steps: 0, epoch: 0 }, &objects(0, 0.0), 10);
        assert!(none.is_empty() && none.moments().next().is_none());
    }
}
