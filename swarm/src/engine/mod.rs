//! The two physics engines: what moves a robot that wants to go somewhere.

pub mod cells;
pub mod crowd;
pub mod drive;
pub mod kinematic;
pub mod near;
pub mod rapier;

use std::panic::{AssertUnwindSafe, catch_unwind};

use arenas::Arena;
use serde::{Deserialize, Serialize};

use crate::bodies::{Bodies, ObjectPose, StartPose};
use crate::robot::RobotModel;
use crate::spec::EngineKind;
use rapier::RapierEngine;

/// Ways that robots go in a trial.
const TRIAL_WAYS_M: [[f32; 2]; 6] = [
    [0.0, 0.0],
    [0.005, 0.0],
    [0.0, 0.005],
    [-0.005, 0.0],
    [0.0, -0.005],
    [0.004, 0.003],
];

/// The engine of one world, with whatever state it keeps between steps.
#[derive(Serialize, Deserialize)]
pub enum EngineState {
    /// Stateless: positions are all there is.
    Kinematic,
    /// Rigid bodies.
    Rapier(Box<Rigid>),
}

/// Rigid bodies, and the columns in which rapier's side takes and gives positions.
#[derive(Serialize, Deserialize)]
pub struct Rigid {
    engine: RapierEngine,
    #[serde(skip)]
    columns: Columns,
}

#[derive(Default)]
struct Columns {
    x_m: Vec<f32>,
    y_m: Vec<f32>,
    dx_m: Vec<f32>,
    dy_m: Vec<f32>,
    touched: Vec<bool>,
}

impl EngineState {
    /// The engine of a kind for robots at their start poses.
    pub fn new(kind: EngineKind, arena: &Arena, model: &RobotModel, starts: &[StartPose]) -> Self {
        match kind {
            EngineKind::Kinematic => EngineState::Kinematic,
            EngineKind::Rapier => {
                let x_m: Vec<f32> = starts.iter().map(|s| s.x_m).collect();
                let y_m: Vec<f32> = starts.iter().map(|s| s.y_m).collect();
                let engine = RapierEngine::new(arena, model, &x_m, &y_m);
                EngineState::Rapier(Box::new(Rigid {
                    engine,
                    columns: Columns::default(),
                }))
            }
        }
    }

    /// Whether it is one of these robots and can step them, as what was read back might not.
    pub fn fits(&self, bodies: &Bodies) -> bool {
        match self {
            EngineState::Kinematic => true,
            EngineState::Rapier(rigid) => rigid.engine.fits(bodies.len()) && rigid.can_step(bodies),
        }
    }

    /// Puts robots elsewhere at once, without any memory of earlier contacts.
    pub fn place(&mut self, bodies: &Bodies) {
        if let EngineState::Rapier(rigid) = self {
            rigid.columns.read(bodies);
            rigid.engine.place(&rigid.columns.x_m, &rigid.columns.y_m);
        }
    }
}

impl Rigid {
    /// Whether a copy steps the robots to and fro. Rapier does not look whether what it is read
    /// from holds together, and panics where an index points nowhere.
    fn can_step(&self, bodies: &Bodies) -> bool {
        let steps = || {
            let mut engine = self.engine.copy()?;
            let mut columns = Columns::default();
            columns.read(bodies);
            for way_m in TRIAL_WAYS_M {
                columns.dx_m.fill(way_m[0]);
                columns.dy_m.fill(way_m[1]);
                columns.step(&mut engine);
            }
            Some(())
        };
        matches!(catch_unwind(AssertUnwindSafe(steps)), Ok(Some(())))
    }

    /// Where the movable objects are.
    pub fn objects(&self) -> impl ExactSizeIterator<Item = ObjectPose> + '_ {
        self.engine.objects()
    }

    /// Takes over where bodies were put after the step.
    pub fn correct(&mut self, bodies: &Bodies) {
        let places = bodies.iter().map(|body| [body.x_m, body.y_m]);
        let ends = self.columns.x_m.iter().zip(&self.columns.y_m);
        for (robot, (place, (x_m, y_m))) in places.zip(ends).enumerate() {
            if place != [*x_m, *y_m] {
                self.engine.put(robot, place);
            }
        }
    }

    /// Moves bodies from `from_m` towards where they want to be.
    pub fn step(&mut self, bodies: &mut Bodies) {
        let c = &mut self.columns;
        c.read(bodies);
        for (i, body) in bodies.iter().enumerate() {
            let [x_m, y_m] = body.from_m;
            (c.dx_m[i], c.dy_m[i]) = (body.x_m - x_m, body.y_m - y_m);
            (c.x_m[i], c.y_m[i]) = (x_m, y_m);
        }
        c.step(&mut self.engine);
        let (stored, numbers) = bodies.stored_mut();
        for (body, &number) in stored.iter_mut().zip(numbers) {
            let i = number as usize;
            (body.x_m, body.y_m, body.touched) = (c.x_m[i], c.y_m[i], c.touched[i]);
        }
    }
}

impl Columns {
    fn step(&mut self, engine: &mut RapierEngine) {
        let (dx_m, dy_m) = (&self.dx_m, &self.dy_m);
        engine.step(&mut self.x_m, &mut self.y_m, dx_m, dy_m, &mut self.touched);
    }

    /// Takes the bodies' positions, and makes room for as many ways.
    fn read(&mut self, bodies: &Bodies) {
        self.x_m.clear();
        self.y_m.clear();
        self.x_m.extend(bodies.iter().map(|body| body.x_m));
        self.y_m.extend(bodies.iter().map(|body| body.y_m));
        self.dx_m.resize(bodies.len(), 0.0);
        self.dy_m.resize(bodies.len(), 0.0);
        self.touched.resize(bodies.len(), false);
    }
}
