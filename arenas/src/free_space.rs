//! Where the centre of a disc can be, and what of that hangs together: decided by geometry along
//! lines across the arena and exactly between them, so no passage depends on where the lines lie.
//!
//! A wall keeps the centre out of all that is nearer than the radius, a *zone*. Zones are convex:
//! each line meets one in at most one interval. What the zones leave of a line are its *gaps*.
//! Between two neighbouring lines, two gaps hang together unless zones that overlap there stand
//! between them. Two zones overlap between the lines if they do on one of the lines; or else if
//! all they have in common lies between the lines, and then the middle of the shortest way between
//! the walls does. So the intervals, and the near pairs of walls, say everything.

use std::ops::{ControlFlow, Range};

use nalgebra::{Point2, Vector2};

use crate::arena::Arena;
use crate::near_pairs::near_pairs;
use crate::segment::Segment;
use crate::sets::Sets;

/// A passage this much narrower than the body still counts as open, metres, so that rounded
/// decimals do not close it: a gate exactly as wide as the body is open.
pub(crate) const TOLERANCE_M: f64 = 2e-9;

/// What of a line the centre can be on, from one x to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gap {
    pub from_m: f64,
    pub to_m: f64,
}

/// The gaps of some lines, and which hang together.
#[derive(Debug)]
pub(crate) struct FreeSpace {
    zones: Vec<Zone>,
    radius_m: f64,
    lines: Vec<Line>,
    gaps: Vec<Between>,
    sets: Sets,
}

/// A gap as the zones that it lies between: there are many, and zones know where they meet a line.
#[derive(Clone, Copy, Debug)]
struct Between {
    before: u32,
    after: u32,
}

#[derive(Debug)]
struct Line {
    y_m: f64,
    gaps: Range<usize>,
}

/// A wall as its zone: offsets to both sides, and how far up and down it reaches.
#[derive(Debug)]
struct Zone {
    wall: Segment,
    offset: Vector2<f64>,
    low_m: f64,
    high_m: f64,
}

/// An interval of a line inside a zone.
#[derive(Clone, Copy)]
struct Crossing {
    from_m: f64,
    to_m: f64,
    zone: u32,
}

impl Zone {
    fn new(wall: Segment, radius_m: f64) -> Self {
        let along = wall.b - wall.a;
        let across = Vector2::new(-along.y, along.x) / along.norm();
        Self {
            wall,
            offset: across * radius_m,
            low_m: wall.a.y.min(wall.b.y) - radius_m,
            high_m: wall.a.y.max(wall.b.y) + radius_m,
        }
    }

    /// What of the line at `y_m` is inside.
    fn crossing(&self, y_m: f64, radius_m: f64) -> Option<[f64; 2]> {
        let (mut from_m, mut to_m) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut meet = |low_m: f64, high_m: f64| {
            from_m = from_m.min(low_m);
            to_m = to_m.max(high_m);
        };
        for end in [self.wall.a, self.wall.b] {
            let dy_m = (y_m - end.y).abs();
            if dy_m < radius_m {
                let half_m = ((radius_m - dy_m) * (radius_m + dy_m)).sqrt();
                meet(end.x - half_m, end.x + half_m);
            }
        }
        for offset in [self.offset, -self.offset] {
            let (a, b) = (self.wall.a + offset, self.wall.b + offset);
            let part = (y_m - a.y) / (b.y - a.y);
            if (0.0..=1.0).contains(&part) {
                let x_m = a.x + (b.x - a.x) * part;
                meet(x_m, x_m);
            }
        }
        (from_m < to_m).then_some([from_m, to_m])
    }
}

impl FreeSpace {
    /// The free space of a disc on the lines at `y_m`, in rising order, 0 and the height among them.
    /// `None` if the disc does not fit into the arena.
    pub fn new(arena: &Arena, radius_m: f64, y_m: impl Iterator<Item = f64>) -> Option<Self> {
        let fits_m = 0.5 * arena.width_m().min(arena.height_m());
        if !(0.0..=fits_m).contains(&radius_m) {
            return None;
        }
        // Even a point does not pass through a wall.
        let radius_m = (radius_m - 0.5 * TOLERANCE_M).max(0.5 * TOLERANCE_M);
        let walls: Vec<Segment> = arena
            .boundary()
            .iter()
            .chain(arena.walls())
            .copied()
            .collect();
        let zones: Vec<Zone> = walls
            .iter()
            .map(|wall| Zone::new(*wall, radius_m))
            .collect();
        let y_m: Vec<f64> = y_m.collect();
        let widest_m = y_m.windows(2).map(|pair| pair[1] - pair[0]);
        let widest_m = widest_m.fold(0.0, f64::max);
        let mut space = Self {
            zones: Vec::new(),
            radius_m,
            lines: Vec::with_capacity(y_m.len()),
            gaps: Vec::new(),
            sets: Sets::default(),
        };
        let mut sweep = Sweep::new(&zones, radius_m);
        let meetings = meetings(&walls, radius_m, widest_m);
        let mut meetings = &meetings[..];
        for &y_m in &y_m {
            let before = meetings.partition_point(|meeting| meeting.y_m < y_m);
            let between;
            (between, meetings) = meetings.split_at(before);
            sweep.advance(y_m, between, &mut space);
        }
        space.zones = zones;
        Some(space)
    }

