//! Arenas to bump about in, and robots that do.

use nalgebra::Point2;

use super::*;

pub const RADIUS_M: f64 = 0.037;
pub const TOP_STEP_M: f32 = 0.0082;

/// Repeatable numbers in [0, 1).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn signed(&mut self) -> f32 {
        2.0 * self.next() - 1.0
    }
}

pub fn arena(side_m: f64, walls_m: &[[f64; 4]]) -> Arena {
    let middle = side_m / 2.0;
    Arena::from_json(&format!(
        r#"{{"name": "test", "width_m": {side_m}, "height_m": {side_m}, "walls_m": {walls_m:?},
            "starts": [{{"x_m": {middle}, "y_m": {middle}, "heading_rad": 0}}]}}"#
    ))
    .unwrap()
}

/// A spiral of corridors 0.15 m wide with a blind end, a wedge and a free-standing wall tip.
pub const MAZE: [[f64; 4]; 9] = [
    [0.15, 0.0, 0.15, 0.45],
    [0.15, 0.45, 0.3, 0.45],
    [0.3, 0.45, 0.3, 0.15],
    [0.45, 0.6, 0.45, 0.3],
    [0.45, 0.15, 0.45, 0.0],
    [0.45, 0.3, 0.6, 0.3],
    [0.3, 0.15, 0.38, 0.1],
    [0.0, 0.6, 0.06, 0.5],
    [0.45, 0.15, 0.6, 0.12],
];

/// Three walls in the open.
pub const EASY: [[f64; 4]; 3] = [
    [0.2, 0.1, 0.2, 0.3],
    [0.4, 0.35, 0.55, 0.35],
    [0.3, 0.45, 0.4, 0.55],
];

pub fn model(friction: f64, bounce: f64) -> RobotModel {
    let mut model = RobotModel::default();
    model.parameters.contact_friction = friction;
    model.parameters.contact_bounce = bounce;
    model
}

pub fn all_walls(arena: &Arena) -> Vec<Segment> {
    arena
        .boundary()
        .iter()
        .chain(arena.walls())
        .copied()
        .collect()
}

pub fn wall_distance_m(walls: &[Segment], x_m: f32, y_m: f32) -> f64 {
    let point = Point2::new(f64::from(x_m), f64::from(y_m));
    walls
        .iter()
        .map(|s| {
            let (along, to) = (s.b - s.a, point - s.a);
            let t = (to.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            (to - along * t).norm()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Whether the way from one place to another crosses a wall.
pub fn crosses(walls: &[Segment], from: (f32, f32), to: (f32, f32)) -> bool {
    let point = |(x, y): (f32, f32)| Point2::new(f64::from(x), f64::from(y));
    let side = |a: Point2<f64>, b: Point2<f64>, c: Point2<f64>| (b - a).perp(&(c - a));
    let (p, q) = (point(from), point(to));
    walls.iter().any(|s| {
        side(p, q, s.a) * side(p, q, s.b) < 0.0 && side(s.a, s.b, p) * side(s.a, s.b, q) < 0.0
    })
}

/// Robots that drive arcs of random wheel speeds, changed every twelve steps.
pub struct Crowd {
    pub engine: RapierEngine,
    pub x_m: Vec<f32>,
    pub y_m: Vec<f32>,
    pub dx_m: Vec<f32>,
    pub dy_m: Vec<f32>,
    pub touched: Vec<bool>,
    heading: Vec<f32>,
    wheels: Vec<(f32, f32)>,
    noise: Noise,
    steps: usize,
}

impl Crowd {
    pub fn at(arena: &Arena, model: &RobotModel, places: &[(f32, f32)], seed: u64) -> Self {
        let (x_m, y_m): (Vec<f32>, Vec<f32>) = places.iter().copied().unzip();
        let n = places.len();
        Self {
            engine: RapierEngine::new(arena, model, &x_m, &y_m),
            x_m,
            y_m,
            dx_m: vec![0.0; n],
            dy_m: vec![0.0; n],
            touched: vec![false; n],
            heading: vec![0.0; n],
            wheels: vec![(0.0, 0.0); n],
            noise: Noise(seed),
            steps: 0,
        }
    }

    /// As many robots as asked for, at random places without overlap.
    pub fn random(arena: &Arena, model: &RobotModel, robots: usize, seed: u64) -> Self {
        let walls = all_walls(arena);
        let (mut noise, mut places) = (Noise(seed), Vec::<(f32, f32)>::new());
        while places.len() < robots {
            let (x, y) = (
                noise.next() * arena.width_m() as f32,
                noise.next() * arena.width_m() as f32,
            );
            if wall_distance_m(&walls, x, y) > RADIUS_M
                && places.iter().all(|p| (p.0 - x).hypot(p.1 - y) > 0.075)
            {
                places.push((x, y));
            }
        }
        Self::at(arena, model, &places, seed)
    }

    pub fn engine_step(&mut self) {
        self.engine.step(
            &mut self.x_m,
            &mut self.y_m,
            &self.dx_m,
            &self.dy_m,
            &mut self.touched,
        );
    }

    pub fn wander(&mut self) {
        for i in 0..self.x_m.len() {
            if self.steps.is_multiple_of(12) {
                let (left, right) = (self.noise.signed(), self.noise.signed());
                self.wheels[i] = (TOP_STEP_M * left, TOP_STEP_M * right);
            }
            let (left, right) = self.wheels[i];
            let turn = (right - left) / 0.052;
            let middle = self.heading[i] + turn / 2.0;
            self.heading[i] += turn;
            self.dx_m[i] = (left + right) / 2.0 * libm::cosf(middle);
            self.dy_m[i] = (left + right) / 2.0 * libm::sinf(middle);
        }
        self.steps += 1;
        self.engine_step();
    }

    pub fn bytes(&self) -> Vec<u8> {
        postcard::to_stdvec(&self.engine).unwrap()
    }

    pub fn deepest_overlap_m(&self) -> f64 {
        let mut deepest = 0.0f64;
        for i in 0..self.x_m.len() {
            for j in 0..i {
                let apart = (self.x_m[i] - self.x_m[j]).hypot(self.y_m[i] - self.y_m[j]);
                deepest = deepest.max(2.0 * RADIUS_M - f64::from(apart));
            }
        }
        deepest
    }

    pub fn deepest_in_wall_m(&self, walls: &[Segment]) -> f64 {
        (0..self.x_m.len())
            .map(|i| RADIUS_M - wall_distance_m(walls, self.x_m[i], self.y_m[i]))
            .fold(0.0, f64::max)
    }
}
