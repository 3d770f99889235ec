//! The grid that finds a robot's neighbours: robots sorted into cells at least as wide as they see.

use arenas::axis::GridAxis;
use rayon::prelude::*;

use super::near::{CHUNK, NearChunk, Pair};

/// Where a robot's centre is, metres.
pub type Place = [f32; 2];

/// A robot in a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    x_m: f32,
    y_m: f32,
    slot: u32,
}

/// Robots in sight for which there is room: of as many or more, all are gone through again. A power
/// of two.
pub const MOST_SEEN: usize = 128;

/// Centres of robots in sight.
pub type Seen = [[f32; 2]; MOST_SEEN];

/// Scratch of an arena with several robots; can be rebuilt from positions at any time. Robots are
/// known by their slots, the places in which their bodies are stored.
#[derive(Clone, Debug)]
pub struct Cells {
    across: GridAxis,
    up: GridAxis,
    columns: usize,
    rows: usize,
    /// Start of each cell in `sorted`, one more than there are cells.
    starts: Vec<u32>,
    /// By slot.
    cell_of: Vec<u32>,
    /// Robots by cell, then by slot.
    sorted: Vec<Entry>,
    candidate_m2: f32,
    sight_m2: f32,
    /// First and last cell of each chunk's robots; only while several threads sort.
    spans: Vec<[u32; 2]>,
    /// Robots in each strip of cells; only while several threads sort.
    totals: Vec<u32>,
}

impl Cells {
    /// Cells for robots that see each other up to `sight_m` and may touch within a step up to
    /// `candidate_m` between centres.
    pub fn new(
        robots: usize,
        (width_m, height_m): (f64, f64),
        sight_m: f64,
        candidate_m: f32,
    ) -> Self {
        let spread_m = (width_m * height_m / robots.max(64) as f64).sqrt();
        let cell_m = sight_m.max(f64::from(candidate_m)).max(spread_m * 0.5) * 1.000_1;
        let columns = (width_m / cell_m).ceil().max(1.0) as usize;
        let rows = (height_m / cell_m).ceil().max(1.0) as usize;
        let cells_per_m = (1.0 / cell_m) as f32;
        Self {
            across: GridAxis::new(columns, cells_per_m),
            up: GridAxis::new(rows, cells_per_m),
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            cell_of: vec![0; robots],
            sorted: vec![Entry::default(); robots],
            candidate_m2: candidate_m * candidate_m,
            sight_m2: (sight_m * sight_m) as f32,
            spans: Vec::new(),
            totals: Vec::new(),
        }
    }

    /// The cell of a place.
    #[inline(always)]
    fn cell(&self, [x_m, y_m]: Place) -> u32 {
        (self.up.cell(y_m) * self.columns + self.across.cell(x_m)) as u32
    }

