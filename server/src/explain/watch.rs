//! Watches robots while a run is stepped: how long each stays within 1 mm, and within 5 cm.

use std::collections::BTreeSet;

use swarm::run::{Phase, Run, Witness};
use swarm::world::Body;

use super::kind::Kind;
use super::stretch::{Pair, Stretch};

/// Robots that are watched: the first so many.
pub const MOST_ROBOTS: usize = 1_000;
/// Stretches that are told of each sort.
const LONGEST: usize = 10;
/// Steps from which on a robot stays.
const LEAST_STEPS: [u64; 2] = [100, 400];
/// How far a robot may come from where a stretch began, metres.
const RADII_M: [f32; 2] = [0.001, 0.05];
/// Steps after which scores are looked at, and each time that these have doubled.
const LOOK_AT: u64 = 128;

/// A stretch that is over.
#[derive(Clone, Debug)]
pub struct Told {
    /// The robot.
    pub robot: u32,
    /// What it was doing.
    pub kind: Kind,
    /// The stretch.
    pub stretch: Stretch,
}

/// Sees every step of a run.
pub struct Watcher {
    robots: usize,
    /// Of each robot, the stretch within each radius.
    stretches: Vec<[Stretch; 2]>,
    pairs: Vec<Option<Pair>>,
    /// The longest within each radius.
    pub longest: [Vec<Told>; 2],
    /// Counted robot-steps that were watched.
    pub steps: u64,
    /// Of these, those in stretches of each kind.
    pub in_kind: [u64; Kind::ALL.len()],
    /// Counted epochs in which a robot stayed so.
    pub epochs: [BTreeSet<u64>; Kind::ALL.len()],
    /// Counted epochs.
    pub epochs_seen: u64,
}

impl Watcher {
    /// Of a run that is about to be stepped.
    pub fn new(run: &Run) -> Self {
        let robots = run.robots().len().min(MOST_ROBOTS);
        let stretches = run.robots().iter().take(robots).map(|body| {
            let stretch = Stretch::begin(body, 0);
            [stretch.clone(), stretch]
        });
        Self {
            robots,
            stretches: stretches.collect(),
            pairs: vec![None; robots],
            longest: [Vec::new(), Vec::new()],
            steps: 0,
            in_kind: [0; Kind::ALL.len()],
            epochs: Default::default(),
            epochs_seen: 0,
        }
    }

    fn decisions(&mut self, run: &Run) {
        let mut robot = 0;
        let pairs = &mut self.pairs;
        run.each_decision(&mut |decision| {
            if let Some(pair) = pairs.get_mut(robot) {
                *pair = Some((decision.state, decision.action));
            }
            robot += 1;
        });
        if robot == 0 {
            pairs.fill(None);
        }
    }

    /// Ends the stretch of a robot within a radius.
    fn close(&mut self, robot: usize, which: usize, epoch: u64) {
        let stretch = &self.stretches[robot][which];
        if stretch.steps < LEAST_STEPS[which] {
            return;
        }
        let is_still = which == 0;
        let kind = stretch.kind(is_still);
        let place = Kind::ALL
            .iter()
            .position(|known| *known == kind)
            .unwrap_or(0);
        // A robot that stands is within the larger place too: it counts as standing.
        if is_still || !self.mostly_still(robot) {
            self.in_kind[place] += stretch.steps;
            self.epochs[place].insert(epoch);
        } else {
            return;
        }
        let longest = &mut self.longest[which];
        longest.push(Told {
            robot: robot as u32,
            kind,
            stretch: stretch.clone(),
        });
        longest.sort_by_key(|told| std::cmp::Reverse(told.stretch.steps));
        longest.truncate(LONGEST);
    }

    /// Whether a robot hardly drove in the stretch within the larger radius.
    fn mostly_still(&self, robot: usize) -> bool {
        let stretch = &self.stretches[robot][1];
        stretch.driven_m() < 0.001 * stretch.steps as f64 * 0.5
    }

    /// Ends what is going on at the end of the run.
    pub fn end(&mut self, run: &Run) {
        let epoch = run.place().arena_epoch;
        for robot in 0..self.robots {
            for which in [0, 1] {
                self.close(robot, which, epoch.saturating_sub(1));
            }
        }
    }
}

impl Witness for Watcher {
    fn every_steps(&self) -> u32 {
        1
    }

    fn see(&mut self, run: &Run) {
        // Only where visits count: what robots do while they learn is meant to be odd.
        if run.progress().phase != Phase::Exploration || run.is_in_training() {
            return;
        }
        let place = run.place();
        let step = run.step();
        if place.step == 0 {
            let end = place.arena_epoch.saturating_sub(1);
            for robot in 0..self.robots {
                for which in [0, 1] {
                    if self.epochs_seen > 0 {
                        self.close(robot, which, end);
                    }
                    self.stretches[robot][which].begin_again(&run.robots()[robot], step);
                }
            }
            self.epochs_seen += 1;
            return;
        }
        self.decisions(run);
        self.steps += self.robots as u64;
        for robot in 0..self.robots {
            let body: &Body = &run.robots()[robot];
            let pair = self.pairs[robot];
            for which in [0, 1] {
                let stretch = &mut self.stretches[robot][which];
                if stretch.distance2_m2(body) > RADII_M[which] * RADII_M[which] {
                    self.close(robot, which, place.arena_epoch);
                    self.stretches[robot][which].begin_again(body, step);
                    continue;
                }
                stretch.add(body, pair);
                let steps = stretch.steps;
                if which == 0 && steps >= LOOK_AT && steps.is_power_of_two() {
                    let scores =
                        pair.and_then(|(state, _)| Some((state, run.scores(robot, state)?)));
                    self.stretches[robot][0].scores = scores;
                }
            }
        }
    }
}