    /// From where to where a zone that bounds a gap of the line at `y_m` meets it.
    fn meets(&self, y_m: f64, zone: u32) -> [f64; 2] {
        let crossing = self.zones[zone as usize].crossing(y_m, self.radius_m);
        crossing.unwrap_or([f64::NAN; 2])
    }

    /// Where a line lies.
    pub fn y_m(&self, line: usize) -> f64 {
        self.lines[line].y_m
    }

    /// The gap of the line nearest to a point, on which the point lies.
    pub fn gap_at(&self, point: Point2<f64>) -> Option<usize> {
        let above = self.lines.partition_point(|line| line.y_m < point.y);
        let below = above.saturating_sub(1);
        let away_m = |line: usize| (self.lines[line].y_m - point.y).abs();
        let line = if above < self.lines.len() && away_m(above) <= away_m(below) {
            above
        } else {
            below
        };
        let Line { y_m, gaps } = self.lines.get(line)?;
        let first = gaps.start;
        let gaps = &self.gaps[gaps.clone()];
        let is_before = |gap: &Between| self.meets(*y_m, gap.after)[0] + TOLERANCE_M < point.x;
        let next = gaps.partition_point(is_before);
        let [_, from_m] = self.meets(*y_m, gaps.get(next)?.before);
        (from_m - TOLERANCE_M <= point.x).then_some(first + next)
    }

    /// Of each gap, whether it hangs together with one that a start is on.
    pub fn reached_from(&mut self, starts: impl Iterator<Item = Point2<f64>>) -> Vec<bool> {
        let mut reached = vec![false; self.gaps.len()];
        for start in starts {
            if let Some(gap) = self.gap_at(start) {
                reached[self.sets.find(gap as u32) as usize] = true;
            }
        }
        // A set goes by its least number, which comes before the others.
        for gap in 0..reached.len() {
            reached[gap] = reached[self.sets.find(gap as u32) as usize];
        }
        reached
    }

    /// Forgets what hangs together, once nobody asks for it any more.
    pub fn forget_sets(&mut self) {
        self.sets = Sets::default();
    }

    /// Those gaps of a line that are reached.
    pub fn reached_on(&self, line: usize, reached: &[bool]) -> impl Iterator<Item = Gap> {
        let Line { y_m, gaps } = &self.lines[line];
        gaps.clone().filter(|&gap| reached[gap]).map(|gap| Gap {
            from_m: self.meets(*y_m, self.gaps[gap].before)[1],
            to_m: self.meets(*y_m, self.gaps[gap].after)[0],
        })
    }
}

/// The middle of the shortest way between two walls whose zones overlap.
struct Meeting {
    y_m: f64,
    zones: [u32; 2],
}

/// Meetings of zones that may have nothing in common on any line: around the middle of their
/// walls' shortest way there is a disc inside both, which must fit between two lines.
fn meetings(walls: &[Segment], radius_m: f64, widest_m: f64) -> Vec<Meeting> {
    let mut meetings = Vec::new();
    near_pairs(walls, 2.0 * radius_m, |pair, way| {
        if 2.0 * radius_m - way.length_m() <= widest_m {
            meetings.push(Meeting {
                y_m: 0.5 * (way.a.y + way.b.y),
                zones: pair.map(|wall| wall as u32),
            });
        }
        ControlFlow::Continue(())
    });
    meetings.sort_by(|one, other| {
        one.y_m
            .total_cmp(&other.y_m)
            .then(one.zones.cmp(&other.zones))
    });
    meetings
}

/// Blocks of overlapping intervals of a line, from the left.
#[derive(Default)]
struct Blocks {
    count: usize,
    /// Zone and block of each interval.
    members: Vec<(u32, u32)>,
    first_gap: usize,
}

