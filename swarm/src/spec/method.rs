//! The methods by which robots are controlled, and what their evolution is for.

use super::controller::StatesFrom;
use crate::parameters::named_choice;

named_choice! {
    /// How a robot is controlled.
    Method {
        /// Each command uniform in the action space.
        Brownian = "brownian",
        /// Evolved for the entropy of sensori-motor data (eq. 4.5).
        Curiosity = "curiosity",
        /// Evolved for the entropy of actuator data.
        CuriosityA = "curiosity-a",
        /// Evolved for the differential entropy of sensori-motor data (eq. 4.6).
        Discovery = "discovery",
        /// Evolved for the differential entropy of actuator data.
        DiscoveryA = "discovery-a",
        /// Intrinsic motivation: the phase-3 controller with an empty repository.
        Im = "im",
        /// Ev-ITER after a phase 1 of `curiosity`.
        EvIterC = "ev-iter-c",
        /// Ev-ITER after a phase 1 of `discovery`.
        EvIterD = "ev-iter-d",
        /// Ev-ITER after a phase 1 of `curiosity-a`.
        EvIterCa = "ev-iter-ca",
        /// Ev-ITER after a phase 1 of `discovery-a`.
        EvIterDa = "ev-iter-da",
    }
}

named_choice! {
    /// What phase 1 evolves for.
    Objective {
        /// Entropy of sensori-motor data (eq. 4.5).
        Curiosity = "curiosity",
        /// Entropy of actuator data.
        CuriosityA = "curiosity-a",
        /// Differential entropy of sensori-motor data (eq. 4.6).
        Discovery = "discovery",
        /// Differential entropy of actuator data.
        DiscoveryA = "discovery-a",
    }
}

impl Objective {
    /// Whether it is computed over sensori-motor data rather than actuator data.
    #[inline(always)]
    pub fn over_sensori_motor(self) -> bool {
        matches!(self, Objective::Curiosity | Objective::Discovery)
    }
}

impl Method {
    /// What its phase 1, or the baseline itself, evolves for; `None` where nothing evolves.
    pub fn objective(self) -> Option<Objective> {
        match self {
            Method::Curiosity | Method::EvIterC => Some(Objective::Curiosity),
            Method::CuriosityA | Method::EvIterCa => Some(Objective::CuriosityA),
            Method::Discovery | Method::EvIterD => Some(Objective::Discovery),
            Method::DiscoveryA | Method::EvIterDa => Some(Objective::DiscoveryA),
            Method::Brownian | Method::Im => None,
        }
    }

    /// Whether it trains in an arena of its own before, or while, it explores.
    pub fn trains(self, states_from: StatesFrom) -> bool {
        match self {
            Method::Brownian => false,
            Method::Im => states_from == StatesFrom::Phase1,
            _ => true,
        }
    }

    /// Whether it ends with the phase-3 controller.
    pub fn explores(self) -> bool {
        self != Method::Brownian && !self.is_evolved_baseline()
    }

    /// Whether it is one of the evolved baselines, which evolve all along.
    pub fn is_evolved_baseline(self) -> bool {
        use Method::{Curiosity, CuriosityA, Discovery, DiscoveryA};
        matches!(self, Curiosity | CuriosityA | Discovery | DiscoveryA)
    }
}
