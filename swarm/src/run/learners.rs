//! All robots' learners in the stage that a run is in, and how one stage's become the next's.

use serde::{Deserialize, Serialize};

use super::plan::StageKind;
use crate::lanes::F8;
use crate::pilots::{Babbler, Brownian, Crawler, Explorer, Replayer, Scaling, Watch};
use crate::random::{Purpose, Site, Stream, stream_key};
use crate::spec::{Objective, RunSpec};
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

    fn watch(&self, spec: &RunSpec) -> Watch {
        Watch::new(
            &spec.controller.parameters,
            self.stream(Site::Training, Purpose::Sampling),
        )
    }

    fn explorer(&self, spec: &RunSpec, watch: &Watch) -> Explorer {
        let mut clustering = self.stream(Site::Training, Purpose::Clustering);
        let key = self.key(Site::Target, Purpose::Action);
        Explorer::new(&spec.controller.parameters, key, watch, &mut clustering)
    }
}

impl Learners {
    /// The learners of the next stage, made from those of the last.
    pub fn begin(self, kind: StageKind, spec: &RunSpec) -> Self {
        let seed = spec.seed;
        let streams = (0..u64::from(spec.robots)).map(|robot| Streams { seed, robot });
        let p = &spec.controller.parameters;
        let crawlers = |watching: bool| {
            let objective = spec
                .controller
                .method
                .objective()
                .unwrap_or(Objective::Curiosity);
            let crawler = |s: Streams| {
                let evolution = s.stream(Site::Training, Purpose::Evolution);
                Crawler::new(objective, p, evolution, watching.then(|| s.watch(spec)))
            };
            Learners::Crawlers(streams.clone().map(crawler).collect())
        };
        match (kind, self) {
            (StageKind::Babble, _) => {
                let babbler = |s: Streams| {
                    let brownian = Brownian::new(s.key(Site::Target, Purpose::Action));
                    Babbler::new(brownian, Scaling::new(p.sensor_scale), s.watch(spec))
                };
                Learners::Babblers(streams.map(babbler).collect())
            }
            (StageKind::Evolve, _) => crawlers(true),
            (StageKind::EvolveInTarget | StageKind::EvolveAndShow, _) => crawlers(false),
            (StageKind::Replay, Learners::Crawlers(crawlers)) => {
                let replayer = |(s, crawler): (Streams, Crawler)| {
                    let (watch, archive) = crawler.finish();
                    let watch = watch.unwrap_or_else(|| s.watch(spec));
                    let explorer = s.explorer(spec, &watch);
                    Replayer::new(p.slope, Scaling::new(p.sensor_scale), archive, explorer)
                };
                Learners::Replayers(streams.zip(crawlers).map(replayer).collect())
            }
            (StageKind::Explore, Learners::Replayers(replayers)) => {
                Learners::Explorers(replayers.into_iter().map(Replayer::finish).collect())
            }
            (StageKind::Explore, Learners::Babblers(babblers)) => {
                let explorer = |(s, b): (Streams, Babbler)| s.explorer(spec, &b.finish());
                Learners::Explorers(streams.zip(babblers).map(explorer).collect())
            }
            (StageKind::Explore, Learners::Crawlers(crawlers)) => {
                let explorer = |(s, crawler): (Streams, Crawler)| {
                    let watch = crawler.finish().0.unwrap_or_else(|| s.watch(spec));
                    s.explorer(spec, &watch)
                };
                Learners::Explorers(streams.zip(crawlers).map(explorer).collect())
            }
            (StageKind::Explore | StageKind::Replay, _) => {
                let key = |s: Streams| Brownian::new(s.key(Site::Target, Purpose::Action));
                Learners::Brownian(streams.map(key).collect())
            }
        }
    }

    /// Moves every robot `steps` times.
    pub fn advance(&mut self, world: &mut World, steps: u64) {
        match self {
            Learners::Idle => {}
            Learners::Brownian(pilots) => world.advance(pilots, steps),
            Learners::Babblers(pilots) => world.advance(pilots, steps),
            Learners::Crawlers(pilots) => world.advance(pilots, steps),
            Learners::Replayers(pilots) => world.advance(pilots, steps),
            Learners::Explorers(pilots) => world.advance(pilots, steps),
        }
    }

    /// Starts a trajectory where robots stand.
    pub fn begin_trajectory(&mut self, state: &WorldState) {
        match self {
            Learners::Explorers(pilots) => {
                for (pilot, body) in pilots.iter_mut().zip(&state.bodies) {
                    pilot.begin_trajectory(&F8(body.sensors));
                }
            }
            Learners::Replayers(pilots) => {
                for (pilot, body) in pilots.iter_mut().zip(&state.bodies) {
                    pilot.begin_trajectory(&F8(body.sensors));
                }
            }
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
        let clusters = match self {
            Learners::Crawlers(pilots) => pilots.first().map(|p| (0, p.actuator_clusters())),
            Learners::Replayers(pilots) => pilots.first().map(|p| p.explorer().clusters()),
            Learners::Explorers(pilots) => pilots.first().map(Explorer::clusters),
            _ => None,
        };
        clusters.unwrap_or((0, 0))
    }

    /// The first robot's explorer, if it is one.
    pub fn explorer(&self) -> Option<&Explorer> {
        match self {
            Learners::Explorers(pilots) => pilots.first(),
            _ => None,
        }
    }

    /// Pilots.
    pub fn len(&self) -> usize {
        match self {
            Learners::Idle => 0,
            Learners::Brownian(pilots) => pilots.len(),
            Learners::Babblers(pilots) => pilots.len(),
            Learners::Crawlers(pilots) => pilots.len(),
            Learners::Replayers(pilots) => pilots.len(),
            Learners::Explorers(pilots) => pilots.len(),
        }
    }

    /// Bytes held, exactly counted.
    pub fn bytes(&self) -> usize {
        match self {
            Learners::Idle => 0,
            Learners::Brownian(pilots) => size_of_val(&pilots[..]),
            Learners::Babblers(pilots) => pilots.iter().map(Babbler::bytes).sum(),
            Learners::Crawlers(pilots) => pilots.iter().map(Crawler::bytes).sum(),
            Learners::Replayers(pilots) => pilots.iter().map(Replayer::bytes).sum(),
            Learners::Explorers(pilots) => pilots.iter().map(Explorer::bytes).sum(),
        }
    }
}
