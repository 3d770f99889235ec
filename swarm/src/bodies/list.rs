//! The robots of an arena: reached by their numbers, stored in an order of their own.
//!
//! Robots that are near each other are stored near each other, so that what is needed together
//! comes from the cache. Where a robot is stored (its slot) is scratch: it is never saved, and no
//! result depends on it.

use std::ops::Index;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::body::Body;

/// Robots by number; saved as the list of bodies in the order of their numbers.
#[derive(Clone, Debug)]
pub struct Bodies {
    /// By slot.
    stored: Vec<Body>,
    /// The number of the robot in each slot.
    numbers: Vec<u32>,
    /// The slot of the robot of each number.
    slots: Vec<u32>,
}

impl From<Vec<Body>> for Bodies {
    fn from(stored: Vec<Body>) -> Self {
        let numbers: Vec<u32> = (0..stored.len() as u32).collect();
        Self {
            slots: numbers.clone(),
            numbers,
            stored,
        }
    }
}

impl Bodies {
    /// Robots.
    pub fn len(&self) -> usize {
        self.stored.len()
    }

    /// Whether there is no robot.
    pub fn is_empty(&self) -> bool {
        self.stored.is_empty()
    }

    /// The robots in the order of their numbers.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Body> + DoubleEndedIterator {
        self.slots.iter().map(|&slot| &self.stored[slot as usize])
    }

    /// The robot of a number, to be changed.
    pub(crate) fn get_mut(&mut self, number: usize) -> &mut Body {
        &mut self.stored[self.slots[number] as usize]
    }

    /// The robots in the order in which they are stored.
    #[inline(always)]
    pub(crate) fn stored(&self) -> &[Body] {
        &self.stored
    }

    /// The robots in the order in which they are stored, and the number of each.
    #[inline(always)]
    pub(crate) fn stored_mut(&mut self) -> (&mut [Body], &[u32]) {
        (&mut self.stored, &self.numbers)
    }

    /// The slot of the robot of each number.
    pub(crate) fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// Exchanges what two slots hold; [`Bodies::renumber`] has to follow.
    pub(crate) fn swap(&mut self, a: usize, b: usize) {
        self.stored.swap(a, b);
        self.numbers.swap(a, b);
    }

    /// Notes where each robot is stored now.
    pub(crate) fn renumber(&mut self) {
        for (slot, &number) in self.numbers.iter().enumerate() {
            self.slots[number as usize] = slot as u32;
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.stored[..])
            + size_of_val(&self.numbers[..])
            + size_of_val(&self.slots[..])
    }
}

impl Index<usize> for Bodies {
    type Output = Body;

    #[inline(always)]
    fn index(&self, number: usize) -> &Body {
        &self.stored[self.slots[number] as usize]
    }
}

impl Serialize for Bodies {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

impl<'de> Deserialize<'de> for Bodies {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self::from)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::bodies::StartPose;

    fn bodies(robots: usize) -> Vec<Body> {
        let body = |robot| {
            Body::at_rest(&StartPose {
                x_m: robot as f32,
                y_m: 0.0,
                cos: 1.0,
                sin: 0.0,
            })
        };
        (0..robots).map(body).collect()
    }

    #[test]
    fn where_robots_are_stored_shows_nowhere() {
        let plain = bodies(9);
        let mut moved = Bodies::from(plain.clone());
        for (a, b) in [(0, 5), (5, 7), (2, 8), (3, 3)] {
            moved.swap(a, b);
        }
        moved.renumber();
        assert!(moved.stored() != &plain[..]);
        assert!(moved.iter().eq(&plain));
        for (number, body) in plain.iter().enumerate() {
            assert_eq!(moved[number], *body);
            assert_eq!(moved.get_mut(number), body);
        }
        let (stored, numbers) = moved.stored_mut();
        for (body, &number) in stored.iter().zip(numbers) {
            assert_eq!(*body, plain[number as usize]);
        }
        let saved = postcard::to_stdvec(&moved).unwrap();
        assert_eq!(saved, postcard::to_stdvec(&plain).unwrap());
        let back: Bodies = postcard::from_bytes(&saved).unwrap();
        assert_eq!(back.numbers, (0..9).collect::<Vec<u32>>());
        assert_eq!(postcard::to_stdvec(&back).unwrap(), saved);
    }
}
