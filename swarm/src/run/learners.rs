//! All robots' learners in the stage that a run is in, and how one stage's become the next's.

mod sound;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::plan::Decision;
use super::robot_memory::RobotMemory;
use crate::caps::MemoryPlan;
use crate::controllers::{
    Babbler, Brownian, Codebook, Crawler, Decider, Explorer, Replayer, SharedTableExplorers, Watch,
};
use crate::crew::Crew;
use crate::dimensions::WHEELS;
use crate::learn::archive::Archive;
use crate::learn::repository::Repository;
use crate::methods::{Explores, Walkers};
use crate::random::{Purpose, Site, Stream, stream_key};
use crate::sharing::pool::pool;
use crate::sharing::radio::{Radio, RadioControllers};
use crate::sharing::told::told_transitions;
use crate::spec::{ControllerParameters, Objective, RunSpec, Sharing};
use crate::stages::{Phase, Stage};
use crate::world::{World, WorldState};

/// One controller a robot, all of the kind that the stage asks for.
#[derive(Serialize, Deserialize)]
pub(super) enum Learners {
    /// Cannot be made; keeps the number of a variant that was, so that saved ones keep theirs.
    Former(Never),
    Brownian(Vec<Brownian>),
    Babblers(Vec<Babbler>),
    Crawlers(Vec<Crawler>),
    Replayers(Vec<Replayer>),
    Explorers(Vec<Explorer>),
    /// Explorers with one table.
    SharedTable(Box<SharedTableExplorers>),
    /// Robots that learn nothing, but for `Brownian`, which saved state has above.
    Walkers(Walkers),
}

/// A type without values.
#[derive(Serialize, Deserialize)]
pub(super) enum Never {}

/// The random streams of one robot.
struct Streams {
    seed: u64,
    robot: u64,
}

impl Streams {
    fn key(&self, site: Site, purpose: Purpose) -> u64 {
        stream_key(self.seed, site, self.robot, purpose)
    }

    fn stream(&self, site: Site, purpose: Purpose) -> Stream {
        Stream::new(self.key(site, purpose))
    }
}

/// Makes learners: the spec, and its parameters as far as the memory plan allows them.
struct Maker<'a> {
    spec: &'a RunSpec,
    plan: &'a MemoryPlan,
    parameters: ControllerParameters,
    crew: &'a Crew,
}

impl Maker<'_> {
    fn robots(&self) -> impl ExactSizeIterator<Item = Streams> + use<> {
        let seed = self.spec.seed;
        (0..self.spec.robots).map(move |robot| Streams {
            seed,
            robot: u64::from(robot),
        })
    }

    fn watch(&self, robot: &Streams) -> Watch {
        let sampling = robot.stream(Site::Training, Purpose::Sampling);
        Watch::new(&self.parameters, self.plan, sampling)
    }

    fn babblers(&self) -> Vec<Babbler> {
        let babbler = |robot: Streams| {
            let brownian = Brownian::new(robot.key(Site::Target, Purpose::Action));
            Babbler::new(&self.parameters, brownian, self.watch(&robot))
        };
        self.robots().map(babbler).collect()
    }

    fn crawlers(&self, watching: bool) -> Vec<Crawler> {
        let objective = self.spec.controller.method.definition().objective;
        let objective = objective.unwrap_or(Objective::Curiosity);
        let hears = matches!(self.spec.sharing, Sharing::Radio(_));
        let crawler = |robot: Streams| {
            let evolution = robot.stream(Site::Training, Purpose::Evolution);
            let watch = watching.then(|| self.watch(&robot));
            Crawler::new(
                objective,
                &self.parameters,
                self.plan,
                evolution,
                watch,
                hears,
            )
        };
        self.robots().map(crawler).collect()
    }

    /// Phase 2 but for the replay: explorers with empty tables, one for each robot that watched,
    /// and what goes with each. A watch is let go before its robot's table is made.
    fn explorers<T: Send>(&self, watched: Vec<(Watch, T)>) -> Vec<(Explorer, T)> {
        let p = &self.parameters;
        let clustering = |robot: &Streams| robot.stream(Site::Training, Purpose::Clustering);
        let common = (self.spec.sharing != Sharing::None).then(|| {
            let watches: Vec<&Watch> = watched.iter().map(|(watch, _)| watch).collect();
            let pooled = pool(&watches, self.plan.sample);
            let first = Streams {
                seed: self.spec.seed,
                robot: 0,
            };
            Codebook::new(p, &pooled.vectors, pooled.clusters, &mut clustering(&first))
        });
        let explorer = |(robot, (watch, rest)): (Streams, (Watch, T))| {
            let saturated = watch.saturated();
            let codebook = match &common {
                Some(common) => common.clone(),
                None => {
                    let clusters = (watch.sensors.len(), watch.actuators.len());
                    Codebook::new(p, watch.sample.sample(), clusters, &mut clustering(&robot))
                }
            };
            drop(watch);
            let key = robot.key(Site::Target, Purpose::Action);
            (Explorer::new(p, key, codebook, saturated), rest)
        };
        let each = self.robots().zip(watched);
        match self.crew.pool() {
            Some(pool) => {
                let each: Vec<_> = each.collect();
                pool.install(|| each.into_par_iter().map(explorer).collect())
            }
            None => exactly(each.map(explorer)),
        }
    }

    /// The learners of phase 3.
    fn exploring(&self, explorers: Vec<Explorer>) -> Learners {
        if self.spec.sharing == Sharing::Arena {
            let robots = SharedTableExplorers::new(&self.parameters, explorers);
            Learners::SharedTable(Box::new(robots))
        } else {
            Learners::Explorers(explorers)
        }
    }

    fn walkers(&self) -> Learners {
        let key = |robot: Streams| robot.key(Site::Target, Purpose::Action);
        match Walkers::new(self.spec, self.robots().map(key)) {
            Walkers::Brownian(controllers) => Learners::Brownian(controllers),
            walkers => Learners::Walkers(walkers),
        }
    }

    fn replayers(&self, crawlers: Vec<Crawler>) -> Vec<Replayer> {
        let p = &self.parameters;
        let replayer = |(explorer, archive)| Replayer::new(p, archive, explorer);
        let explorers = self.explorers(watched(crawlers));
        exactly(explorers.into_iter().map(replayer))
    }
}

