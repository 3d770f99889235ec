//! All robots' learners in the stage that a run is in, and how one stage's become the next's.

use serde::{Deserialize, Serialize};

use super::plan::StageKind;
use super::types::RobotMemory;
use crate::lanes::F8;
use crate::learn::archive::Archive;
use crate::learn::repository::Repository;
use crate::memory::MemoryPlan;
use crate::pilots::{
    Babbler, Brownian, Codebook, Crawler, Explorer, Replayer, Scaling, Team, Watch,
};
use crate::random::{Purpose, Site, Stream, stream_key};
use crate::sharing::pool::pool;
use crate::sharing::radio::{Radio, Talkers};
use crate::sharing::{Sharing, told_transitions};
use crate::spec::{ControllerParameters, Objective, RunSpec};
use crate::world::{World, WorldState};

/// One pilot a robot, all of the kind that the stage asks for.
#[derive(Serialize, Deserialize)]
pub(super) enum Learners {
    /// Before the first stage.
    Idle,
    Brownian(Vec<Brownian>),
    Babblers(Vec<Babbler>),
    Crawlers(Vec<Crawler>),
    Replayers(Vec<Replayer>),
    Explorers(Vec<Explorer>),
    /// Explorers with one table.
    Team(Box<Team>),
}

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
        let scaling = Scaling::new(self.parameters.sensor_scale);
        let babbler = |robot: Streams| {
            let brownian = Brownian::new(robot.key(Site::Target, Purpose::Action));
            Babbler::new(brownian, scaling, self.watch(&robot))
        };
        self.robots().map(babbler).collect()
    }

    fn crawlers(&self, watching: bool) -> Vec<Crawler> {
        let objective = self.spec.controller.method.objective();
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
    fn explorers<T>(&self, watched: Vec<(Watch, T)>) -> Vec<(Explorer, T)> {
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
        exactly(self.robots().zip(watched).map(explorer))
    }

    /// The learners of phase 3.
    fn exploring(&self, explorers: Vec<Explorer>) -> Learners {
        if self.spec.sharing == Sharing::Arena {
            Team::new(&self.parameters, explorers)
                .map_or(Learners::Idle, |team| Learners::Team(Box::new(team)))
        } else {
            Learners::Explorers(explorers)
        }
    }
}

