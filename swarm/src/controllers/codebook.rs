//! What phase 2 makes of what a robot saw: its states, its actions, and the commands of each action.

use serde::{Deserialize, Serialize};

use crate::backend::{Backend, Compiled};
use crate::caps::MemoryPlan;
use crate::dimensions::{PROXIMITY_SENSORS, SENSORI_MOTOR, WHEELS};
use crate::learn::actuator_samples::ActuatorSamples;
use crate::learn::centres::Centres;
use crate::learn::kmeans::{self, Part, Points, kmeans};
use crate::random::Stream;
use crate::spec::ControllerParameters;

/// States, actions and commands. Tables of robots with the same codebook can be shared.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Saved")]
pub struct Codebook {
    /// Centres of the states.
    pub states: Centres<PROXIMITY_SENSORS>,
    /// Centres of the actions.
    pub actions: Centres<WHEELS>,
    /// Commands of each action.
    pub samples: ActuatorSamples,
}

/// The same as saved, which may not fit together.
#[derive(Deserialize)]
struct Saved {
    states: Centres<PROXIMITY_SENSORS>,
    actions: Centres<WHEELS>,
    samples: ActuatorSamples,
}

impl TryFrom<Saved> for Codebook {
    type Error = &'static str;

    fn try_from(saved: Saved) -> Result<Self, Self::Error> {
        let Saved {
            states,
            actions,
            samples,
        } = saved;
        if actions.len() != samples.clusters() {
            return Err("actions and their samples differ in number");
        }
        Ok(Self {
            states,
            actions,
            samples,
        })
    }
}

impl Codebook {
    /// k-means over a sample of sensori-motor vectors (not empty), with `states` and `actions` clusters
    /// as phase 1 found them (section 4.3.2).
    pub fn new(
        p: &ControllerParameters,
        vectors: &[[f32; SENSORI_MOTOR]],
        clusters: (u32, u32),
        clustering: &mut Stream,
    ) -> Self {
        Backend::detect().run(Making {
            p,
            vectors,
            clusters,
            clustering,
        })
    }

    /// States and actions.
    pub fn counts(&self) -> (u32, u32) {
        (self.states.len(), self.actions.len())
    }

    /// Most bytes that making one takes, itself included, the sample not.
    pub fn workspace_bytes(plan: &MemoryPlan) -> u64 {
        let states =
            kmeans::workspace_bytes::<PROXIMITY_SENSORS>(plan.sample, plan.sensor_clusters);
        let actions = Centres::<PROXIMITY_SENSORS>::heap_bytes_for(plan.sensor_clusters)
            + kmeans::workspace_bytes::<WHEELS>(plan.sample, plan.actuator_clusters);
        states.max(actions).max(Self::heap_bytes_for(plan))
    }

    /// Most bytes held besides the value itself.
    pub fn heap_bytes_for(plan: &MemoryPlan) -> u64 {
        Centres::<PROXIMITY_SENSORS>::heap_bytes_for(plan.sensor_clusters)
            + Centres::<WHEELS>::heap_bytes_for(plan.actuator_clusters)
            + ActuatorSamples::heap_bytes_for(plan.actuator_clusters, plan.actuator_sample)
    }

    /// Bytes held besides the value itself, exactly counted.
    pub fn heap_bytes(&self) -> u64 {
        self.states.heap_bytes() + self.actions.heap_bytes() + self.samples.heap_bytes()
    }
}

/// What a codebook is made from.
struct Making<'a> {
    p: &'a ControllerParameters,
    vectors: &'a [[f32; SENSORI_MOTOR]],
    clusters: (u32, u32),
    clustering: &'a mut Stream,
}

impl Compiled for Making<'_> {
    type Output = Codebook;

    #[inline(always)]
    fn run(self) -> Codebook {
        let Self {
            p,
            vectors,
            clusters: (states, actions),
            clustering,
        } = self;
        let (sensors, commands) = (
            Part::<SENSORI_MOTOR, 0>(vectors),
            Part::<SENSORI_MOTOR, PROXIMITY_SENSORS>(vectors),
        );
        let states = kmeans::<PROXIMITY_SENSORS>(sensors, states, p, clustering).centres;
        let actions = kmeans::<WHEELS>(commands, actions, p, clustering).centres;
        let filling = Stream::new(clustering.bits());
        let mut samples = ActuatorSamples::new(&actions, p.actuator_sample, filling);
        for command in commands.each() {
            samples.offer(actions.nearest(&command).0, command);
        }
        Codebook {
            states,
            actions,
            samples,
        }
    }
}
