//! The genomes of phase 1 that phase 2 replays.

use serde::{Deserialize, Serialize};

use super::are_sound;
use super::perceptron::WEIGHTS;

/// Genomes that memory is taken for at once.
const CHUNK: usize = 32;

/// At most `cap` genomes: every one told, while there is room, then the fittest (chapter 4 of the
/// thesis replays the best controllers, chapter 5 all of them).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Archive {
    cap: u32,
    /// [`WEIGHTS`] weights a genome.
    genomes: Vec<f32>,
    fitness: Vec<f64>,
}

impl Archive {
    /// An empty archive; `cap` at least one. It takes memory for `CHUNK` genomes at a time, so
    /// that a long phase 1 does not take all of it beforehand.
    pub fn new(cap: u32) -> Self {
        Self {
            cap: cap.max(1),
            genomes: Vec::new(),
            fitness: Vec::new(),
        }
    }

    /// Takes in an evaluated genome; when there is no room, in place of the least fit (the earliest
    /// of equals), if it is fitter.
    ///
    /// # Panics
    /// When the genome is not of [`WEIGHTS`] weights.
    pub fn offer(&mut self, genome: &[f32], fitness: f64) {
        assert_eq!(genome.len(), WEIGHTS, "weights of a perceptron");
        if self.fitness.len() < self.cap as usize {
            let room = self.room_for(self.fitness.len() + 1) - self.fitness.len();
            self.genomes.reserve_exact(room * WEIGHTS);
            self.fitness.reserve_exact(room);
            self.genomes.extend_from_slice(genome);
            self.fitness.push(fitness);
            return;
        }
        let mut least = 0;
        for (place, held) in self.fitness.iter().enumerate() {
            if *held < self.fitness[least] {
                least = place;
            }
        }
        if fitness > self.fitness[least] {
            self.fitness[least] = fitness;
            self.genomes[least * WEIGHTS..][..WEIGHTS].copy_from_slice(genome);
        }
    }

    /// Whether saved parts fit together, in an archive of at most `cap`.
    pub fn is_sound(&self, cap: u32) -> bool {
        self.cap == cap.max(1)
            && self.fitness.len() <= self.cap as usize
            && self.genomes.len() == self.fitness.len() * WEIGHTS
            && are_sound(&self.genomes)
    }

    /// Genomes that memory is taken for when so many are held.
    fn room_for(&self, held: usize) -> usize {
        held.next_multiple_of(CHUNK).min(self.cap as usize)
    }

    /// A genome, by its place.
    pub fn genome(&self, place: u32) -> Option<&[f32]> {
        self.genomes
            .get(place as usize * WEIGHTS..)
            .and_then(|rest| rest.get(..WEIGHTS))
    }

    /// Most bytes held besides the value itself, with room for `cap` genomes.
    pub fn heap_bytes_for(cap: u32) -> u64 {
        let genome = WEIGHTS * size_of::<f32>() + size_of::<f64>();
        u64::from(cap.max(1)) * genome as u64
    }

    /// Bytes held besides the value itself, exactly counted.
    pub fn heap_bytes(&self) -> u64 {
        match self.room_for(self.fitness.len()) as u32 {
            0 => 0,
            room => Self::heap_bytes_for(room),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn held(archive: &Archive) -> Vec<f32> {
        (0..archive.cap)
            .map_while(|place| archive.genome(place))
            .map(|genome| genome[0])
            .collect()
    }

    #[test]
    fn takes_memory_as_it_fills() {
        let mut archive = Archive::new(1_000_000);
        assert_eq!(archive.heap_bytes(), 0);
        for n in 1..=100 {
            archive.offer(&[0.0; WEIGHTS], f64::from(n));
            let held = archive.genomes.capacity() * 4 + archive.fitness.capacity() * 8;
            assert_eq!(archive.heap_bytes(), held as u64);
            assert!(held <= (n as usize + CHUNK) * (WEIGHTS * 4 + 8));
        }
    }

    #[test]
    fn keeps_everything_while_there_is_room_then_the_fittest() {
        let mut archive = Archive::new(3);
        for (weight, fitness, want) in [
            (1.0, 0.5, vec![1.0]),
            (2.0, 0.1, vec![1.0, 2.0]),
            (3.0, 0.1, vec![1.0, 2.0, 3.0]),
            (4.0, 0.1, vec![1.0, 2.0, 3.0]),
            (5.0, 0.2, vec![1.0, 5.0, 3.0]),
            (6.0, 0.9, vec![1.0, 5.0, 6.0]),
        ] {
            archive.offer(&[weight; WEIGHTS], fitness);
            assert_eq!(held(&archive), want);
        }
        assert!(archive.genome(3).is_none());
    }
}
