//! What a robot's learner may hold: caps of everything that grows, fitted to a budget in bytes.
//!
//! A plan has one dial, the number of states that a robot can tell apart; actions, lists, samples
//! and genomes follow from it. The largest dial that fits the budget in every phase is taken. What
//! is counted is all that a learner asks the allocator for, its own value included, at the worst
//! moment: while k-means runs, or while both genomes and table are held.

pub use crate::caps::MemoryPlan;
use crate::controllers::{Babbler, Codebook, Crawler, Explorer, Replayer, Watch};
use crate::dimensions::SENSORI_MOTOR;
use crate::learn::archive::Archive;
use crate::learn::repository::Repository;
use crate::methods::{Explores, Walkers, stages};
use crate::sharing::told::told_transitions;
use crate::spec::{ControllerParameters, Objective, RunSpec, Sharing};
use crate::stages::Phase;

/// RAM of the e-puck (dsPIC30F6014A), bytes.
pub const E_PUCK_BYTES: u64 = 8 * 1024;
/// RAM of the e-puck2 (STM32F407), bytes.
pub const E_PUCK2_BYTES: u64 = 192 * 1024;

/// Fewest states that a plan is made for.
const FEWEST_STATES: u32 = 4;
/// From here on no cap of any spec grows any more.
const MOST_STATES: u32 = 200_000;

/// No plan is as small as the budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the learner needs at least {smallest_bytes} bytes")]
pub struct BudgetTooSmall {
    /// The smallest budget that works.
    pub smallest_bytes: u64,
}

impl MemoryPlan {
    /// The plan of a spec: its parameters as they are without a budget, else the largest that fits.
    ///
    /// # Errors
    /// When even the smallest plan does not fit.
    pub fn of(spec: &RunSpec) -> Result<Self, BudgetTooSmall> {
        let Some(budget) = spec.memory_budget_bytes else {
            return Ok(Self::with_states(MOST_STATES, spec));
        };
        let smallest = Self::with_states(FEWEST_STATES, spec);
        if smallest.bytes > budget {
            return Err(BudgetTooSmall {
                smallest_bytes: smallest.bytes,
            });
        }
        // Caps, and so bytes, never shrink as the dial grows.
        let (mut fits, mut too_many) = (FEWEST_STATES, MOST_STATES + 1);
        while too_many - fits > 1 {
            let middle = fits + (too_many - fits) / 2;
            if Self::with_states(middle, spec).bytes <= budget {
                fits = middle;
            } else {
                too_many = middle;
            }
        }
        Ok(Self::with_states(fits, spec))
    }

    /// The plan of the dial at `states`. No cap exceeds what the parameters of the spec say.
    fn with_states(states: u32, spec: &RunSpec) -> Self {
        let p = &spec.controller.parameters;
        let training = spec.controller.training.as_ref();
        let states = u64::from(states);
        let cap = |wanted: u64, most: u32| wanted.min(u64::from(most)).max(1) as u32;
        let mut plan = Self {
            sensor_clusters: cap(states, p.max_clusters),
            actuator_clusters: cap((states * 2 / 3).max(3), p.max_clusters),
            sensori_motor_clusters: cap((states * 2).max(8), p.max_clusters),
            sample: cap((states * states / 4).max(states * 3), p.sample),
            actuator_sample: cap(states / 3, p.actuator_sample),
            lambda: cap((states * 5 / 3).max(8), p.lambda),
            genomes: cap(
                states * states / 64,
                training.map_or(1, |t| t.epochs.min(p.replay_genomes)),
            ),
            bytes: 0,
        };
        plan.bytes = most_bytes(&plan, spec);
        plan
    }

    /// The parameters with what the plan takes away taken away.
    pub fn applied_to(&self, p: &ControllerParameters) -> ControllerParameters {
        ControllerParameters {
            lambda: self.lambda,
            sample: self.sample,
            actuator_sample: self.actuator_sample,
            ..p.clone()
        }
    }
}

/// Most bytes that a robot of the spec holds in any stage, or between two.
fn most_bytes(plan: &MemoryPlan, spec: &RunSpec) -> u64 {
    let phases: Vec<Phase> = stages(spec, plan).iter().map(|stage| stage.phase).collect();
    let within = phases.iter().map(|phase| phase_bytes(*phase, plan, spec));
    let between = phases.windows(2).map(|pair| {
        if pair[0].watches() {
            clustering_bytes(pair[0], plan, spec)
        } else {
            0
        }
    });
    within.chain(between).max().unwrap_or(0)
}

fn phase_bytes(phase: Phase, plan: &MemoryPlan, spec: &RunSpec) -> u64 {
    let method = spec.controller.method.definition();
    let hears = matches!(spec.sharing, Sharing::Radio(_));
    let objective = method.objective.unwrap_or(Objective::Curiosity);
    match phase {
        Phase::Babbling => Babbler::bytes_for(plan),
        Phase::Evolution => Crawler::bytes_for(objective, plan, true, hears),
        Phase::Repository => Replayer::bytes_for(plan),
        Phase::Exploration => match method.explores {
            Explores::Walking => Walkers::robot_bytes_for(method.method),
            Explores::Evolving => Crawler::bytes_for(objective, plan, false, hears),
            Explores::ByTable => {
                let told = match &spec.sharing {
                    Sharing::Radio(link) => told_transitions(link, plan).bytes(),
                    Sharing::None | Sharing::Arena => 0,
                };
                Explorer::bytes_for(plan) + told
            }
        },
        Phase::Done => 0,
    }
}

/// From a phase that watched to the next: the watch is taken out, k-means runs, the watch goes and
/// the table comes, the learner of the next phase takes it over.
fn clustering_bytes(from: Phase, plan: &MemoryPlan, spec: &RunSpec) -> u64 {
    let shares = spec.sharing != Sharing::None;
    let (before, genomes) = if from == Phase::Babbling {
        (Babbler::bytes_for(plan), 0)
    } else {
        (
            phase_bytes(from, plan, spec),
            Archive::heap_bytes_for(plan.genomes),
        )
    };
    let watched = size_of::<(Watch, Archive)>() as u64;
    let explorer = size_of::<(Explorer, Archive)>() as u64;
    let pooled = if shares {
        u64::from(plan.sample) * size_of::<[f32; SENSORI_MOTOR]>() as u64
    } else {
        0
    };
    let watch = Watch::heap_bytes_for(plan) + pooled;
    let codebook = Codebook::heap_bytes_for(plan) * if shares { 2 } else { 1 };
    let table =
        Repository::heap_bytes_for(plan.sensor_clusters, plan.actuator_clusters, plan.lambda);
    let taking_out = before + watched;
    let clustering = watched + explorer + watch + genomes + Codebook::workspace_bytes(plan);
    let making = watched + explorer + genomes + codebook + table;
    let taking_over = explorer + size_of::<Replayer>() as u64 + genomes + codebook + table;
    taking_out.max(clustering).max(making).max(taking_over)
}

#[cfg(test)]
#[path = "memory_tests.rs"]
mod tests;
