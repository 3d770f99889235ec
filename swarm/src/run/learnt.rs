//! What one robot has learnt so far, for whoever looks into a run on the way.

use std::ops::Range;

use super::learners::Learners;
use super::machine::Run;
use super::robot_memory::RobotMemory;
use super::venue::{TARGET, TRAINING};
use crate::controllers::{Codebook, Decider, Explorer};
use crate::learn::repository::Repository;
use crate::stages::Phase;

/// A robot's learner at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Learnt<'a> {
    /// What the run is doing.
    pub phase: Phase,
    /// Sensor and actuator clusters so far.
    pub clusters: (u32, u32),
    /// Sensori-motor clusters so far, where the objective is over them.
    pub sensori_motor_clusters: Option<u32>,
    /// Fitness of the parent, once it was evaluated; in evolution alone.
    pub fitness: Option<f64>,
    /// Present state and the action last chosen, where there is a table.
    pub choice: Option<(u32, u32)>,
    /// States, actions and what followed them, where there is a table.
    pub table: Option<(&'a Codebook, &'a Repository)>,
    /// Bytes held.
    pub memory: RobotMemory,
}

impl<'a> Learnt<'a> {
    fn exploring(self, explorer: &'a Explorer) -> Self {
        Self {
            clusters: explorer.codebook().counts(),
            choice: Some(choice(explorer.decider())),
            table: Some((explorer.codebook(), explorer.repository())),
            ..self
        }
    }
}

impl Run {
    /// What a robot has learnt so far; `None` where its method learns nothing, or there is no such
    /// robot.
    pub fn learnt(&self, robot: usize) -> Option<Learnt<'_>> {
        self.learnt_by(robot, *self.memory().get(robot)?)
    }

    /// The same of some robots, in order, as far as there are so many and they learn; `memory` is
    /// [`Run::memory`].
    pub fn learnt_among<'a>(
        &'a self,
        robots: Range<usize>,
        memory: &'a [RobotMemory],
    ) -> impl Iterator<Item = (usize, Learnt<'a>)> {
        robots.filter_map(|robot| Some((robot, self.learnt_by(robot, *memory.get(robot)?)?)))
    }

    fn learnt_by(&self, robot: usize, memory: RobotMemory) -> Option<Learnt<'_>> {
        let none = Learnt {
            phase: self.progress().phase,
            clusters: (0, 0),
            sensori_motor_clusters: None,
            fitness: None,
            choice: None,
            table: None,
            memory,
        };
        match &self.learners {
            Learners::Babblers(robots) => Some(Learnt {
                clusters: robots.get(robot)?.clusters(),
                ..none
            }),
            Learners::Crawlers(robots) => {
                let crawler = robots.get(robot)?;
                Some(Learnt {
                    clusters: (crawler.sensor_clusters(), crawler.actuator_clusters()),
                    sensori_motor_clusters: Some(crawler.sensori_motor_clusters()),
                    fitness: crawler.tells().map(|(_, fitness)| fitness),
                    ..none
                })
            }
            Learners::Replayers(robots) => Some(none.exploring(robots.get(robot)?.explorer())),
            Learners::Explorers(robots) => Some(none.exploring(robots.get(robot)?)),
            Learners::SharedTable(robots) => Some(Learnt {
                clusters: robots.codebook().counts(),
                choice: Some(choice(robots.deciders().get(robot)?)),
                table: Some((robots.codebook(), robots.repository())),
                ..none
            }),
            Learners::Former(_) | Learners::Brownian(_) | Learners::Walkers(_) => None,
        }
    }

    /// The state that a robot is in and the action that it chose last, where it explores by a table.
    pub fn choice(&self, robot: usize) -> Option<(u32, u32)> {
        let decider = match &self.learners {
            Learners::Replayers(robots) => robots.get(robot)?.explorer().decider(),
            Learners::Explorers(robots) => robots.get(robot)?.decider(),
            Learners::SharedTable(robots) => robots.deciders().get(robot)?,
            _ => return None,
        };
        Some(choice(decider))
    }

    /// Whether robots learn anything at all.
    pub fn learns(&self) -> bool {
        !matches!(
            self.learners,
            Learners::Former(_) | Learners::Brownian(_) | Learners::Walkers(_)
        )
    }

    /// Steps of the arena in which visits counted.
    pub fn counted_steps(&self) -> u64 {
        self.venues[TARGET].world.state().tally.steps()
    }

    /// Whether robots are in the training arena right now.
    pub fn is_training(&self) -> bool {
        self.venue() == TRAINING
    }

    /// For each square of the target arena 1 + the counted steps after which it was first entered, 0
    /// for never; empty before visits count. Row 0 is the lowest y.
    pub fn first_entry(&self) -> &[u64] {
        self.venues[TARGET].world.state().tally.first_entry()
    }
}

fn choice(decider: &Decider) -> (u32, u32) {
    (decider.state(), decider.action())
}
