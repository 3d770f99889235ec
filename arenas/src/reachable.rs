//! The squares that a disc's centre can reach from a start: the denominator of coverage.
//! A quadtree over the disc's positions, refined where neither free nor blocked is certain.

use nalgebra::Point2;

use crate::arena::{Arena, Pose};
use crate::segment::Segment;
use crate::squares::Squares;

/// No cell is refined below this side, metres ...
const FINEST_M: f64 = 0.25e-3;
/// ... nor below this fraction of a square's longer side and of the body radius.
const CELLS_PER_SQUARE: f64 = 32.0;
const CELLS_PER_RADIUS: f64 = 6.0;
/// Cells along the walls' contours that an arena may need before coarser ones are used.
const CELL_BUDGET: f64 = 4.0e6;
/// A square counts if one of this many points along each of its sides, squared, is reached.
const POINTS_PER_SIDE: u32 = 6;

/// What a robot can reach in an arena.
#[derive(Clone, Debug, PartialEq)]
pub struct Reachable {
    /// Whether each square can be reached, row by row, row 0 the lowest y.
    pub mask: Vec<bool>,
    /// Squares that can be reached.
    pub count: u32,
    /// Side of the smallest cells, metres: passages whose width differs from the body's by less
    /// may be taken for open or closed wrongly.
    pub resolution_m: f64,
}

/// Squares into which the centre of a disc of `body_radius_m` can move from `start` without
/// overlapping a wall. A square counts if one of 6 x 6 evenly spaced points in it can be reached
/// (with 100 squares that is the protocol's grid of 600 x 600), so slivers narrower than a twelfth
/// of a square at a wall do not. A robot can touch such a square all the same: visits are to be
/// compared inside the mask.
///
/// Clearance (the distance to the nearest wall) changes by at most the distance moved. So a cell
/// with half diagonal d is free as a whole if the clearance at its centre is at least radius + d,
/// blocked as a whole if it is at most radius - d, and quartered otherwise. The smallest cells are
/// 1/16 to 1/32 of a square (or 0.25 mm or 1/6 of the radius, if that is more; coarser still where
/// an arena has too many walls for that): those go by their centre, and are free only if no wall
/// enters them. Free cells that share a side are connected. A start that rounding puts into a
/// blocked cell counts as in the nearest free one within two cells; without one, or if the start
/// overlaps a wall, nothing is reachable.
pub fn reachable(arena: &Arena, start: Pose, body_radius_m: f64) -> Reachable {
    let squares = Squares::of(arena);
    let mut tree = Tree::new(arena, &squares, body_radius_m);
    tree.connect(ROOT);
    let mut mask = vec![false; squares.count()];
    if let Some(component) = tree.component_near(start.position()) {
        tree.mark(ROOT, [0, 0], tree.levels, component, &mut mask);
    }
    let count = mask.iter().filter(|&&reached| reached).count() as u32;
    Reachable {
        mask,
        count,
        resolution_m: tree.cell_m[0].max(tree.cell_m[1]),
    }
}

const ROOT: usize = 0;
const BLOCKED: u32 = u32::MAX;
/// Set in the node of a free leaf; the other bits are the leaf's number.
const FREE: u32 = 1 << 31;

/// The root covers the arena and, so that squares are nodes, as many squares to the right and
/// above as make their number a power of two; the cells outside the arena are blocked.
struct Tree {
    /// `BLOCKED`, `FREE` + leaf number, or the index of the first of four children in the order
    /// lower left, lower right, upper left, upper right.
    nodes: Vec<u32>,
    /// Union-find over the free leaves.
    parents: Vec<u32>,
    walls: Vec<Segment>,
    /// Walls near the cells on the path from the root to the one being refined.
    near: Vec<u32>,
    radius_m: f64,
    /// Levels below the root, and below a square.
    levels: u32,
    levels_in_square: u32,
    /// Squares in a row and in a column.
    squares: [u32; 2],
    /// Width and height of the smallest cell.
    cell_m: [f64; 2],
}

impl Tree {
    fn new(arena: &Arena, squares: &Squares, radius_m: f64) -> Self {
        let walls: Vec<Segment> = arena
            .boundary()
            .iter()
            .chain(arena.walls())
            .copied()
            .collect();
        let [square_width_m, square_height_m] = squares.size_m();
        let square_m = square_width_m.max(square_height_m);
        let wanted_m = FINEST_M.max((square_m / CELLS_PER_SQUARE).min(radius_m / CELLS_PER_RADIUS));
        let contour_m: f64 = walls
            .iter()
            .map(|wall| 2.0 * wall.length_m() + 6.3 * radius_m)
            .sum();
        let area_m2 = arena.width_m() * arena.height_m();
        let mut levels_in_square = 0;
        let cell_m = |levels: u32| square_m / f64::from(1u32 << levels);
        while cell_m(levels_in_square) > wanted_m
            && (contour_m / cell_m(levels_in_square + 1))
                .min(area_m2 / cell_m(levels_in_square + 1).powi(2))
                < CELL_BUDGET
        {
            levels_in_square += 1;
        }
        let across = squares.columns().max(squares.rows());
        let levels = across.next_power_of_two().ilog2() + levels_in_square;
        let cells = f64::from(1u32 << levels_in_square);
        let near: Vec<u32> = (0..walls.len() as u32).collect();
        let wall_count = near.len();
        let mut tree = Self {
            nodes: vec![BLOCKED],
            parents: Vec::new(),
            walls,
            near,
            radius_m,
            levels,
            levels_in_square,
            squares: [squares.columns(), squares.rows()],
            cell_m: [square_width_m / cells, square_height_m / cells],
        };
        tree.refine(ROOT, [0, 0], levels, 0..wall_count);
        tree
    }