/// What the crawlers of a phase 1 leave.
///
/// # Panics
/// When one did not watch: all of an evolution do ([`Learners::begin`], [`Learners::suit`]).
fn watched(crawlers: Vec<Crawler>) -> Vec<(Watch, Archive)> {
    let watched = |crawler: Crawler| {
        let Some(watched) = crawler.finish() else {
            unreachable!("a crawler of phase 1 that did not watch")
        };
        watched
    };
    exactly(crawlers.into_iter().map(watched))
}

/// Collects into memory of its own: `collect` would keep that of the old, larger values.
fn exactly<T>(items: impl ExactSizeIterator<Item = T>) -> Vec<T> {
    let mut collected = Vec::with_capacity(items.len());
    collected.extend(items);
    collected
}

fn first<T>(pairs: Vec<(Explorer, T)>) -> Vec<Explorer> {
    exactly(pairs.into_iter().map(|(explorer, _)| explorer))
}

impl Learners {
    /// The learners of a stage, made from those of the one before, if any.
    ///
    /// # Panics
    /// When the stage cannot follow the one before: `stages` knows no such order, and learners that
    /// do not [suit](Self::suit) their stage are not restored.
    pub fn begin(
        before: Option<Self>,
        stage: &Stage,
        spec: &RunSpec,
        plan: &MemoryPlan,
        crew: &Crew,
    ) -> Self {
        let make = Maker {
            spec,
            plan,
            crew,
            parameters: plan.applied_to(&spec.controller.parameters),
        };
        let method = spec.controller.method;
        let explores = method.definition().explores;
        match (stage.phase, before) {
            (Phase::Babbling, None) => Learners::Babblers(make.babblers()),
            (Phase::Evolution, None) => Learners::Crawlers(make.crawlers(true)),
            (Phase::Exploration, None) if explores == Explores::Evolving => {
                Learners::Crawlers(make.crawlers(false))
            }
            (Phase::Exploration, None) if explores == Explores::Walking => make.walkers(),
            (Phase::Repository, Some(Learners::Crawlers(crawlers))) => {
                Learners::Replayers(make.replayers(crawlers))
            }
            (Phase::Exploration, Some(Learners::Replayers(replayers))) => {
                make.exploring(exactly(replayers.into_iter().map(Replayer::finish)))
            }
            (Phase::Exploration, Some(Learners::Babblers(babblers))) => {
                let watched = exactly(babblers.into_iter().map(|b| (b.finish(), ())));
                make.exploring(first(make.explorers(watched)))
            }
            (Phase::Exploration, Some(Learners::Crawlers(crawlers))) => {
                make.exploring(first(make.explorers(watched(crawlers))))
            }
            (phase, _) => unreachable!(
                "{} of `{}` in an order that `stages` does not know",
                phase.name(),
                method.name()
            ),
        }
    }

    /// Nobody, in place of learners of which the next are being made.
    pub fn nobody() -> Self {
        Learners::Brownian(Vec::new())
    }

