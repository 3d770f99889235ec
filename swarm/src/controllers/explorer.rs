//! Phase 3: the Ev-ITER controller (Alg. 5, eq. 4.9), which is also `im` with an empty repository.

use serde::{Deserialize, Serialize};

use super::codebook::Codebook;
use super::controller::Controller;
use super::decider::Decider;
use crate::bodies::Reading;
use crate::caps::MemoryPlan;
use crate::dimensions::WHEELS;
use crate::learn::repository::Repository;
use crate::learn::transition::Transition;
use crate::spec::ControllerParameters;

/// A robot that explores by a transition table of its own.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Explorer {
    decider: Decider,
    codebook: Codebook,
    repository: Repository,
    clusters_saturated: u64,
}

impl Explorer {
    /// A robot with an empty table; `clusters_saturated` is what phase 1 counted.
    pub fn new(
        p: &ControllerParameters,
        key: u64,
        codebook: Codebook,
        clusters_saturated: u64,
    ) -> Self {
        Self {
            decider: Decider::new(p, key),
            repository: Repository::new(codebook.states.len(), codebook.actions.len(), p),
            codebook,
            clusters_saturated,
        }
    }

    /// Whether saved parts fit together.
    pub fn is_sound(&self) -> bool {
        self.repository.is_sound()
            && self.codebook.counts() == (self.repository.states(), self.repository.actions())
            && self.decider.is_sound(&self.codebook)
    }

    /// Takes the parameters of decisions from another set.
    pub fn retune(&mut self, p: &ControllerParameters) {
        self.decider.retune(p);
        self.repository.retune(p);
    }

    /// Starts a trajectory from the sensors read at its beginning.
    pub fn begin_trajectory(&mut self, reading: &Reading) {
        self.decider.begin_trajectory(&self.codebook, reading);
    }

    /// Notes a command that something else gave (phase 2).
    #[inline(always)]
    pub(super) fn watch_action(&mut self, command: [f32; WHEELS]) {
        self.decider.action = self.codebook.actions.nearest(&command).0;
    }

    /// Records where the last action led.
    #[inline(always)]
    pub(super) fn arrive(&mut self, reading: &Reading) {
        let transition = self.decider.arrive(&self.codebook, reading);
        self.record(transition);
    }

    /// Takes a transition into the table, its own or one that another robot told.
    #[inline(always)]
    pub fn record(&mut self, t: Transition) {
        self.repository.record(t.state, t.action, t.next);
    }

    /// Where it stands.
    pub fn decider(&self) -> &Decider {
        &self.decider
    }

    /// Its states, actions and commands.
    pub fn codebook(&self) -> &Codebook {
        &self.codebook
    }

    /// The transition table.
    pub fn repository(&self) -> &Repository {
        &self.repository
    }

    /// Vectors of phase 1 that found no room for a cluster of their own.
    pub fn clusters_saturated(&self) -> u64 {
        self.clusters_saturated
    }

    /// Its parts.
    pub fn into_parts(self) -> (Decider, Codebook, Repository, u64) {
        (
            self.decider,
            self.codebook,
            self.repository,
            self.clusters_saturated,
        )
    }

    /// Most bytes held.
    pub fn bytes_for(plan: &MemoryPlan) -> u64 {
        let (states, actions) = (plan.sensor_clusters, plan.actuator_clusters);
        size_of::<Self>() as u64
            + Codebook::heap_bytes_for(plan)
            + Repository::heap_bytes_for(states, actions, plan.lambda)
    }

    /// Bytes held, exactly counted.
    pub fn bytes(&self) -> u64 {
        size_of::<Self>() as u64 + self.codebook.heap_bytes() + self.repository.heap_bytes()
    }
}

impl Controller for Explorer {
    const IS_LARGE: bool = true;

    #[inline(always)]
    fn choose(&mut self, step: u64, _reading: &Reading) {
        self.decider.choose(&self.codebook, &self.repository, step);
    }

    #[inline(always)]
    fn act(&mut self, _step: u64, _reading: &Reading) -> [f32; WHEELS] {
        self.decider.act(&self.codebook)
    }

    #[inline(always)]
    fn learn(&mut self, reading: &Reading) {
        self.arrive(reading);
    }

    #[inline(always)]
    fn expect_acting(&self) {
        self.repository.expect_choice(self.decider.state());
        self.codebook.samples.expect_choice();
    }

    #[inline(always)]
    fn expect_learning(&self) {
        self.codebook.states.expect_search();
        self.repository
            .expect_record(self.decider.state(), self.decider.action());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Site, Stream, stream_key};
    use crate::spec::{Insufficiency, Ties};

    const ACTIONS: u32 = 9;

    /// Actions of some steps in one state in which nothing changes, so that all scores are the same.
    fn actions(ties: Ties) -> Vec<u32> {
        let parameters = ControllerParameters {
            ties,
            insufficiency: Insufficiency::EveryAction,
            lambda: 2,
            eta: 0.0,
            action_hold_steps: 1,
            ..Default::default()
        };
        let key = stream_key(1, Site::Target, 0, Purpose::Action);
        let vectors: Vec<[f32; 10]> = (0..400_u32)
            .map(|n| {
                let mut vector = [-1.0; 10];
                (vector[8], vector[9]) = ((n % 3) as f32 - 1.0, (n / 3 % 3) as f32 - 1.0);
                vector
            })
            .collect();
        let codebook = Codebook::new(&parameters, &vectors, (1, ACTIONS), &mut Stream::new(2));
        let mut explorer = Explorer::new(&parameters, key, codebook, 0);
        for action in 0..ACTIONS {
            for _ in 0..parameters.lambda {
                explorer.record(Transition {
                    state: 0,
                    action,
                    next: 0,
                });
            }
        }
        let act = |step| {
            explorer.choose(step, &Reading::default());
            explorer.act(step, &Reading::default());
            explorer.decider().action()
        };
        (0..200).map(act).collect()
    }

    #[test]
    fn ties_are_settled_by_the_rule() {
        assert!(actions(Ties::First).iter().all(|action| *action == 0));
        let kept = actions(Ties::Keep);
        assert!(kept.iter().all(|action| *action == kept[0]));
        let random = actions(Ties::Random);
        for action in 0..ACTIONS {
            assert!(random.contains(&action), "{action} never taken");
        }
    }
}