    /// Sorts robots into cells.
    #[inline(always)]
    pub fn sort(&mut self, places: &[Place]) {
        self.starts.fill(0);
        for (slot, &place) in places.iter().enumerate() {
            let cell = self.cell(place);
            self.cell_of[slot] = cell;
            self.starts[cell as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        // From the last robot to the first, so that slots rise within a cell.
        for (slot, &place) in places.iter().enumerate().rev() {
            let start = &mut self.starts[self.cell_of[slot] as usize];
            *start -= 1;
            self.sorted[*start as usize] = Entry::of(slot, place);
        }
    }

    /// The same on the threads of the present pool: each counts and fills a strip of cells, from the
    /// chunks of robots that have any in it.
    pub fn sort_in_strips(&mut self, places: &[Place]) {
        let cells = self.starts.len() - 1;
        let wide = cells.div_ceil(rayon::current_num_threads());
        let mut spans = std::mem::take(&mut self.spans);
        let mut cell_of = std::mem::take(&mut self.cell_of);
        spans.resize(places.len().div_ceil(CHUNK), [0; 2]);
        self.totals.resize(cells.div_ceil(wide), 0);
        let this = &*self;
        cell_of
            .par_chunks_mut(CHUNK)
            .zip(&mut spans)
            .zip(places.par_chunks(CHUNK))
            .with_min_len(8)
            .for_each(|((cell_of, span), places)| {
                *span = [u32::MAX, 0];
                for (cell_of, &place) in cell_of.iter_mut().zip(places) {
                    let cell = this.cell(place);
                    *cell_of = cell;
                    *span = [span[0].min(cell), span[1].max(cell)];
                }
            });
        (self.spans, self.cell_of) = (spans, cell_of);
        let located = Located {
            places,
            cell_of: &self.cell_of,
            spans: &self.spans,
        };
        let (starts, end) = self.starts.split_at_mut(cells);
        end[0] = places.len() as u32;
        starts
            .par_chunks_mut(wide)
            .zip(&mut self.totals)
            .enumerate()
            .with_max_len(1)
            .for_each(|(strip, (starts, total))| {
                *total = located.count(strip * wide, starts);
            });
        located.fill_strips(&self.totals, 0, wide, starts, &mut self.sorted, 0);
    }

    /// Gives robots the slots in whose order they are sorted; `swap` exchanges what two slots hold.
    pub fn settle(&mut self, mut swap: impl FnMut(usize, usize)) {
        // Cycle by cycle of the permutation; a slot that has its robot is entered as its own.
        for first in 0..self.sorted.len() {
            let mut to = first;
            loop {
                let from = self.sorted[to].slot as usize;
                self.sorted[to].slot = to as u32;
                if from == first {
                    break;
                }
                swap(to, from);
                self.cell_of.swap(to, from);
                to = from;
            }
        }
    }

    /// Notes the robots in sight of a robot and says how many they are: from [`MOST_SEEN`] on not all
    /// are noted. Notes contact candidates for the next step; the slots of a chunk
    /// have to be asked in their order. `numbers` are the robots' numbers by slot.
    #[inline(always)]
    pub fn look_around(
        &self,
        slot: usize,
        (x_m, y_m): (f32, f32),
        numbers: &[u32],
        chunk: &mut NearChunk,
        seen: &mut Seen,
    ) -> usize {
        let begin = chunk.ends[slot % CHUNK] as usize;
        let pairs = &mut chunk.pairs[begin..];
        let (mut near_count, mut seen_count) = (0, 0);
        for run in self.runs(x_m, y_m) {
            for entry in &self.sorted[run] {
                let (dx, dy) = (entry.x_m - x_m, entry.y_m - y_m);
                let d2 = dx * dx + dy * dy;
                // Nobody can foresee who is near: all are noted, and those who are not, overwritten.
                let in_sight = (d2 < self.sight_m2) & (entry.slot as usize != slot);
                seen[seen_count % MOST_SEEN] = [entry.x_m, entry.y_m];
                seen_count += usize::from(in_sight);
                pairs[near_count] = Pair::new(slot, entry.slot);
                near_count += usize::from(in_sight & (d2 < self.candidate_m2));
                near_count = near_count.min(chunk.most);
            }
        }
        let near = &mut pairs[..near_count];
        // Sums of pushes must not depend on slots.
        let key = |pair: Pair| {
            let other = pair.other() as usize;
            (self.cell_of[other], numbers[other])
        };
        for sorted in 1..near_count {
            let mut at = sorted;
            while at > 0 && key(near[at]) < key(near[at - 1]) {
                near.swap(at, at - 1);
                at -= 1;
            }
        }
        chunk.ends[slot % CHUNK + 1] = (begin + near_count) as u32;
        seen_count
    }

    /// Centres of all robots in sight of a robot, where they are too many to be noted.
    #[cold]
    #[inline(never)]
    pub fn each_in_sight(
        &self,
        slot: usize,
        (x_m, y_m): (f32, f32),
        see: &mut dyn FnMut(f32, f32),
    ) {
        for run in self.runs(x_m, y_m) {
            for entry in &self.sorted[run] {
                let (dx, dy) = (entry.x_m - x_m, entry.y_m - y_m);
                if dx * dx + dy * dy < self.sight_m2 && entry.slot as usize != slot {
                    see(entry.x_m, entry.y_m);
                }
            }
        }
    }

    /// The robots of the cell of a place and of those around it, row by row.
    #[inline(always)]
    fn runs(&self, x_m: f32, y_m: f32) -> impl Iterator<Item = std::ops::Range<usize>> {
        let (column, row) = (self.across.cell(x_m), self.up.cell(y_m));
        let (first, last) = (column.saturating_sub(1), (column + 1).min(self.columns - 1));
        let columns = self.columns;
        (row.saturating_sub(1)..=(row + 1).min(self.rows - 1)).map(move |row| {
            let begin = self.starts[row * columns + first] as usize;
            let end = self.starts[row * columns + last + 1] as usize;
            begin..end
        })
    }

    /// Bytes set aside on one thread.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..])
            + size_of_val(&self.cell_of[..])
            + size_of_val(&self.sorted[..])
    }
}

impl Entry {
    #[inline(always)]
    fn of(slot: usize, [x_m, y_m]: Place) -> Self {
        Self {
            x_m,
            y_m,
            slot: slot as u32,
        }
    }
}

/// Robots with their cells, for threads that sort a strip each.
#[derive(Clone, Copy)]
struct Located<'a> {
    places: &'a [Place],
    cell_of: &'a [u32],
    spans: &'a [[u32; 2]],
}

