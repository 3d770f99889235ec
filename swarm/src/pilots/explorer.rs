//! Phase 3: the Ev-ITER controller (Alg. 5, eq. 4.9), which is also `im` with an empty repository.

use serde::{Deserialize, Serialize};

use super::{Scaling, Watch};
use crate::lanes::F8;
use crate::learn::actuator_samples::ActuatorSamples;
use crate::learn::centres::Centres;
use crate::learn::kmeans::kmeans;
use crate::learn::repository::Repository;
use crate::pilot::Pilot;
use crate::random::{Stream, below, draw};
use crate::spec::{ControllerParameters, Ties};

/// A robot that explores by its transition table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Explorer {
    key: u64,
    /// eta on a scale of 2^16.
    eta: u32,
    hold_steps: u32,
    ties: Ties,
    scaling: Scaling,
    states: Centres<8>,
    actions: Centres<2>,
    samples: ActuatorSamples,
    repository: Repository,
    state: u32,
    action: u32,
    command: [f32; 2],
    /// Steps for which the command is still held.
    held_steps: u32,
}

impl Explorer {
    /// Phase 2 but for the replay: k-means over the sample with as many clusters as phase 1 found
    /// (section 4.3.2), and the commands that each action stands for.
    pub fn new(p: &ControllerParameters, key: u64, watch: &Watch, clustering: &mut Stream) -> Self {
        let vectors = watch.sample.sample();
        let sensors: Vec<[f32; 8]> = vectors
            .iter()
            .map(|v| std::array::from_fn(|k| v[k]))
            .collect();
        let commands: Vec<[f32; 2]> = vectors.iter().map(|v| [v[8], v[9]]).collect();
        let states = kmeans(&sensors, watch.sensors.len(), p, clustering).centres;
        let actions = kmeans(&commands, watch.actuators.len(), p, clustering).centres;
        let filling = Stream::new(clustering.bits());
        let mut samples = ActuatorSamples::new(&actions, p.actuator_sample, filling);
        for command in &commands {
            samples.offer(actions.nearest(command).0, *command);
        }
        let repository = Repository::new(states.len(), actions.len(), p);
        Self {
            key,
            eta: (p.eta * 65_536.0).round() as u32,
            hold_steps: p.action_hold_steps,
            ties: p.ties,
            scaling: Scaling::new(p.sensor_scale),
            states,
            actions,
            samples,
            repository,
            state: 0,
            action: 0,
            command: [0.0; 2],
            held_steps: 0,
        }
    }

    /// Starts a trajectory from the sensors read at its beginning.
    pub fn begin_trajectory(&mut self, raw: &F8) {
        self.held_steps = 0;
        self.state = self.states.nearest(&self.scaling.apply(raw)).0;
    }

    /// Notes a command that something else gave (phase 2).
    #[inline(always)]
    pub(super) fn watch_action(&mut self, command: [f32; 2]) {
        self.action = self.actions.nearest(&command).0;
    }

    /// Records where the last action led.
    #[inline(always)]
    pub(super) fn arrive(&mut self, raw: &F8) {
        let next = self.states.nearest(&self.scaling.apply(raw)).0;
        self.repository.record(self.state, self.action, next);
        self.state = next;
    }

    /// The action with the highest score (eq. 4.9), one of several by the rule for ties.
    #[inline(always)]
    fn best_action(&self, bits: u32) -> u32 {
        let (table, state) = (&self.repository, self.state);
        let first = table.best_action(state);
        if self.ties == Ties::First {
            return first;
        }
        let highest = table.score(state, first);
        if self.ties == Ties::Keep && table.score(state, self.action) == highest {
            return self.action;
        }
        let tied = || (first..table.actions()).filter(|j| table.score(state, *j) == highest);
        let place = below(bits, tied().count() as u32);
        tied().nth(place as usize).unwrap_or(first)
    }

    /// The transition table.
    pub fn repository(&self) -> &Repository {
        &self.repository
    }

    /// The state that raw sensor values belong to.
    pub(super) fn state_of(&self, raw: &F8) -> u32 {
        self.states.nearest(&self.scaling.apply(raw)).0
    }

    /// A command of an action, chosen by 32 uniform bits.
    pub(super) fn command_of(&self, action: u32, bits: u32) -> [f32; 2] {
        self.samples.draw(action, bits)
    }

    /// States and actions.
    pub fn clusters(&self) -> (u32, u32) {
        (self.states.len(), self.actions.len())
    }

    /// Bytes held, exactly counted.
    pub fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.states.bytes()
            + self.actions.bytes()
            + self.samples.bytes()
            + self.repository.bytes() as usize
    }
}

impl Pilot for Explorer {
    #[inline(always)]
    fn act(&mut self, step: u64, _raw: &F8) -> [f32; 2] {
        if self.held_steps > 0 {
            self.held_steps -= 1;
            return self.command;
        }
        let bits = draw(self.key, step);
        let (eta_bits, action_bits) = (bits as u32 & 0xFFFF, (bits >> 8) as u32 & !0xFF);
        let sample_bits = (bits >> 32) as u32 & !0xFF;
        let action = if self.repository.is_insufficient(self.state) {
            self.repository.deficient_action(self.state, action_bits)
        } else if eta_bits < self.eta {
            below(action_bits, self.repository.actions())
        } else {
            self.best_action(action_bits)
        };
        self.action = action;
        self.held_steps = self.hold_steps - 1;
        self.command = self.samples.draw(action, sample_bits);
        self.command
    }

    #[inline(always)]
    fn learn(&mut self, raw: &F8) {
        self.arrive(raw);
    }

    #[inline(always)]
    fn expect_acting(&self) {
        self.repository.expect_choice(self.state);
    }

    #[inline(always)]
    fn expect_learning(&self) {
        self.states.expect_search();
        self.repository.expect_record(self.state, self.action);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Site, stream_key};

    /// An explorer with one state and some actions, each tried alike: all scores are the same.
    fn explorer(ties: Ties) -> Explorer {
        let parameters = ControllerParameters {
            ties,
            lambda: 2,
            eta: 0.0,
            ..Default::default()
        };
        let key = stream_key(1, Site::Target, 0, Purpose::Action);
        let mut watch = Watch::new(&parameters, Stream::new(1));
        for n in 0..400_u32 {
            let command = [(n % 3) as f32 - 1.0, (n / 3 % 3) as f32 - 1.0];
            watch.observe(&[-1.0; 8], command);
        }
        let mut explorer = Explorer::new(&parameters, key, &watch, &mut Stream::new(2));
        for action in 0..explorer.clusters().1 {
            for _ in 0..parameters.lambda {
                explorer.repository.record(0, action, 0);
            }
        }
        explorer
    }

    /// Actions of some steps in which nothing changes.
    fn actions(ties: Ties) -> Vec<u32> {
        let mut explorer = explorer(ties);
        let act = |step| {
            explorer.act(step, &F8::splat(0.0));
            explorer.action
        };
        (0..200).map(act).collect()
    }

    #[test]
    fn ties_are_settled_by_the_rule() {
        assert!(actions(Ties::First).iter().all(|action| *action == 0));
        let kept = actions(Ties::Keep);
        assert!(kept.iter().all(|action| *action == kept[0]));
        let random = actions(Ties::Random);
        for action in 0..explorer(Ties::Random).clusters().1 {
            assert!(random.contains(&action), "{action} never taken");
        }
    }
}