/// Goes through the lines from the lowest.
struct Sweep<'a> {
    zones: &'a [Zone],
    radius_m: f64,
    /// Zones by their lowest point; those before `next` have begun.
    order: Vec<u32>,
    next: usize,
    active: Vec<Crossing>,
    below: Blocks,
    here: Blocks,
    /// Node of each zone in the strip below the current line; `NONE` between strips.
    node: Vec<u32>,
    /// What hangs together in the strip: blocks below, blocks here, zones between.
    nodes: Sets,
    last: Vec<u32>,
    first: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl<'a> Sweep<'a> {
    fn new(zones: &'a [Zone], radius_m: f64) -> Self {
        let mut order: Vec<u32> = (0..zones.len() as u32).collect();
        let low_m = |zone: u32| zones[zone as usize].low_m;
        order.sort_by(|&one, &other| low_m(one).total_cmp(&low_m(other)).then(one.cmp(&other)));
        Self {
            zones,
            radius_m,
            order,
            next: 0,
            active: Vec::new(),
            below: Blocks::default(),
            here: Blocks::default(),
            node: vec![NONE; zones.len()],
            nodes: Sets::default(),
            last: Vec::new(),
            first: Vec::new(),
        }
    }

    /// Takes the next line: adds its gaps and joins them with those of the line before.
    fn advance(&mut self, y_m: f64, meetings: &[Meeting], space: &mut FreeSpace) {
        std::mem::swap(&mut self.below, &mut self.here);
        self.cross(y_m);
        self.here.first_gap = space.gaps.len();
        self.here.members.clear();
        self.here.count = 0;
        let (mut to_m, mut last) = (f64::NEG_INFINITY, NONE);
        for crossing in &self.active {
            if crossing.from_m == f64::INFINITY {
                break;
            }
            if crossing.from_m >= to_m {
                if self.here.count > 0 {
                    space.gaps.push(Between {
                        before: last,
                        after: crossing.zone,
                    });
                    space.sets.add();
                }
                self.here.count += 1;
            }
            if crossing.to_m > to_m {
                (to_m, last) = (crossing.to_m, crossing.zone);
            }
            let block = self.here.count as u32 - 1;
            self.here.members.push((crossing.zone, block));
        }
        space.lines.push(Line {
            y_m,
            gaps: self.here.first_gap..space.gaps.len(),
        });
        if space.lines.len() > 1 {
            self.join(meetings, &mut space.sets);
        }
    }

    /// Leaves the zones that begin below and end above `y_m` in `active`, in the order in which the
    /// line meets them.
    fn cross(&mut self, y_m: f64) {
        while let Some(&zone) = self.order.get(self.next)
            && self.zones[zone as usize].low_m < y_m
        {
            self.active.push(Crossing {
                from_m: 0.0,
                to_m: 0.0,
                zone,
            });
            self.next += 1;
        }
        let (zones, radius_m) = (self.zones, self.radius_m);
        self.active.retain_mut(|crossing| {
            let zone = &zones[crossing.zone as usize];
            // One that the line does not meet is sorted to the end.
            [crossing.from_m, crossing.to_m] = zone
                .crossing(y_m, radius_m)
                .unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            y_m < zone.high_m
        });
        // From one line to the next they hardly change places, which a merge sort makes use of.
        self.active.sort_by(|one, other| {
            one.from_m
                .total_cmp(&other.from_m)
                .then(one.zone.cmp(&other.zone))
        });
    }

    /// Joins the gaps of the line below with those of this one.
    fn join(&mut self, meetings: &[Meeting], gaps: &mut Sets) {
        let below = self.below.count as u32;
        self.nodes.reset(self.below.count + self.here.count);
        for &(zone, block) in &self.below.members {
            self.node[zone as usize] = block;
        }
        for &(zone, block) in &self.here.members {
            match self.node[zone as usize] {
                NONE => self.node[zone as usize] = below + block,
                node => self.nodes.unite(node, below + block),
            }
        }
        for meeting in meetings {
            let [one, other] = meeting.zones.map(|zone| {
                let node = &mut self.node[zone as usize];
                if *node == NONE {
                    *node = self.nodes.add();
                }
                *node
            });
            self.nodes.unite(one, other);
        }
        self.walk_around(gaps);
        let members = self.below.members.iter().chain(&self.here.members);
        for &(zone, _) in members {
            self.node[zone as usize] = NONE;
        }
        for zone in meetings.iter().flat_map(|meeting| meeting.zones) {
            self.node[zone as usize] = NONE;
        }
    }

    /// Walks around the strip, along the lower line to the right and back along the upper one.
    /// Blocks that hang together part the gaps between one of them and the next one on the way from
    /// all others; of those gaps the first and the last lie along the same side of the blocks.
    fn walk_around(&mut self, gaps: &mut Sets) {
        let (below, here) = (self.below.count, self.here.count);
        let steps = below + here;
        // The gap after each block on the way; none at the two ends, where the outer walls stand.
        let gap_after = |step: usize| {
            if step < below {
                (step + 1 < below).then_some(self.below.first_gap + step)
            } else {
                // Upper blocks are met from the last to the first.
                let block = here - 1 - (step - below);
                (block > 0).then(|| self.here.first_gap + block - 1)
            }
        };
        let gap_before = |step: usize| gap_after((step + steps - 1) % steps);
        let mut unite = |one: Option<usize>, other: Option<usize>| {
            if let (Some(one), Some(other)) = (one, other) {
                gaps.unite(one as u32, other as u32);
            }
        };
        for list in [&mut self.first, &mut self.last] {
            list.clear();
            list.resize(self.nodes.len(), NONE);
        }
        for step in 0..steps {
            let block = if step < below {
                step
            } else {
                below + here - 1 - (step - below)
            };
            let root = self.nodes.find(block as u32) as usize;
            match self.last[root] {
                NONE => self.first[root] = step as u32,
                last => unite(gap_after(last as usize), gap_before(step)),
            }
            self.last[root] = step as u32;
        }
        for (&first, &last) in self.first.iter().zip(&self.last) {
            if first != NONE {
                unite(gap_after(last as usize), gap_before(first as usize));
            }
        }
    }
}