/// What the crawlers of a phase 1 leave; every one of them watched.
fn watched(crawlers: Vec<Crawler>) -> Vec<(Watch, Archive)> {
    let mut watched = Vec::with_capacity(crawlers.len());
    watched.extend(crawlers.into_iter().filter_map(Crawler::finish));
    watched
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
    /// The learners of the next stage, made from those of the last.
    pub fn begin(self, kind: StageKind, spec: &RunSpec, plan: &MemoryPlan) -> Self {
        let make = Maker {
            spec,
            plan,
            parameters: plan.applied_to(&spec.controller.parameters),
        };
        match (kind, self) {
            (StageKind::Babble, _) => Learners::Babblers(make.babblers()),
            (StageKind::Evolve, _) => Learners::Crawlers(make.crawlers(true)),
            (StageKind::EvolveInTarget | StageKind::EvolveAndShow, _) => {
                Learners::Crawlers(make.crawlers(false))
            }
            (StageKind::Replay, Learners::Crawlers(crawlers)) => {
                let p = &make.parameters;
                let replayer = |(explorer, archive)| {
                    Replayer::new(p.slope, Scaling::new(p.sensor_scale), archive, explorer)
                };
                let explorers = make.explorers(watched(crawlers));
                Learners::Replayers(exactly(explorers.into_iter().map(replayer)))
            }
            (StageKind::Explore, Learners::Replayers(replayers)) => {
                make.exploring(exactly(replayers.into_iter().map(Replayer::finish)))
            }
            (StageKind::Explore, Learners::Babblers(babblers)) => {
                let watched = exactly(babblers.into_iter().map(|b| (b.finish(), ())));
                make.exploring(first(make.explorers(watched)))
            }
            (StageKind::Explore, Learners::Crawlers(crawlers)) => {
                make.exploring(first(make.explorers(watched(crawlers))))
            }
            (StageKind::Explore | StageKind::Replay, _) => {
                let key = |robot: Streams| Brownian::new(robot.key(Site::Target, Purpose::Action));
                Learners::Brownian(make.robots().map(key).collect())
            }
        }
    }

    /// Moves every robot `steps` times.
    pub fn advance(&mut self, world: &mut World, radio: Option<&mut Radio>, steps: u64) {
        match (self, radio) {
            (Learners::Idle, _) => {}
            (Learners::Brownian(pilots), _) => world.advance(pilots, steps),
            (Learners::Babblers(pilots), _) => world.advance(pilots, steps),
            (Learners::Crawlers(pilots), Some(radio)) => {
                world.advance_crew(&mut Talkers { pilots, radio }, steps);
            }
            (Learners::Crawlers(pilots), None) => world.advance(pilots, steps),
            (Learners::Replayers(pilots), _) => world.advance(pilots, steps),
            (Learners::Explorers(pilots), Some(radio)) => {
                world.advance_crew(&mut Talkers { pilots, radio }, steps);
            }
            (Learners::Explorers(pilots), None) => world.advance(pilots, steps),
            (Learners::Team(team), _) => world.advance_crew(&mut **team, steps),
        }
    }

    /// Starts a trajectory where robots stand.
    pub fn begin_trajectory(&mut self, state: &WorldState) {
        match self {
            Learners::Explorers(pilots) => {
                for (pilot, body) in pilots.iter_mut().zip(state.bodies.iter()) {
                    pilot.begin_trajectory(&F8(body.sensors));
                }
            }
            Learners::Replayers(pilots) => {
                for (pilot, body) in pilots.iter_mut().zip(state.bodies.iter()) {
                    pilot.begin_trajectory(&F8(body.sensors));
                }
            }
            Learners::Team(team) => team.begin_trajectory(&state.bodies),
            _ => {}
        }
    }

    /// Ends a trajectory from which something is learnt.
    pub fn end_trajectory(&mut self) {
        match self {
            Learners::Crawlers(pilots) => pilots.iter_mut().for_each(Crawler::end_trajectory),
            Learners::Replayers(pilots) => pilots.iter_mut().for_each(Replayer::end_trajectory),
            _ => {}
        }
    }

    /// Loads the next candidates of evolution.
    pub fn next_candidates(&mut self) {
        if let Learners::Crawlers(pilots) = self {
            pilots.iter_mut().for_each(Crawler::next_candidate);
        }
    }

    /// Whether the next epoch only shows the candidates.
    pub fn set_showing(&mut self, showing: bool) {
        if let Learners::Crawlers(pilots) = self {
            pilots
                .iter_mut()
                .for_each(|pilot| pilot.set_showing(showing));
        }
    }

    /// Sensori-motor clusters of the first robot, while it has them.
    pub fn sensori_motor_clusters(&self) -> Option<u32> {
        match self {
            Learners::Crawlers(pilots) => pilots.first().map(Crawler::sensori_motor_clusters),
            _ => None,
        }
    }

    /// Sensor and actuator clusters of the first robot; 0 where there are none.
    pub fn clusters(&self) -> (u32, u32) {
        let of = |codebook: &Codebook| (codebook.states.len(), codebook.actions.len());
        let clusters = match self {
            Learners::Crawlers(pilots) => pilots.first().map(|p| (0, p.actuator_clusters())),
            Learners::Replayers(pilots) => pilots.first().map(|p| of(p.explorer().codebook())),
            Learners::Explorers(pilots) => pilots.first().map(|p| of(p.codebook())),
            Learners::Team(team) => Some(of(team.codebook())),
            _ => None,
        };
        clusters.unwrap_or((0, 0))
    }

    /// What the first robot knows, if it explores by a table.
    pub fn model(&self) -> Option<(&Codebook, &Repository)> {
        match self {
            Learners::Explorers(pilots) => pilots.first().map(|p| (p.codebook(), p.repository())),
            Learners::Team(team) => Some((team.codebook(), team.repository())),
            _ => None,
        }
    }

    /// Robots.
    pub fn robots(&self) -> usize {
        match self {
            Learners::Idle => 0,
            Learners::Brownian(pilots) => pilots.len(),
            Learners::Babblers(pilots) => pilots.len(),
            Learners::Crawlers(pilots) => pilots.len(),
            Learners::Replayers(pilots) => pilots.len(),
            Learners::Explorers(pilots) => pilots.len(),
            Learners::Team(team) => team.robots(),
        }
    }

    /// Bytes held in all, exactly counted.
    pub fn bytes(&self) -> u64 {
        match self {
            Learners::Idle => 0,
            Learners::Brownian(pilots) => size_of_val(&pilots[..]) as u64,
            Learners::Babblers(pilots) => pilots.iter().map(Babbler::bytes).sum(),
            Learners::Crawlers(pilots) => pilots.iter().map(Crawler::bytes).sum(),
            Learners::Replayers(pilots) => pilots.iter().map(Replayer::bytes).sum(),
            Learners::Explorers(pilots) => pilots.iter().map(Explorer::bytes).sum(),
            Learners::Team(team) => team.bytes(),
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
            Learners::Idle => Vec::new(),
            Learners::Brownian(pilots) => {
                vec![robot(size_of::<Brownian>() as u64, 0); pilots.len()]
            }
            Learners::Babblers(pilots) => pilots
                .iter()
                .map(|p| robot(p.bytes(), p.clusters_saturated()))
                .collect(),
            Learners::Crawlers(pilots) => pilots
                .iter()
                .map(|p| robot(p.bytes(), p.clusters_saturated()))
                .collect(),
            Learners::Replayers(pilots) => pilots
                .iter()
                .map(|p| robot(p.bytes(), p.explorer().clusters_saturated()))
                .collect(),
            Learners::Explorers(pilots) => pilots
                .iter()
                .map(|p| robot(p.bytes() + told, p.clusters_saturated()))
                .collect(),
            Learners::Team(team) => team
                .clusters_saturated()
                .iter()
                .map(|saturated| robot(team.robot_bytes(), *saturated))
                .collect(),
        }
    }
}
