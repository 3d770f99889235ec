//! A grid that finds the movable objects near a robot: each cell lists the objects that a robot in
//! it may see.
//!
//! Lists reach farther than sight does, so that objects may move a little before they are made
//! anew. Whoever looks tests distances exactly, so lists never change what is seen.

use arenas::Arena;
use arenas::axis::GridAxis;

use crate::bodies::{ObjectPose, Shape};
use crate::lanes::F8;
use crate::sensors::proximity::{Optics, Rays};

/// Cells aimed at, at most.
const CELLS: f64 = 4_096.0;

/// How much farther than sight lists reach, in typical sights.
const MARGIN: f64 = 0.25;

/// Lists of objects, as scratch: can be made anew from poses at any time.
#[derive(Clone, Debug)]
pub struct ObjectGrid {
    shapes: Vec<Shape>,
    /// Farthest that each object can be seen from, between its centre and the robot's, metres.
    sights_m: Vec<f32>,
    margin_m: f32,
    across: GridAxis,
    up: GridAxis,
    columns: usize,
    /// Start of each cell in `listing`, one more than there are cells.
    starts: Vec<u32>,
    listing: Vec<u32>,
    /// Where objects were when lists were made; nothing before.
    listed_m: Vec<[f32; 2]>,
}

impl ObjectGrid {
    /// Room for the lists of an arena's objects, for robots that see others up to `sight_m` between
    /// centres.
    pub fn new(arena: &Arena, sight_m: f64) -> Self {
        let shapes = Shape::all(arena);
        let sights_m: Vec<f32> = shapes
            .iter()
            .map(|shape| sight_m as f32 + shape.reach_m())
            .collect();
        let objects = shapes.len();
        let squares = sights_m.iter().map(|&sight_m| f64::from(sight_m).powi(2));
        let typical_m = (squares.sum::<f64>() / objects.max(1) as f64).sqrt();
        let (width_m, height_m) = (arena.width_m(), arena.height_m());
        let cell_m = ((1.0 + MARGIN) * typical_m).max((width_m * height_m / CELLS).sqrt());
        let count = |side_m: f64| (side_m / cell_m).ceil().max(1.0) as usize;
        let (columns, rows) = (count(width_m), count(height_m));
        Self {
            shapes,
            margin_m: (MARGIN * typical_m) as f32,
            across: GridAxis::new(columns, (1.0 / cell_m) as f32),
            up: GridAxis::new(rows, (1.0 / cell_m) as f32),
            columns,
            starts: match objects {
                0 => Vec::new(),
                _ => vec![0; columns * rows + 1],
            },
            // An object of sight s is in (2 (s + margin) / cell + 2)^2 cells at most; as cells are
            // as wide as the root of the mean of (s + margin)^2 or nearly so, that is below 17 on
            // average.
            listing: Vec::with_capacity(17 * objects),
            listed_m: Vec::with_capacity(objects),
            sights_m,
        }
    }

    /// Makes lists that hold for these poses, unless those that there are still do.
    pub fn update(&mut self, poses: &[ObjectPose]) {
        // What is left of the margin is far more than any rounding.
        let limit_m = 0.9 * self.margin_m;
        let holds = self.listed_m.len() == poses.len()
            && self.listed_m.iter().zip(poses).all(|(&[x_m, y_m], pose)| {
                let (dx_m, dy_m) = (pose.x_m - x_m, pose.y_m - y_m);
                dx_m * dx_m + dy_m * dy_m < limit_m * limit_m
            });
        if !holds {
            self.list(poses);
        }
    }

    fn list(&mut self, poses: &[ObjectPose]) {
        self.listed_m.clear();
        self.listed_m
            .extend(poses.iter().map(|pose| [pose.x_m, pose.y_m]));
        self.starts.fill(0);
        for number in 0..poses.len() {
            for cell in self.cells_around(number) {
                self.starts[cell] += 1;
            }
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.listing.clear();
        self.listing.resize(sum as usize, 0);
        // From the last object to the first, so that numbers rise within a cell.
        for number in (0..poses.len()).rev() {
            for cell in self.cells_around(number) {
                let place = &mut self.starts[cell];
                *place -= 1;
                self.listing[*place as usize] = number as u32;
            }
        }
    }

    /// The cells from which an object may be seen.
    fn cells_around(&self, number: usize) -> impl Iterator<Item = usize> + use<> {
        let far_m = self.sights_m[number] + self.margin_m;
        let [x_m, y_m] = self.listed_m[number];
        let [left, bottom] = self.cell(x_m - far_m, y_m - far_m);
        let [right, top] = self.cell(x_m + far_m, y_m + far_m);
        let columns = self.columns;
        (bottom..=top).flat_map(move |row| (left..=right).map(move |column| row * columns + column))
    }

    /// Column and row of a place.
    #[inline(always)]
    fn cell(&self, x_m: f32, y_m: f32) -> [usize; 2] {
        [self.across.cell(x_m), self.up.cell(y_m)]
    }

    /// Numbers of the objects that a robot at (x, y) may see: all that it sees, and some more.
    #[inline(always)]
    pub fn near(&self, x_m: f32, y_m: f32) -> &[u32] {
        let [column, row] = self.cell(x_m, y_m);
        let cell = row * self.columns + column;
        &self.listing[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// Shape of an object, and how far from its centre it can be seen, metres.
    #[inline(always)]
    pub fn shape(&self, number: usize) -> (&Shape, f32) {
        (&self.shapes[number], self.sights_m[number])
    }

    /// Shortens `best` by the objects that a robot at (x, y) can see; the grid is up to date.
    pub fn see(
        &self,
        optics: &Optics,
        poses: &[ObjectPose],
        rays: &Rays,
        (x_m, y_m): (f32, f32),
        mut best: F8,
    ) -> F8 {
        for &number in self.near(x_m, y_m) {
            let pose = &poses[number as usize];
            let (shape, sight_m) = self.shape(number as usize);
            best = optics.to_object(shape, pose, sight_m, rays, (x_m, y_m), best);
        }
        best
    }

    /// Bytes held. No list outgrows its capacity.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.shapes[..])
            + size_of_val(&self.sights_m[..])
            + size_of_val(&self.starts[..])
            + self.listing.capacity() * size_of::<u32>()
            + self.listed_m.capacity() * size_of::<[f32; 2]>()
    }
}
