//! How well the first robot knows what its actions lead to (section 4.3.4).

use super::machine::Run;
use super::venue::TARGET;
use crate::controllers::{Reference, Scaling};
use crate::learn::accuracy::{Divergence, divergence};
use crate::random::{Purpose, Site, stream_key};
use crate::world::World;

/// Most steps of random actions that the reference is estimated from, a hundred epochs of the thesis;
/// a run that counts fewer steps has a reference of as many.
const REFERENCE_STEPS: u64 = 200_000;
/// Added to every count of the reference (Jeffreys): a transition that it has not seen is rare, not
/// impossible.
const SMOOTHING: f64 = 0.5;

impl Run {
    /// Divergence of the first robot's transition table from a reference that random actions give,
    /// alone in the target arena; `None` where it has no table.
    pub fn model_accuracy(&self) -> Option<Divergence> {
        let (codebook, table) = self.learners.model()?;
        let (spec, venue) = (&self.spec, &self.venues[TARGET]);
        let start = *venue.starts.first()?;
        let mut world = World::new(
            &venue.ground,
            &spec.robot,
            spec.engine,
            vec![start],
            spec.seed,
            Site::Target,
        );
        let key = stream_key(spec.seed, Site::Target, 0, Purpose::Reference);
        let scaling = Scaling::new(spec.controller.parameters.clusters_see());
        let mut controllers = [Reference::new(codebook, scaling, key)];
        let counted = u64::from(spec.epochs) * u64::from(spec.steps_per_epoch);
        let mut left = REFERENCE_STEPS.min(counted);
        while left > 0 {
            world.reset();
            controllers[0].begin_trajectory(&world.state().bodies[0].reading);
            let steps = left.min(u64::from(spec.steps_per_epoch));
            world.advance(&mut controllers, steps);
            left -= steps;
        }
        let reference = controllers[0].counts();
        Some(divergence(table, reference, SMOOTHING))
    }
}
