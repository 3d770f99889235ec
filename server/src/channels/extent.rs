//! How much there is to show of a run.

use swarm::spec::RunSpec;

/// How much a run's frames show at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Robots.
    pub robots: usize,
    /// Movable objects, of the arena that has the most.
    pub objects: usize,
}

impl Extent {
    /// Of the runs of a spec.
    pub fn of(spec: &RunSpec) -> Self {
        let training = spec.controller.training.as_ref();
        let training = training.map_or(0, |training| training.arena.objects().len());
        Self {
            robots: spec.robots as usize,
            objects: training.max(spec.arena.objects().len()),
        }
    }
}