    /// Decides the node whose lower left cell is `corner`, with 2^`level` cells along a side, from
    /// the walls at `candidates` of `near`, which hold all that can matter in it.
    fn refine(
        &mut self,
        node: usize,
        corner: [u32; 2],
        level: u32,
        candidates: std::ops::Range<usize>,
    ) {
        let cells = self.squares.map(|side| side << self.levels_in_square);
        if corner[0] >= cells[0] || corner[1] >= cells[1] {
            return;
        }
        let half = 0.5 * f64::from(1u32 << level);
        let half_m = [half * self.cell_m[0], half * self.cell_m[1]];
        let centre = Point2::new(
            self.cell_m[0] * f64::from(corner[0]) + half_m[0],
            self.cell_m[1] * f64::from(corner[1]) + half_m[1],
        );
        let half_diagonal_m = (half_m[0] * half_m[0] + half_m[1] * half_m[1]).sqrt();
        let far_m2 = (self.radius_m + half_diagonal_m).powi(2);
        let touching_m = self.radius_m - half_diagonal_m;

        let first = self.near.len();
        let mut nearest_m2 = f64::INFINITY;
        for candidate in candidates {
            let wall = self.near[candidate];
            let distance_m2 = self.walls[wall as usize].distance_squared_m2(centre);
            if distance_m2 < far_m2 {
                self.near.push(wall);
                nearest_m2 = nearest_m2.min(distance_m2);
            }
        }
        let near = first..self.near.len();
        let blocked = touching_m > 0.0 && nearest_m2 <= touching_m * touching_m;
        if near.is_empty() {
            self.set_free(node);
        } else if level == 0 {
            let enough_m = self.radius_m.max(half_diagonal_m);
            if nearest_m2 >= enough_m * enough_m {
                self.set_free(node);
            }
        } else if !blocked {
            let children = self.nodes.len();
            self.nodes.extend([BLOCKED; 4]);
            self.nodes[node] = children as u32;
            for quarter in 0..4u32 {
                let child_corner = child_corner(corner, level, quarter);
                self.refine(
                    children + quarter as usize,
                    child_corner,
                    level - 1,
                    near.clone(),
                );
            }
            self.merge_equal(node, children);
        }
        self.near.truncate(first);
    }

    /// Takes four equal children, the last nodes of the tree, back into their parent.
    fn merge_equal(&mut self, node: usize, children: usize) {
        if self.nodes.len() != children + 4 {
            return;
        }
        let quarters = &self.nodes[children..];
        if quarters.iter().all(|&quarter| quarter == BLOCKED) {
            self.nodes[node] = BLOCKED;
        } else if quarters
            .iter()
            .all(|&quarter| quarter != BLOCKED && quarter & FREE != 0)
        {
            // Free leaves are numbered in order, so the four are the last ones.
            self.nodes[node] = quarters[0];
            self.parents.truncate(self.parents.len() - 3);
        } else {
            return;
        }
        self.nodes.truncate(children);
    }

    fn set_free(&mut self, node: usize) {
        let leaf = self.parents.len() as u32;
        self.parents.push(leaf);
        self.nodes[node] = FREE | leaf;
    }

    /// Connects the free leaves inside a node.
    fn connect(&mut self, node: usize) {
        if let Node::Children([lower_left, lower_right, upper_left, upper_right]) = self.node(node)
        {
            for child in [lower_left, lower_right, upper_left, upper_right] {
                self.connect(child);
            }
            self.connect_beside(lower_left, lower_right);
            self.connect_beside(upper_left, upper_right);
            self.connect_above(lower_left, upper_left);
            self.connect_above(lower_right, upper_right);
        }
    }

    /// Connects the free leaves of two nodes along the side that they share, `right` being the
    /// node to the right.
    fn connect_beside(&mut self, left: usize, right: usize) {
        match (self.node(left), self.node(right)) {
            (Node::Blocked, _) | (_, Node::Blocked) => {}
            (Node::Free(one), Node::Free(other)) => self.unite(one, other),
            (left_node, right_node) => {
                let [_, lower_left, _, upper_left] = left_node.children_or(left);
                let [lower_right, _, upper_right, _] = right_node.children_or(right);
                self.connect_beside(lower_left, lower_right);
                self.connect_beside(upper_left, upper_right);
            }
        }
    }

