//! An arena with its robots: the target, and where a method trains elsewhere first, another.

use std::sync::Arc;

use arenas::Arena;
use nalgebra::Point2;

use crate::bodies::StartPose;
use crate::caps::MemoryPlan;
use crate::crew::Crew;
use crate::placement::place;
use crate::random::{Purpose, Site, stream_key};
use crate::sharing::radio::Radio;
use crate::spec::{FieldError, Placement, RunSpec, Sharing};
use crate::stages::Stage;
use crate::validate::ValidSpec;
use crate::world::{Ground, World};

pub(super) const TARGET: usize = 0;
pub(super) const TRAINING: usize = 1;

/// An arena with its robots and what is needed to make them anew.
pub(super) struct Venue {
    pub ground: Ground,
    pub starts: Vec<StartPose>,
    pub site: Site,
    pub world: World,
    /// Where robots share by radio.
    pub radio: Option<Radio>,
}

/// The arenas that robots are put into.
pub(super) fn sites<'a>(
    spec: &'a RunSpec,
    stages: &[Stage],
) -> impl Iterator<Item = (&'a Arc<Arena>, Site)> + use<'a> {
    let trains = stages.iter().any(|stage| stage.site == Site::Training);
    let training = spec.controller.training.as_ref().filter(|_| trains);
    let training = training.map(|training| (&training.arena, Site::Training));
    std::iter::once((&spec.arena, Site::Target)).chain(training)
}

fn starts(spec: &RunSpec, ground: &Ground, site: Site) -> Result<Vec<StartPose>, FieldError> {
    place(
        &ground.arena,
        &spec.robot,
        &ground.index,
        spec.placement,
        spec.robots,
        spec.seed,
        site,
    )
    .map_err(|error| match site {
        Site::Target => error,
        Site::Training => FieldError {
            message: format!("{} (training arena)", error.message),
            ..error
        },
    })
}

/// Whether the robots of a valid spec can be put into its arenas. Fewer robots always fit where
/// more do, and only random placement depends on the seed.
///
/// # Errors
/// When they cannot; says how many can.
pub fn check_placement(spec: &ValidSpec) -> Result<(), FieldError> {
    sites(spec, spec.stages()).try_for_each(|(arena, site)| {
        let ground = Ground::new(Arc::clone(arena), &spec.robot);
        starts(spec, &ground, site).map(drop)
    })
}

impl Venue {
    pub fn new(
        spec: &RunSpec,
        memory: &MemoryPlan,
        arena: &Arc<Arena>,
        site: Site,
    ) -> Result<Self, FieldError> {
        let ground = Ground::new(Arc::clone(arena), &spec.robot);
        let starts = starts(spec, &ground, site)?;
        let world = World::new(
            &ground,
            &spec.robot,
            spec.engine,
            starts.clone(),
            spec.seed,
            site,
        );
        let radio = match &spec.sharing {
            Sharing::Radio(link) => Some(Radio::new(
                link,
                memory,
                spec.robots as usize,
                (arena.width_m(), arena.height_m()),
                stream_key(spec.seed, site, 0, Purpose::Radio),
            )),
            Sharing::None | Sharing::Arena => None,
        };
        Ok(Self {
            ground,
            starts,
            site,
            world,
            radio,
        })
    }

    /// Where the robots start, in full precision where that is a start pose of the arena.
    pub fn start_positions(&self, spec: &RunSpec) -> Vec<Point2<f64>> {
        let of_arena = match spec.placement {
            Placement::Start => self.starts.len(),
            Placement::Grid | Placement::GridAnywhere => 1,
            Placement::Random | Placement::RandomAnywhere => 0,
        };
        let poses = self.ground.arena.starts().iter().take(of_arena);
        let placed = self.starts.iter().skip(of_arena);
        poses
            .map(arenas::Pose::position)
            .chain(placed.map(|pose| Point2::new(pose.x_m.into(), pose.y_m.into())))
            .collect()
    }

    /// Starts over, noise and all, as if the arena had never been used.
    pub fn begin_again(&mut self, spec: &RunSpec, crew: &Crew) {
        let starts = self.starts.clone();
        self.world = World::new(
            &self.ground,
            &spec.robot,
            spec.engine,
            starts,
            spec.seed,
            self.site,
        );
        self.world.set_crew(crew);
    }
}
