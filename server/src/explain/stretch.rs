//! A stretch of steps in which a robot stayed within a small place.

use swarm::world::Body;

use super::kind::Kind;

/// Pairs of state and action that are counted in a stretch; rarer ones are not told apart.
const MOST_PAIRS: usize = 64;
/// Commands below this are as good as none, of 1.
const NO_COMMAND: f32 = 0.02;
/// A reading from which on a wall is close.
const CLOSE: f32 = 200.0;

/// A state and an action.
pub type Pair = (u32, u32);

/// What a robot did in a stretch so far.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Where it began, metres.
    pub at_m: [f32; 2],
    /// When it began: steps of the arena, over all phases.
    pub from_step: u64,
    /// Steps of it.
    pub steps: u64,
    turned_rad: f64,
    driven_m: f64,
    commanded: u64,
    close: u64,
    /// How often each state with each action, and how often the action was another than before.
    pub pairs: Vec<(Pair, u64)>,
    pub switches: u64,
    last: Option<u32>,
    /// State and the score and tries of each of its actions, in the middle of the stretch.
    pub scores: Option<(u32, Vec<(f32, u32)>)>,
    body: [f32; 4],
}

impl Stretch {
    /// Begins where a robot is.
    pub fn begin(body: &Body, step: u64) -> Self {
        Self {
            at_m: [body.x_m, body.y_m],
            from_step: step,
            steps: 0,
            turned_rad: 0.0,
            driven_m: 0.0,
            commanded: 0,
            close: 0,
            pairs: Vec::new(),
            switches: 0,
            last: None,
            scores: None,
            body: [body.x_m, body.y_m, body.cos, body.sin],
        }
    }

    /// Begins again, with the room that it has.
    pub fn begin_again(&mut self, body: &Body, step: u64) {
        let mut pairs = std::mem::take(&mut self.pairs);
        pairs.clear();
        *self = Self {
            pairs,
            ..Self::begin(body, step)
        };
    }

    /// Squared distance of a robot from where the stretch began.
    pub fn distance2_m2(&self, body: &Body) -> f32 {
        let (dx_m, dy_m) = (body.x_m - self.at_m[0], body.y_m - self.at_m[1]);
        dx_m * dx_m + dy_m * dy_m
    }

    /// Takes a step in.
    pub fn add(&mut self, body: &Body, pair: Option<Pair>) {
        let [x_m, y_m, cos, sin] = self.body;
        let sine = cos * body.sin - sin * body.cos;
        // Turns of a step are far below a quarter of a turn.
        self.turned_rad += f64::from(sine.abs());
        let (dx_m, dy_m) = (body.x_m - x_m, body.y_m - y_m);
        self.driven_m += f64::from((dx_m * dx_m + dy_m * dy_m).sqrt());
        self.body = [body.x_m, body.y_m, body.cos, body.sin];
        let commanded = body
            .command
            .iter()
            .any(|command| command.abs() > NO_COMMAND);
        self.commanded += u64::from(commanded);
        let is_close = body.reading.proximity.iter().any(|value| *value > CLOSE);
        self.close += u64::from(is_close);
        self.steps += 1;
        let Some(pair) = pair else { return };
        self.switches += u64::from(self.last.is_some_and(|last| last != pair.1));
        self.last = Some(pair.1);
        match self.pairs.iter().position(|(known, _)| *known == pair) {
            Some(place) => self.pairs[place].1 += 1,
            None if self.pairs.len() < MOST_PAIRS => self.pairs.push((pair, 1)),
            None => {}
        }
    }

    /// What the robot was doing.
    pub fn kind(&self, is_still: bool) -> Kind {
        let steps = self.steps.max(1) as f64;
        let close = self.close as f64 / steps > 0.8;
        if !is_still {
            return if close {
                Kind::WallDancing
            } else {
                Kind::Circling
            };
        }
        if (self.commanded as f64) < 0.1 * steps {
            Kind::Resting
        } else if self.turned_rad / steps > 0.01 {
            Kind::Spinning
        } else if close {
            Kind::Wedged
        } else {
            Kind::Standing
        }
    }

    /// Way driven, metres.
    pub fn driven_m(&self) -> f64 {
        self.driven_m
    }

    /// Whole turns, in either direction.
    pub fn turns(&self) -> f64 {
        self.turned_rad / std::f64::consts::TAU
    }
}