impl Located<'_> {
    /// First slots of the chunks with robots in so many cells from `first` on, in order.
    fn chunks(&self, first: usize, cells: usize) -> impl DoubleEndedIterator<Item = usize> {
        let here =
            move |span: &[u32; 2]| (span[0] as usize) < first + cells && span[1] as usize >= first;
        let chunks = self.spans.iter().enumerate();
        chunks.filter_map(move |(chunk, span)| here(span).then_some(chunk * CHUNK))
    }

    /// Notes the end of each cell of a strip, from the strip's begin on; gives the strip's robots.
    fn count(&self, first: usize, ends: &mut [u32]) -> u32 {
        ends.fill(0);
        for slot in self.chunks(first, ends.len()) {
            for &cell in self.cell_of[slot..].iter().take(CHUNK) {
                if let Some(end) = ends.get_mut((cell as usize).wrapping_sub(first)) {
                    *end += 1;
                }
            }
        }
        let mut sum = 0;
        for end in ends {
            sum += *end;
            *end = sum;
        }
        sum
    }

    /// Puts robots into the strips, of `wide` cells from `first` on, whose robots `totals` counts;
    /// `before` robots are in cells before them.
    fn fill_strips(
        &self,
        totals: &[u32],
        first: usize,
        wide: usize,
        starts: &mut [u32],
        sorted: &mut [Entry],
        before: u32,
    ) {
        if totals.len() <= 1 {
            self.fill(first, starts, sorted, before);
            return;
        }
        let (left, right) = totals.split_at(totals.len() / 2);
        let cells = left.len() * wide;
        let robots: u32 = left.iter().sum();
        let (left_starts, right_starts) = starts.split_at_mut(cells);
        let (left_sorted, right_sorted) = sorted.split_at_mut(robots as usize);
        rayon::join(
            || self.fill_strips(left, first, wide, left_starts, left_sorted, before),
            || {
                let (first, before) = (first + cells, before + robots);
                self.fill_strips(right, first, wide, right_starts, right_sorted, before);
            },
        );
    }

    /// Puts the robots of a strip into their places; its ends become starts.
    fn fill(&self, first: usize, starts: &mut [u32], sorted: &mut [Entry], before: u32) {
        for slot in self.chunks(first, starts.len()).rev() {
            let places = self.places[slot..].iter().take(CHUNK);
            for (later, &place) in places.enumerate().rev() {
                let cell = self.cell_of[slot + later] as usize;
                if let Some(start) = starts.get_mut(cell.wrapping_sub(first)) {
                    *start -= 1;
                    sorted[*start as usize] = Entry::of(slot + later, place);
                }
            }
        }
        starts.iter_mut().for_each(|start| *start += before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn places(robots: usize, side_m: f64) -> Vec<Place> {
        let mut stream = Stream::new(robots as u64);
        let mut at_m = || (side_m * stream.uniform()) as f32;
        (0..robots).map(|_| [at_m(), at_m()]).collect()
    }

    #[test]
    fn strips_are_sorted_as_the_whole() {
        for (robots, side_m) in [(2, 0.3), (700, 5.0), (700, 0.3), (5_000, 20.0)] {
            let places = places(robots, side_m);
            let mut whole = Cells::new(robots, (side_m, side_m), 0.1, 0.1);
            whole.sort(&places);
            for threads in [1, 2, 3, 7] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let mut strips = Cells::new(robots, (side_m, side_m), 0.1, 0.1);
                #[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
                let pool = pool.build().unwrap();
                // Twice: scratch of the first time must not show.
                pool.install(|| strips.sort_in_strips(&places));
                pool.install(|| strips.sort_in_strips(&places));
                assert_eq!(strips.starts, whole.starts, "{robots} {threads}");
                assert_eq!(strips.cell_of, whole.cell_of);
                let slots = |cells: &Cells| cells.sorted.iter().map(|e| e.slot).collect::<Vec<_>>();
                assert_eq!(slots(&strips), slots(&whole));
            }
        }
    }

    #[test]
    fn a_robot_among_too_many_to_note_sees_them_all() {
        let robots = 3 * MOST_SEEN;
        let places = places(robots, 0.05);
        let mut cells = Cells::new(robots, (0.05, 0.05), 0.1, 0.01);
        cells.sort(&places);
        let mut near = super::super::near::Near::new(robots, 0.01, 0.01);
        let numbers: Vec<u32> = (0..robots as u32).collect();
        let mut seen = [[0.0; 2]; MOST_SEEN];
        #[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
        let mut chunk = near.chunks_mut().next().unwrap();
        let place = (places[0][0], places[0][1]);
        let noted = cells.look_around(0, place, &numbers, &mut chunk, &mut seen);
        assert_eq!(noted, robots - 1);
        let mut all = 0;
        cells.each_in_sight(0, place, &mut |_, _| all += 1);
        assert_eq!(all, robots - 1);
    }
}
