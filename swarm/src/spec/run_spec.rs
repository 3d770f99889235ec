//! What a run is made from: every field resolved, the arenas loaded.

use std::sync::Arc;

use arenas::Arena;

use super::controller::ControllerParameters;
use super::method::Method;
use super::method_parameters::MethodParameters;
use super::sharing::Sharing;
use crate::parameters::named_choice;
use crate::robot::RobotModel;

named_choice! {
    /// Where robots stand when an epoch starts.
    Placement {
        /// The arena's own start poses, in order.
        Start = "start",
        /// A grid around the first start pose, where a start pose can reach.
        Grid = "grid",
        /// Uniformly at random, never overlapping, where a start pose can reach.
        Random = "random",
        /// As `grid`, in closed rooms too.
        GridAnywhere = "grid-anywhere",
        /// As `random`, in closed rooms too.
        RandomAnywhere = "random-anywhere",
    }
}

impl Placement {
    /// The ways of placing, each within reach of a start pose.
    pub const KINDS: [&str; 3] = ["start", "grid", "random"];

    /// Its way of placing, within reach or anywhere.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Grid | Self::GridAnywhere => "grid",
            Self::Random | Self::RandomAnywhere => "random",
        }
    }

    /// Whether robots may stand where no start pose reaches.
    pub fn is_anywhere(self) -> bool {
        matches!(self, Self::GridAnywhere | Self::RandomAnywhere)
    }

    /// The same way of placing anywhere; `None` for start poses, which are where they are.
    pub fn anywhere(self) -> Option<Self> {
        match self {
            Self::Start => None,
            Self::Grid | Self::GridAnywhere => Some(Self::GridAnywhere),
            Self::Random | Self::RandomAnywhere => Some(Self::RandomAnywhere),
        }
    }
}

named_choice! {
    /// What happens between two epochs.
    Episodes {
        /// Every robot goes back to its start pose.
        Reset = "reset",
        /// Every robot goes on where it stands.
        Continue = "continue",
        /// Robots that evolve, or replay what evolved, go back; those that explore, babble or walk
        /// go on.
        ContinueExploring = "continue-exploring",
    }
}

impl Episodes {
    /// Whether robots go back between epochs, while they evolve or not.
    pub fn reset(self, evolving: bool) -> bool {
        match self {
            Self::Reset => true,
            Self::Continue => false,
            Self::ContinueExploring => evolving,
        }
    }
}

named_choice! {
    /// Which physics moves the robots.
    EngineKind {
        /// Exact differential-drive arcs; discs pushed out of walls and of each other.
        Kinematic = "kinematic",
        /// Rigid bodies of rapier2d.
        Rapier = "rapier",
    }
}

/// The training part of a controller.
#[derive(Clone, Debug)]
pub struct Training {
    /// Arena in which phase 1, or the evolution of a baseline, happens.
    pub arena: Arc<Arena>,
    /// Epochs of phase 1. Evolved baselines evolve for the run's own epochs and ignore this.
    pub epochs: u32,
}

/// How a robot learns.
#[derive(Clone, Debug)]
pub struct ControllerSpec {
    /// The method.
    pub method: Method,
    /// Parameters that methods have in common.
    pub parameters: ControllerParameters,
    /// Those that the method alone has.
    pub own: MethodParameters,
    /// Where it trains; `None` for methods without training.
    pub training: Option<Training>,
}

/// Everything that a run is made from; [`RunSpec::validate`] checks it.
#[derive(Clone, Debug)]
pub struct RunSpec {
    /// Seed of every random stream.
    pub seed: u64,
    /// Target arena: where visits count.
    pub arena: Arc<Arena>,
    /// How the robots learn.
    pub controller: ControllerSpec,
    /// Counted epochs.
    pub epochs: u32,
    /// Control steps an epoch.
    pub steps_per_epoch: u32,
    /// Robots in the arena.
    pub robots: u32,
    /// Where they start.
    pub placement: Placement,
    /// What happens between epochs.
    pub episodes: Episodes,
    /// The robot's body, wheels and sensors.
    pub robot: RobotModel,
    /// The physics.
    pub engine: EngineKind,
    /// Most bytes that each robot's learner may hold; `None` for no budget.
    pub memory_budget_bytes: Option<u64>,
    /// What robots share of what they learn.
    pub sharing: Sharing,
}

impl RunSpec {
    /// A run of one robot with every default; methods that train need a `training` besides.
    pub fn new(method: Method, arena: Arc<Arena>) -> Self {
        Self {
            seed: 1,
            arena,
            controller: ControllerSpec {
                method,
                parameters: ControllerParameters::default(),
                own: MethodParameters::default(),
                training: None,
            },
            epochs: 2_000,
            steps_per_epoch: 2_000,
            robots: 1,
            placement: Placement::Start,
            episodes: Episodes::Reset,
            robot: RobotModel::default(),
            engine: EngineKind::Kinematic,
            memory_budget_bytes: None,
            sharing: Sharing::None,
        }
    }

    /// Whether all phases happen on line in the target arena: robots that go on where they stand
    /// when an epoch ends, and whose training arena is the target.
    pub fn is_on_line(&self) -> bool {
        let training = self.controller.training.as_ref();
        self.episodes == Episodes::Continue
            && training.is_some_and(|training| *training.arena == *self.arena)
    }
}
