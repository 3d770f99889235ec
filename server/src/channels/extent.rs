//! How much there is to show of a run.

use swarm::methods::ExternalParameters;
use swarm::spec::{Method, RunSpec};

/// How much a run's frames show at most.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Robots.
    pub robots: usize,
    /// Movable objects, of the arena that has the most.
    pub objects: usize,
    /// Squares of the target arena.
    pub squares: usize,
    /// Programs that steer its robots.
    pub controllers: usize,
}

impl Extent {
    /// Of the runs of a spec.
    pub fn of(spec: &RunSpec) -> Self {
        let training = spec.controller.training.as_ref();
        let training = training.map_or(0, |training| training.arena.objects().len());
        let [columns, rows] = spec.arena.squares();
        let steered = spec.controller.method == Method::External;
        let controllers = steered.then(|| ExternalParameters::of(spec).controllers as usize);
        Self {
            robots: spec.robots as usize,
            objects: training.max(spec.arena.objects().len()),
            squares: columns as usize * rows as usize,
            controllers: controllers.unwrap_or(0),
        }
    }
}
