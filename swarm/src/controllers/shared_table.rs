//! Phase 3 with one codebook and one table for all robots of an arena.

use serde::{Deserialize, Serialize};

use super::codebook::Codebook;
use super::controller::Controllers;
use super::decider::Decider;
use super::explorer::Explorer;
use crate::bodies::{Bodies, Reading};
use crate::dimensions::WHEELS;
use crate::learn::repository::Repository;
use crate::learn::transition::Transition;
use crate::spec::ControllerParameters;

/// Robots that choose from the same table and write to it.
///
/// All choose from the table as it was when the step began; after the step the transitions go in in
/// the order of the robots' numbers, so that no order of work shows.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SharedTableExplorers {
    deciders: Vec<Decider>,
    common: Common,
    clusters_saturated: Vec<u64>,
}

/// The one codebook and the one table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Common {
    codebook: Codebook,
    repository: Repository,
}

impl SharedTableExplorers {
    /// Robots (at least one) that so far explored by themselves, with the same codebook.
    ///
    /// Their tables become one: of each list the oldest entries of all robots go in first, the
    /// newest last, so that every robot's newest are kept as far as `lambda` allows.
    ///
    /// # Panics
    /// Without robots: a valid spec has at least one.
    pub fn new(p: &ControllerParameters, robots: Vec<Explorer>) -> Self {
        let codebook = robots[0].codebook().clone();
        let mut repository = Repository::new(codebook.states.len(), codebook.actions.len(), p);
        for i in 0..repository.states() {
            for j in 0..repository.actions() {
                merge(&mut repository, &robots, i, j);
            }
        }
        let parts = robots.into_iter().map(Explorer::into_parts);
        let (deciders, clusters_saturated) = parts
            .map(|(decider, _, _, saturated)| (decider, saturated))
            .unzip();
        Self {
            deciders,
            common: Common {
                codebook,
                repository,
            },
            clusters_saturated,
        }
    }

    /// Whether saved parts fit together.
    pub fn is_sound(&self) -> bool {
        let Common {
            codebook,
            repository,
        } = &self.common;
        repository.is_sound()
            && codebook.counts() == (repository.states(), repository.actions())
            && self.clusters_saturated.len() == self.deciders.len()
            && self
                .deciders
                .iter()
                .all(|decider| decider.is_sound(codebook))
    }

    /// Takes the parameters of decisions from another set.
    pub fn retune(&mut self, p: &ControllerParameters) {
        for decider in &mut self.deciders {
            decider.retune(p);
        }
        self.common.repository.retune(p);
    }

    /// Starts a trajectory from the sensors read at its beginning.
    pub fn begin_trajectory(&mut self, bodies: &Bodies) {
        for (decider, body) in self.deciders.iter_mut().zip(bodies.iter()) {
            decider.begin_trajectory(&self.common.codebook, &body.reading);
        }
    }

    /// The common states, actions and commands.
    pub fn codebook(&self) -> &Codebook {
        &self.common.codebook
    }

    /// The common table.
    pub fn repository(&self) -> &Repository {
        &self.common.repository
    }

    /// Where each robot stands in the table; index is the robot's number.
    pub fn deciders(&self) -> &[Decider] {
        &self.deciders
    }

    /// Robots.
    pub fn robots(&self) -> usize {
        self.deciders.len()
    }

    /// Vectors of each robot's phase 1 that found no room for a cluster of their own.
    pub fn clusters_saturated(&self) -> &[u64] {
        &self.clusters_saturated
    }

    /// Bytes that a robot needs for itself and a copy of what is common.
    pub fn robot_bytes(&self) -> u64 {
        size_of::<Explorer>() as u64 + self.common_bytes()
    }

    /// Bytes held in all, exactly counted: what is common is held once.
    pub fn bytes(&self) -> u64 {
        let a_robot = size_of::<Decider>() + size_of::<u64>();
        (size_of::<Self>() + self.deciders.len() * a_robot) as u64 + self.common_bytes()
    }

    fn common_bytes(&self) -> u64 {
        self.common.codebook.heap_bytes() + self.common.repository.heap_bytes()
    }
}

/// The lists S(i, j) of all robots as one: position from the newest decides, then the robot.
fn merge(common: &mut Repository, robots: &[Explorer], i: u32, j: u32) {
    let lists: Vec<Vec<u32>> = robots
        .iter()
        .map(|robot| robot.repository().list(i, j).collect())
        .collect();
    let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
    for from_newest in (1..=longest).rev() {
        for list in &lists {
            if let Some(place) = list.len().checked_sub(from_newest) {
                common.record(i, j, list[place]);
            }
        }
    }
}

impl Controllers for SharedTableExplorers {
    type Robot = Decider;
    type Common = Common;
    const ARE_LARGE: bool = false;
    const ENDS_STEPS: bool = true;

    #[inline(always)]
    fn parts(&mut self) -> (&mut [Decider], &Common) {
        (&mut self.deciders, &self.common)
    }

    #[inline(always)]
    fn choose(common: &Common, robot: &mut Decider, step: u64, _: &Reading) {
        robot.choose(&common.codebook, &common.repository, step);
    }

    #[inline(always)]
    fn act(common: &Common, robot: &mut Decider, _: u64, _: &Reading) -> [f32; WHEELS] {
        robot.act(&common.codebook)
    }

    #[inline(always)]
    fn learn(common: &Common, robot: &mut Decider, reading: &Reading) {
        robot.arrive(&common.codebook, reading);
    }

    fn end_step(&mut self, _step: u64, _bodies: &Bodies) {
        for decider in &self.deciders {
            let Transition {
                state,
                action,
                next,
            } = decider.last();
            self.common.repository.record(state, action, next);
        }
    }
}