    /// Gives robots that decide by a table other parameters of their decisions. All others take
    /// them when they come to that stage.
    pub fn retune(&mut self, p: &ControllerParameters) {
        match self {
            Learners::Former(never) => match *never {},
            Learners::Explorers(robots) => robots.iter_mut().for_each(|robot| robot.retune(p)),
            Learners::Replayers(robots) => robots.iter_mut().for_each(|robot| robot.retune(p)),
            Learners::SharedTable(robots) => robots.retune(p),
            Learners::Brownian(_)
            | Learners::Babblers(_)
            | Learners::Crawlers(_)
            | Learners::Walkers(_) => {}
        }
    }

    /// As [`Walkers::steer`].
    pub fn steer(&mut self, commands: &[[f32; WHEELS]]) {
        if let Self::Walkers(walkers) = self {
            walkers.steer(commands);
        }
    }

    /// Takes from the parameters what saved learners do not hold.
    pub fn set_up(&mut self, p: &ControllerParameters) {
        match self {
            Learners::Babblers(controllers) => controllers.iter_mut().for_each(|c| c.set_up(p)),
            Learners::Crawlers(controllers) => controllers.iter_mut().for_each(|c| c.set_up(p)),
            Learners::Replayers(controllers) => controllers.iter_mut().for_each(|c| c.set_up(p)),
            _ => {}
        }
    }

    /// Moves every robot `steps` times.
    pub fn advance(&mut self, world: &mut World, radio: Option<&mut Radio>, steps: u64) {
        match (self, radio) {
            (Learners::Former(never), _) => match *never {},
            (Learners::Brownian(controllers), _) => world.advance(controllers, steps),
            (Learners::Babblers(controllers), _) => world.advance(controllers, steps),
            (Learners::Crawlers(controllers), Some(radio)) => {
                world.advance_all(&mut RadioControllers { controllers, radio }, steps);
            }
            (Learners::Crawlers(controllers), None) => world.advance(controllers, steps),
            (Learners::Replayers(controllers), _) => world.advance(controllers, steps),
            (Learners::Explorers(controllers), Some(radio)) => {
                world.advance_all(&mut RadioControllers { controllers, radio }, steps);
            }
            (Learners::Explorers(controllers), None) => world.advance(controllers, steps),
            (Learners::SharedTable(robots), _) => world.advance_all(&mut **robots, steps),
            (Learners::Walkers(walkers), _) => walkers.advance(world, steps),
        }
    }

    /// Starts a trajectory where robots stand.
    pub fn begin_trajectory(&mut self, state: &WorldState) {
        match self {
            Learners::Explorers(controllers) => {
                for (controller, body) in controllers.iter_mut().zip(state.bodies.iter()) {
                    controller.begin_trajectory(&body.reading);
                }
            }
            Learners::Replayers(controllers) => {
                for (controller, body) in controllers.iter_mut().zip(state.bodies.iter()) {
                    controller.begin_trajectory(&body.reading);
                }
            }
            Learners::SharedTable(robots) => robots.begin_trajectory(&state.bodies),
            Learners::Walkers(walkers) => walkers.begin_epoch(&state.bodies),
            _ => {}
        }
    }

    /// Ends a trajectory from which something is learnt.
    pub fn end_trajectory(&mut self) {
        match self {
            Learners::Crawlers(controllers) => {
                controllers.iter_mut().for_each(Crawler::end_trajectory)
            }
            Learners::Replayers(controllers) => {
                controllers.iter_mut().for_each(Replayer::end_trajectory)
            }
            _ => {}
        }
    }

    /// Loads the next candidates of evolution.
    pub fn next_candidates(&mut self) {
        if let Learners::Crawlers(controllers) = self {
            controllers.iter_mut().for_each(Crawler::next_candidate);
        }
    }

    /// Whether the next epoch only shows the candidates.
    pub fn set_showing(&mut self, showing: bool) {
        if let Learners::Crawlers(controllers) = self {
            controllers
                .iter_mut()
                .for_each(|controller| controller.set_showing(showing));
        }
    }

    /// Sensori-motor clusters of the first robot, while it has them.
    pub fn sensori_motor_clusters(&self) -> Option<u32> {
        match self {
            Learners::Crawlers(controllers) => {
                controllers.first().map(Crawler::sensori_motor_clusters)
            }
            _ => None,
        }
    }

    /// Sensor and actuator clusters of the first robot; 0 where there are none.
    pub fn clusters(&self) -> (u32, u32) {
        let of = Codebook::counts;
        let clusters = match self {
            Learners::Crawlers(controllers) => {
                controllers.first().map(|p| (0, p.actuator_clusters()))
            }
            Learners::Replayers(controllers) => {
                controllers.first().map(|p| of(p.explorer().codebook()))
            }
            Learners::Explorers(controllers) => controllers.first().map(|p| of(p.codebook())),
            Learners::SharedTable(robots) => Some(of(robots.codebook())),
            _ => None,
        };
        clusters.unwrap_or((0, 0))
    }

