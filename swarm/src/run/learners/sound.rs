//! Whether learners that were saved are what their stage asks for: others are not gone on with.

use rayon::prelude::*;

use super::Learners;
use crate::caps::MemoryPlan;
use crate::controllers::{Crawler, Explorer};
use crate::methods::Explores;
use crate::spec::{Method, RunSpec, Sharing};
use crate::stages::{Phase, Stage};

impl Learners {
    /// Whether saved learners are what a stage asks for, one a robot, and their parts fit together.
    pub fn suit(&self, stage: &Stage, spec: &RunSpec, plan: &MemoryPlan) -> bool {
        let method = spec.controller.method;
        let explores = method.definition().explores;
        let shared = spec.sharing == Sharing::Arena;
        let table = explores == Explores::ByTable;
        let kind = match (stage.phase, self) {
            (Phase::Babbling, Learners::Babblers(_)) => true,
            (Phase::Evolution, Learners::Crawlers(robots)) => robots.iter().all(Crawler::watches),
            (Phase::Repository, Learners::Replayers(_)) => true,
            (Phase::Exploration, Learners::Crawlers(_)) => explores == Explores::Evolving,
            (Phase::Exploration, Learners::Brownian(_)) => method == Method::Brownian,
            (Phase::Exploration, Learners::Walkers(walkers)) => walkers.are_of(method),
            (Phase::Exploration, Learners::Explorers(_)) => table && !shared,
            (Phase::Exploration, Learners::SharedTable(_)) => table && shared,
            _ => false,
        };
        kind && self.robots() == spec.robots as usize && self.are_sound(spec, plan)
    }

    /// Whether no index of what was saved points beyond what it points into, and no number is none.
    fn are_sound(&self, spec: &RunSpec, plan: &MemoryPlan) -> bool {
        let hears = matches!(spec.sharing, Sharing::Radio(_));
        match self {
            Learners::Former(never) => match *never {},
            Learners::Brownian(_) => true,
            Learners::Babblers(robots) => robots.par_iter().all(|robot| robot.is_sound(plan)),
            Learners::Crawlers(robots) => robots
                .par_iter()
                .all(|robot| robot.is_sound(plan) && robot.hears() == hears),
            Learners::Replayers(robots) => robots.par_iter().all(|robot| robot.is_sound(plan)),
            Learners::Explorers(robots) => robots.par_iter().all(Explorer::is_sound),
            Learners::SharedTable(robots) => robots.is_sound(),
            Learners::Walkers(walkers) => walkers.are_sound(),
        }
    }
}
