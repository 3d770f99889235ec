//! The choice of an action by Alg. 5 (eq. 4.9), whoever owns codebook and table.

use serde::{Deserialize, Serialize};

use super::codebook::Codebook;
use super::scaling::Scaling;
use crate::bodies::Reading;
use crate::dimensions::WHEELS;
use crate::learn::are_sound;
use crate::learn::repository::Repository;
use crate::learn::transition::Transition;
use crate::random::{below, draw};
use crate::spec::{ControllerParameters, Ties};

/// In place of a command's place: the last command is held.
const HELD: u32 = u32::MAX;

/// Where a robot stands in its table: all of a phase-3 learner but codebook and table.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Decider {
    key: u64,
    /// eta on a scale of 2^16.
    eta: u32,
    hold_steps: u32,
    ties: Ties,
    scaling: Scaling,
    /// The last transition; from the choice of an action to where it leads, its `next` is the place of
    /// the command among the samples, or [`HELD`].
    last: Transition,
    state: u32,
    pub(super) action: u32,
    command: [f32; WHEELS],
    /// Steps for which the command is still held.
    held_steps: u32,
}

/// A probability on a scale of 2^16.
fn scaled(probability: f64) -> u32 {
    (probability * 65_536.0).round() as u32
}

impl Decider {
    /// A robot that has seen nothing; `key` is that of its choices.
    pub fn new(p: &ControllerParameters, key: u64) -> Self {
        Self {
            key,
            eta: scaled(p.eta),
            hold_steps: p.action_hold_steps,
            ties: p.ties,
            scaling: Scaling::new(p.clusters_see()),
            last: Transition::default(),
            state: 0,
            action: 0,
            command: [0.0; WHEELS],
            held_steps: 0,
        }
    }

    /// Takes the parameters of decisions from another set.
    pub fn retune(&mut self, p: &ControllerParameters) {
        self.eta = scaled(p.eta);
        self.hold_steps = p.action_hold_steps;
        self.ties = p.ties;
        self.held_steps = self.held_steps.min(p.action_hold_steps - 1);
    }

    /// Whether what was saved stands in such a table.
    pub fn is_sound(&self, codebook: &Codebook) -> bool {
        let (states, actions) = codebook.counts();
        self.hold_steps > 0
            && [self.state, self.last.state].iter().all(|i| *i < states)
            && [self.action, self.last.action].iter().all(|j| *j < actions)
            && self.last.next < states
            && are_sound(&self.command)
    }

    /// Starts a trajectory from the sensors read at its beginning.
    pub fn begin_trajectory(&mut self, codebook: &Codebook, reading: &Reading) {
        self.held_steps = 0;
        self.state = codebook.states.nearest(&self.scaling.apply(reading)).0;
    }

    /// Chooses the next action and one of its commands, by Alg. 5, and asks for that.
    #[inline(always)]
    pub fn choose(&mut self, codebook: &Codebook, repository: &Repository, step: u64) {
        if self.held_steps > 0 {
            self.held_steps -= 1;
            self.last.next = HELD;
            return;
        }
        let bits = draw(self.key, step);
        let (eta_bits, action_bits) = (bits as u32 & 0xFFFF, (bits >> 8) as u32 & !0xFF);
        let sample_bits = (bits >> 32) as u32 & !0xFF;
        let action = if repository.is_insufficient(self.state) {
            repository.deficient_action(self.state, action_bits)
        } else if eta_bits < self.eta {
            below(action_bits, repository.actions())
        } else {
            self.best_action(repository, action_bits)
        };
        self.action = action;
        self.held_steps = self.hold_steps - 1;
        self.last.next = codebook.samples.place(action, sample_bits);
        codebook.samples.expect_command(self.last.next);
    }

    /// The command that was chosen.
    #[inline(always)]
    pub fn act(&mut self, codebook: &Codebook) -> [f32; WHEELS] {
        if self.last.next != HELD {
            self.command = codebook.samples.command(self.last.next);
        }
        self.command
    }

    /// The action with the highest score (eq. 4.9), one of several by the rule for ties.
    #[inline(always)]
    fn best_action(&self, table: &Repository, bits: u32) -> u32 {
        let state = self.state;
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

    /// Where the last action led.
    #[inline(always)]
    pub fn arrive(&mut self, codebook: &Codebook, reading: &Reading) -> Transition {
        let next = codebook.states.nearest(&self.scaling.apply(reading)).0;
        self.last = Transition {
            state: self.state,
            action: self.action,
            next,
        };
        self.state = next;
        self.last
    }

    /// The present state.
    #[inline(always)]
    pub fn state(&self) -> u32 {
        self.state
    }

    /// The action last chosen.
    #[inline(always)]
    pub fn action(&self) -> u32 {
        self.action
    }

    /// What followed the last action.
    pub fn last(&self) -> Transition {
        self.last
    }
}
