//! Pairs of walls that come near each other, found by a sweep along the longer side of the arena.

use std::ops::ControlFlow;

use crate::segment::Segment;

/// Work after which the search ends, in comparisons of two walls' extents: about a second. Walls
/// that stand so dense leave a body no room.
const MOST_WORK: u64 = 200_000_000;
/// A shortest way costs as much as this many comparisons.
const WORK_OF_A_WAY: u64 = 16;

/// Calls `found` with the shortest way between each two walls that are less than `within_m` apart,
/// until it breaks.
pub(crate) fn near_pairs(
    walls: &[Segment],
    within_m: f64,
    mut found: impl FnMut([usize; 2], Segment) -> ControlFlow<()>,
) {
    let extent = |wall: &Segment, axis: usize| {
        let (one, other) = (wall.a[axis], wall.b[axis]);
        [one.min(other), one.max(other)]
    };
    let length_of = |axis: usize| {
        walls
            .iter()
            .map(|wall| extent(wall, axis)[1])
            .fold(0.0, f64::max)
    };
    let along = usize::from(length_of(1) > length_of(0));
    // Extents along and across the sweep, and the wall.
    let mut order: Vec<([f64; 2], [f64; 2], usize)> = walls
        .iter()
        .enumerate()
        .map(|(number, wall)| (extent(wall, along), extent(wall, 1 - along), number))
        .collect();
    order.sort_by(|one, other| one.0[0].total_cmp(&other.0[0]).then(one.2.cmp(&other.2)));
    let mut work = 0;
    for (place, &(along, across, one)) in order.iter().enumerate() {
        for &(other_along, other_across, other) in &order[place + 1..] {
            if other_along[0] >= along[1] + within_m {
                break;
            }
            work += 1;
            if other_across[0] >= across[1] + within_m || across[0] >= other_across[1] + within_m {
                continue;
            }
            work += WORK_OF_A_WAY;
            let way = walls[one].shortest_way_to(&walls[other]);
            if way.length_m() < within_m && found([one, other], way).is_break() {
                return;
            }
        }
        if work > MOST_WORK {
            return;
        }
    }
}