    /// The same for two nodes one above the other.
    fn connect_above(&mut self, lower: usize, upper: usize) {
        match (self.node(lower), self.node(upper)) {
            (Node::Blocked, _) | (_, Node::Blocked) => {}
            (Node::Free(one), Node::Free(other)) => self.unite(one, other),
            (lower_node, upper_node) => {
                let [_, _, lower_left, lower_right] = lower_node.children_or(lower);
                let [upper_left, upper_right, _, _] = upper_node.children_or(upper);
                self.connect_above(lower_left, upper_left);
                self.connect_above(lower_right, upper_right);
            }
        }
    }

    fn node(&self, node: usize) -> Node {
        match self.nodes[node] {
            BLOCKED => Node::Blocked,
            free if free & FREE != 0 => Node::Free(free & !FREE),
            first => Node::Children(std::array::from_fn(|quarter| first as usize + quarter)),
        }
    }

    fn find(&mut self, mut leaf: u32) -> u32 {
        while self.parents[leaf as usize] != leaf {
            let grandparent = self.parents[self.parents[leaf as usize] as usize];
            self.parents[leaf as usize] = grandparent;
            leaf = grandparent;
        }
        leaf
    }

    fn unite(&mut self, one: u32, other: u32) {
        let (one, other) = (self.find(one), self.find(other));
        // The lower number becomes the root: the result does not depend on the order of unions.
        self.parents[one.max(other) as usize] = one.min(other);
    }

    /// Component of the free leaf nearest to `start`, within two cells.
    fn component_near(&mut self, start: Point2<f64>) -> Option<u32> {
        let mut offsets: Vec<[i32; 2]> = (-2..=2)
            .flat_map(|y| (-2..=2).map(move |x| [x, y]))
            .collect();
        offsets.sort_by_key(|[x, y]| x * x + y * y);
        let tolerance_m = self.cell_m[0].max(self.cell_m[1]);
        let needed_m = (self.radius_m - tolerance_m).max(0.0);
        if self
            .walls
            .iter()
            .any(|wall| wall.distance_squared_m2(start) < needed_m * needed_m)
        {
            return None;
        }
        let leaf = offsets.into_iter().find_map(|[x, y]| {
            self.free_leaf_at([
                start.x / self.cell_m[0] + f64::from(x),
                start.y / self.cell_m[1] + f64::from(y),
            ])
        })?;
        Some(self.find(leaf))
    }

    /// Free leaf at a place given in cells.
    fn free_leaf_at(&self, [x, y]: [f64; 2]) -> Option<u32> {
        let [columns, rows] = self
            .squares
            .map(|side| f64::from(side << self.levels_in_square));
        if !(0.0..columns).contains(&x) || !(0.0..rows).contains(&y) {
            return None;
        }
        let (x, y) = (x as u32, y as u32);
        let mut node = ROOT;
        let mut level = self.levels;
        loop {
            match self.node(node) {
                Node::Blocked => return None,
                Node::Free(leaf) => return Some(leaf),
                Node::Children(children) => {
                    level -= 1;
                    node = children[((x >> level & 1) + 2 * (y >> level & 1)) as usize];
                }
            }
        }
    }

    /// Whether a node holds a point that decides about a square: (k + 1/2) / 6 of its side along
    /// both axes, for whole k.
    fn holds_point(&self, corner: [u32; 2], level: u32) -> bool {
        // In units of 1/12 of a cell a node starts at 12 cell, a point is at an odd multiple of
        // the cells in a square.
        let spacing = 1u64 << self.levels_in_square;
        let points_unit = u64::from(2 * POINTS_PER_SIDE);
        corner.into_iter().all(|cell| {
            let from = points_unit * u64::from(cell);
            let odd = from.div_ceil(spacing) | 1;
            odd * spacing < from + (points_unit << level)
        })
    }

    /// Marks the squares of the leaves of one component.
    fn mark(
        &mut self,
        node: usize,
        corner: [u32; 2],
        level: u32,
        component: u32,
        mask: &mut [bool],
    ) {
        match self.node(node) {
            Node::Blocked => {}
            Node::Free(leaf) => {
                if self.holds_point(corner, level) && self.find(leaf) == component {
                    let [column, row] = corner.map(|cell| cell >> self.levels_in_square);
                    let wide = 1 << level.saturating_sub(self.levels_in_square);
                    for row in row..row + wide {
                        let first = (row * self.squares[0] + column) as usize;
                        mask[first..first + wide as usize].fill(true);
                    }
                }
            }
            Node::Children(children) => {
                for (quarter, child) in (0..).zip(children) {
                    let child_corner = child_corner(corner, level, quarter);
                    self.mark(child, child_corner, level - 1, component, mask);
                }
            }
        }
    }
}

enum Node {
    Blocked,
    Free(u32),
    Children([usize; 4]),
}

impl Node {
    /// The children, or for a leaf the leaf itself in place of each.
    fn children_or(&self, leaf: usize) -> [usize; 4] {
        match self {
            Self::Children(children) => *children,
            _ => [leaf; 4],
        }
    }
}

fn child_corner([x, y]: [u32; 2], level: u32, quarter: u32) -> [u32; 2] {
    let half = 1 << (level - 1);
    [x + half * (quarter % 2), y + half * (quarter / 2)]
}

#[cfg(test)]
#[path = "reachable_tests.rs"]
mod tests;
