//! The methods, a file each or a family: name, what it does, source, stages, what it shares, its
//! controller where it learns nothing. The rest of the program asks; it does not know methods.

mod braitenberg;
mod brownian;
mod definition;
mod ev_iter;
mod evolved;
mod external;
mod im;
mod levy;
#[cfg(test)]
mod tests;
mod walker;

use serde::{Deserialize, Serialize};

pub use braitenberg::WEIGHTS as BRAITENBERG_WEIGHTS;
pub use definition::{Definition, Explores, Trains};
pub use external::ExternalParameters;

use crate::bodies::Bodies;
use crate::caps::MemoryPlan;
use crate::controllers::Brownian;
use crate::dimensions::WHEELS;
use crate::spec::{Method, RunSpec};
use crate::stages::Stage;
use crate::world::World;
use braitenberg::Braitenberg;
use external::External;
use levy::Levy;
use walker::Walker;

impl Method {
    /// What it is.
    pub fn definition(self) -> &'static Definition {
        match self {
            Self::Brownian => &brownian::BROWNIAN,
            Self::Curiosity => &evolved::CURIOSITY,
            Self::CuriosityA => &evolved::CURIOSITY_A,
            Self::Discovery => &evolved::DISCOVERY,
            Self::DiscoveryA => &evolved::DISCOVERY_A,
            Self::Im => &im::IM,
            Self::EvIterC => &ev_iter::EV_ITER_C,
            Self::EvIterD => &ev_iter::EV_ITER_D,
            Self::EvIterCa => &ev_iter::EV_ITER_CA,
            Self::EvIterDa => &ev_iter::EV_ITER_DA,
            Self::Levy => &levy::LEVY,
            Self::Braitenberg => &braitenberg::BRAITENBERG,
            Self::External => &external::EXTERNAL,
        }
    }
}

/// Makes [`Walkers`] from methods and their controllers.
macro_rules! walkers {
    ($($method:ident: $controller:ty),+ $(,)?) => {
        /// All robots of a method that learns nothing. Saved state has the variants by their order.
        #[derive(Serialize, Deserialize)]
        pub(crate) enum Walkers {
            $($method(Vec<$controller>)),+
        }

        impl Walkers {
            /// The robots of a spec, whose action streams have these keys.
            ///
            /// # Panics
            /// When the method is none of these: those that learn have other learners.
            pub fn new(spec: &RunSpec, keys: impl ExactSizeIterator<Item = u64>) -> Self {
                match spec.controller.method {
                    $(Method::$method => Self::$method(
                        keys.map(|key| <$controller as Walker>::new(spec, key)).collect(),
                    ),)+
                    method => unreachable!("`{}` is no walk", method.name()),
                }
            }

            /// Bytes of a robot of a method; none for one that learns.
            pub fn robot_bytes_for(method: Method) -> u64 {
                match method {
                    $(Method::$method => size_of::<$controller>() as u64,)+
                    _ => 0,
                }
            }

            /// Whether they are those of a method.
            pub fn are_of(&self, method: Method) -> bool {
                match self {
                    $(Self::$method(_) => method == Method::$method),+
                }
            }

            /// Whether saved robots have numbers that can be reckoned with.
            pub fn are_sound(&self) -> bool {
                match self {
                    $(Self::$method(controllers) => controllers.iter().all(Walker::is_sound)),+
                }
            }

            /// Robots.
            pub fn len(&self) -> usize {
                match self {
                    $(Self::$method(controllers) => controllers.len()),+
                }
            }

            /// Bytes of a robot.
            pub fn robot_bytes(&self) -> u64 {
                match self {
                    $(Self::$method(_) => size_of::<$controller>() as u64),+
                }
            }

            /// Moves every robot `steps` times.
            pub fn advance(&mut self, world: &mut World, steps: u64) {
                match self {
                    $(Self::$method(controllers) => world.advance(controllers, steps)),+
                }
            }

            /// An epoch begins where robots stand.
            pub fn begin_epoch(&mut self, bodies: &Bodies) {
                match self {
                    $(Self::$method(controllers) => {
                        for (controller, body) in controllers.iter_mut().zip(bodies.iter()) {
                            controller.begin_epoch(body);
                        }
                    }),+
                }
            }
        }
    };
}

walkers! {
    Brownian: Brownian,
    Levy: Levy,
    Braitenberg: Braitenberg,
    External: External,
}

impl Walkers {
    /// Says what robots that are steered from outside do next; index is a robot's number. Does
    /// nothing to others.
    pub fn steer(&mut self, commands: &[[f32; WHEELS]]) {
        if let Self::External(controllers) = self {
            for (controller, command) in controllers.iter_mut().zip(commands) {
                controller.steer(*command);
            }
        }
    }
}

/// The stages of a spec under a memory plan, in order.
pub(crate) fn stages(spec: &RunSpec, plan: &MemoryPlan) -> Vec<Stage> {
    (spec.controller.method.definition().stages)(spec, plan)
}