    /// What the first robot knows, if it explores by a table.
    pub fn model(&self) -> Option<(&Codebook, &Repository)> {
        match self {
            Learners::Explorers(controllers) => {
                controllers.first().map(|p| (p.codebook(), p.repository()))
            }
            Learners::SharedTable(robots) => Some((robots.codebook(), robots.repository())),
            _ => None,
        }
    }

    /// Calls for each robot that knows states and actions, in the order of their numbers.
    pub fn each_decision(&self, each: &mut dyn FnMut(Decision)) {
        let of = |decider: &Decider| Decision {
            state: decider.state(),
            action: decider.action(),
        };
        match self {
            Learners::Replayers(controllers) => {
                let deciders = controllers.iter().map(|p| p.explorer().decider());
                deciders.for_each(|decider| each(of(decider)));
            }
            Learners::Explorers(controllers) => {
                let deciders = controllers.iter().map(Explorer::decider);
                deciders.for_each(|decider| each(of(decider)));
            }
            Learners::SharedTable(robots) => {
                robots
                    .deciders()
                    .iter()
                    .for_each(|decider| each(of(decider)));
            }
            _ => {}
        }
    }

    /// The table that a robot explores by, if it does.
    pub fn table(&self, robot: usize) -> Option<&Repository> {
        match self {
            Learners::Explorers(controllers) => controllers.get(robot).map(Explorer::repository),
            Learners::SharedTable(robots) => Some(robots.repository()),
            _ => None,
        }
    }

    /// Robots.
    pub fn robots(&self) -> usize {
        match self {
            Learners::Former(never) => match *never {},
            Learners::Brownian(controllers) => controllers.len(),
            Learners::Babblers(controllers) => controllers.len(),
            Learners::Crawlers(controllers) => controllers.len(),
            Learners::Replayers(controllers) => controllers.len(),
            Learners::Explorers(controllers) => controllers.len(),
            Learners::SharedTable(robots) => robots.robots(),
            Learners::Walkers(walkers) => walkers.len(),
        }
    }

    /// Bytes held in all, exactly counted.
    pub fn bytes(&self) -> u64 {
        match self {
            Learners::Former(never) => match *never {},
            Learners::Brownian(controllers) => size_of_val(&controllers[..]) as u64,
            Learners::Babblers(controllers) => controllers.iter().map(Babbler::bytes).sum(),
            Learners::Crawlers(controllers) => controllers.iter().map(Crawler::bytes).sum(),
            Learners::Replayers(controllers) => controllers.iter().map(Replayer::bytes).sum(),
            Learners::Explorers(controllers) => controllers.iter().map(Explorer::bytes).sum(),
            Learners::SharedTable(robots) => robots.bytes(),
            Learners::Walkers(walkers) => walkers.robot_bytes() * walkers.len() as u64,
        }
    }

    /// What each robot holds, messages included.
    pub fn memory(&self, plan: &MemoryPlan, sharing: &Sharing) -> Vec<RobotMemory> {
        let robot = |bytes, clusters_saturated| RobotMemory {
            bytes,
            clusters_saturated,
        };
        let told = match sharing {
            Sharing::Radio(link) => told_transitions(link, plan).bytes(),
            Sharing::None | Sharing::Arena => 0,
        };
        match self {
            Learners::Former(never) => match *never {},
            Learners::Brownian(controllers) => {
                vec![robot(size_of::<Brownian>() as u64, 0); controllers.len()]
            }
            Learners::Babblers(controllers) => controllers
                .iter()
                .map(|p| robot(p.bytes(), p.clusters_saturated()))
                .collect(),
            Learners::Crawlers(controllers) => controllers
                .iter()
                .map(|p| robot(p.bytes(), p.clusters_saturated()))
                .collect(),
            Learners::Replayers(controllers) => controllers
                .iter()
                .map(|p| robot(p.bytes(), p.explorer().clusters_saturated()))
                .collect(),
            Learners::Explorers(controllers) => controllers
                .iter()
                .map(|p| robot(p.bytes() + told, p.clusters_saturated()))
                .collect(),
            Learners::SharedTable(robots) => robots
                .clusters_saturated()
                .iter()
                .map(|saturated| robot(robots.robot_bytes(), *saturated))
                .collect(),
            Learners::Walkers(walkers) => vec![robot(walkers.robot_bytes(), 0); walkers.len()],
        }
    }
}
