//! What a run has counted at one moment, as the formulas of metrics want it.

use std::cell::OnceCell;
use std::sync::LazyLock;

use arenas::Reachable;

use crate::bodies::Body;
use crate::world::{COVERAGE_LEVELS, Tally, World};

/// What has been counted in a world. Squares are those within reach.
pub struct Counted<'a> {
    /// The world.
    pub world: &'a World,
    /// Whether each square is within reach.
    pub mask: &'a [bool],
    /// Squares within reach.
    pub reachable: u32,
    /// Of these, the squares that were entered at least 1, 2, 5 and 10 times.
    pub entered: [u32; 4],
    /// Entries in all.
    pub entries: u64,
    /// Sum of n ln n over the squares, n the entries of each.
    pub n_ln_n: f64,
    first_entries: OnceCell<Vec<u64>>,
}

/// Squares that are looked at together: most runs leave most squares alone for long.
const TOGETHER: usize = 16;

impl<'a> Counted<'a> {
    /// Sums up the entries of a world.
    pub fn new(world: &'a World, reachable: &'a Reachable) -> Self {
        let mut counted = Self {
            world,
            mask: &reachable.mask,
            reachable: reachable.count,
            entered: [0; 4],
            entries: 0,
            n_ln_n: 0.0,
            first_entries: OnceCell::new(),
        };
        let known = &N_LN_N[..];
        let visits = world.visit_counts().chunks(TOGETHER);
        for (visits, mask) in visits.zip(reachable.mask.chunks(TOGETHER)) {
            if visits.iter().fold(0, |any, visit| any | visit[0]) == 0 {
                continue;
            }
            for (&[entries, _], _) in visits.iter().zip(mask).filter(|&(_, &inside)| inside) {
                for (squares, least) in counted.entered.iter_mut().zip(COVERAGE_LEVELS) {
                    *squares += u32::from(entries >= least);
                }
                counted.entries += u64::from(entries);
                counted.n_ln_n += match known.get(entries as usize) {
                    Some(known) => *known,
                    None => n_ln_n(entries),
                };
            }
        }
        counted
    }

    /// Times of first entries, and who was seen where.
    pub fn tally(&self) -> &'a Tally {
        &self.world.state().tally
    }

    /// Robot-steps that touched a wall or a robot.
    pub fn collisions(&self) -> u64 {
        self.world.state().collisions
    }

    /// The robots, in order of their numbers.
    pub fn bodies(&self) -> impl Iterator<Item = &'a Body> + use<'a> {
        self.world.state().bodies.iter()
    }

    /// First entries of each robot.
    pub fn first_entries(&self) -> impl Iterator<Item = u32> + use<'a> {
        self.bodies().map(|body| body.first_entries)
    }

    /// Of something that each square has, what those within reach have.
    pub fn inside<I: Iterator>(&self, squares: I) -> impl Iterator<Item = I::Item> + use<'a, I> {
        let squares = squares.zip(self.mask);
        squares.filter_map(|(square, &inside)| inside.then_some(square))
    }

    /// Of each square within reach that was entered 1 + the counted steps before it was.
    pub fn times_of_first_entries(&self) -> &[u64] {
        self.first_entries.get_or_init(|| {
            let all = self.inside(self.tally().first_entry().iter().copied());
            all.filter(|&first| first > 0).collect()
        })
    }
}

/// n ln n for the numbers of entries that most squares have.
static N_LN_N: LazyLock<Vec<f64>> = LazyLock::new(|| (0..4096).map(n_ln_n).collect());

pub(super) fn n_ln_n(n: u32) -> f64 {
    match n {
        0 => 0.0,
        n => f64::from(n) * libm::log(f64::from(n)),
    }
}
