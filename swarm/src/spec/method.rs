//! The methods by which robots are controlled (what each is: `methods/`), and what their evolution is
//! for.

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
        /// Levy walk: straight steps of power-law lengths, uniform turns.
        Levy = "levy",
        /// Braitenberg vehicle: each wheel's speed a weighted sum of what the sensors read.
        Braitenberg = "braitenberg",
        /// A program outside the simulator decides.
        External = "external",
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
