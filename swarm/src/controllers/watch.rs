//! What a robot keeps of what it senses and does before its states and actions are made.

use serde::{Deserialize, Serialize};

use super::scaling::sensori_motor;
use crate::caps::MemoryPlan;
use crate::dimensions::{PROXIMITY_SENSORS, SENSORI_MOTOR, WHEELS};
use crate::learn::epsilon_clustering::EpsilonClustering;
use crate::learn::reservoir::Reservoir;
use crate::random::Stream;
use crate::spec::ControllerParameters;

/// What phase 1 keeps for phase 2.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Watch {
    /// Clusters of sensor vectors; their number becomes that of the states.
    pub sensors: EpsilonClustering<PROXIMITY_SENSORS>,
    /// Clusters of commands; their number becomes that of the actions.
    pub actuators: EpsilonClustering<WHEELS>,
    /// A uniform sample of the sensori-motor vectors.
    pub sample: Reservoir<SENSORI_MOTOR>,
}

impl Watch {
    /// Nothing seen yet.
    pub fn new(p: &ControllerParameters, plan: &MemoryPlan, sampling: Stream) -> Self {
        Self {
            sensors: EpsilonClustering::new(
                p.cluster_radius(p.epsilon_sensor),
                plan.sensor_clusters,
            ),
            actuators: EpsilonClustering::new(
                p.cluster_radius(p.epsilon_actuator),
                plan.actuator_clusters,
            ),
            sample: Reservoir::new(plan.sample, sampling),
        }
    }

    /// Whether saved parts fit together, under these caps.
    pub fn is_sound(&self, plan: &MemoryPlan) -> bool {
        self.sensors.is_sound(plan.sensor_clusters)
            && self.actuators.is_sound(plan.actuator_clusters)
            && self.sample.is_sound(plan.sample)
    }

    /// Takes in a sensor vector and the command given in answer to it.
    #[inline(always)]
    pub fn observe(&mut self, sensors: &[f32; PROXIMITY_SENSORS], command: [f32; WHEELS]) {
        self.sensors.observe(sensors);
        self.actuators.observe(&command);
        self.sample.offer(&sensori_motor(sensors, command));
    }

    /// Vectors that found no room for a cluster of their own.
    pub fn saturated(&self) -> u64 {
        self.sensors.saturated() + self.actuators.saturated()
    }

    /// Bytes held besides the value itself.
    pub fn heap_bytes_for(plan: &MemoryPlan) -> u64 {
        EpsilonClustering::<PROXIMITY_SENSORS>::heap_bytes_for(plan.sensor_clusters)
            + EpsilonClustering::<WHEELS>::heap_bytes_for(plan.actuator_clusters)
            + Reservoir::<SENSORI_MOTOR>::heap_bytes_for(plan.sample)
    }

    /// Bytes held besides the value itself, exactly counted.
    pub fn heap_bytes(&self) -> u64 {
        self.sensors.heap_bytes() + self.actuators.heap_bytes() + self.sample.heap_bytes()
    }
}
