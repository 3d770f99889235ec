//! Disjoint sets of numbers (union and find).

/// Numbers from 0, each in one set; a set goes by its least number.
#[derive(Debug, Default)]
pub(crate) struct Sets(Vec<u32>);

impl Sets {
    /// As many numbers as there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The next number, in a set of its own.
    pub fn add(&mut self) -> u32 {
        let number = self.0.len() as u32;
        self.0.push(number);
        number
    }

    /// So many numbers, each in a set of its own.
    pub fn reset(&mut self, count: usize) {
        self.0.clear();
        self.0.extend(0..count as u32);
    }

    /// The set of a number.
    pub fn find(&mut self, mut number: u32) -> u32 {
        while self.0[number as usize] != number {
            let above = self.0[self.0[number as usize] as usize];
            self.0[number as usize] = above;
            number = above;
        }
        number
    }

    /// Makes one set of the sets of two numbers.
    pub fn unite(&mut self, one: u32, other: u32) {
        let (one, other) = (self.find(one), self.find(other));
        self.0[one.max(other) as usize] = one.min(other);
    }
}
