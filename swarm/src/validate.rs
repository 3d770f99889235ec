//! Checks that a run spec makes a robot, arenas and methods that go together.

use std::ops::Deref;

use arenas::Arena;

use crate::caps::MemoryPlan;
use crate::memory::BudgetTooSmall;
use crate::methods::{Explores, stages};
use crate::placement::enough_starts;
use crate::spec::{
    EngineKind, FieldError, LEAST_BYTES_PER_STEP, MAX_EPOCHS, MAX_ROBOTS, MAX_STEPS_PER_EPOCH,
    MOST_BYTES_PER_STEP, Placement, RunSpec, Sharing,
};
use crate::stages::{Stage, arena_epochs};

fn error(pointer: &str, message: impl Into<String>, allowed: impl Into<String>) -> FieldError {
    FieldError {
        pointer: pointer.into(),
        message: message.into(),
        allowed: allowed.into(),
    }
}

/// A spec that was checked, with what follows from it. Only [`RunSpec::validate`] makes one.
#[derive(Clone, Debug)]
pub struct ValidSpec {
    spec: RunSpec,
    memory: MemoryPlan,
    stages: Vec<Stage>,
}

impl ValidSpec {
    /// The same with another seed.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.spec.seed = seed;
        self
    }

    /// What each robot's learner may hold.
    pub fn memory_plan(&self) -> &MemoryPlan {
        &self.memory
    }

    /// Robot-steps that a run takes, uncounted phases included.
    pub fn robot_steps(&self) -> u64 {
        let spec = &self.spec;
        arena_epochs(&self.stages) * u64::from(spec.steps_per_epoch) * u64::from(spec.robots)
    }

    pub(crate) fn stages(&self) -> &[Stage] {
        &self.stages
    }

    pub(crate) fn into_parts(self) -> (RunSpec, MemoryPlan, Vec<Stage>) {
        (self.spec, self.memory, self.stages)
    }
}

impl Deref for ValidSpec {
    type Target = RunSpec;

    fn deref(&self) -> &RunSpec {
        &self.spec
    }
}

impl RunSpec {
    /// Checks that the spec can run, but for whether its robots fit into the arenas, which is for
    /// [`crate::run::check_placement`] to say.
    ///
    /// # Errors
    /// Everything that is wrong with the spec.
    pub fn validate(self) -> Result<ValidSpec, Vec<FieldError>> {
        let memory = MemoryPlan::of(&self);
        let errors = self.errors(memory.as_ref().err());
        match memory {
            Ok(memory) if errors.is_empty() => Ok(ValidSpec {
                stages: stages(&self, &memory),
                memory,
                spec: self,
            }),
            _ => Err(errors),
        }
    }

    fn errors(&self, budget: Option<&BudgetTooSmall>) -> Vec<FieldError> {
        let mut errors = Vec::new();
        let mut range = |pointer: &str, value: u32, max: u32| {
            if value == 0 || value > max {
                errors.push(error(
                    pointer,
                    format!("{value} is out of range"),
                    format!("a whole number from 1 to {max}"),
                ));
            }
        };
        range("/epochs", self.epochs, MAX_EPOCHS);
        range(
            "/steps_per_epoch",
            self.steps_per_epoch,
            MAX_STEPS_PER_EPOCH,
        );
        range("/robots", self.robots, MAX_ROBOTS);
        if let Some(training) = &self.controller.training {
            range("/controller/train/epochs", training.epochs, MAX_EPOCHS);
        }
        let controller = &self.controller;
        let method = controller.method.definition();
        if method.trains.with(controller.parameters.states_from) && controller.training.is_none() {
            errors.push(error(
                "/controller/train",
                format!("`{}` needs a training arena", controller.method.name()),
                "an object with arena and epochs",
            ));
        }
        errors.extend((method.check)(self));
        self.check_sharing(&mut errors);
        errors.extend(budget.map(|too_small| self.budget_error(too_small)));
        self.check_robot(&mut errors);
        self.check_arena(&self.arena, "/arena", &mut errors);
        if let Some(training) = &self.controller.training {
            self.check_arena(&training.arena, "/controller/train/arena", &mut errors);
        }
        errors
    }

    fn check_sharing(&self, errors: &mut Vec<FieldError>) {
        let method = self.controller.method;
        let explores = method.definition().explores;
        if self.sharing != Sharing::None && explores == Explores::Walking {
            errors.push(error(
                "/sharing/mode",
                format!("`{}` learns nothing that could be shared", method.name()),
                "none, or a method that learns",
            ));
        }
        if self.sharing == Sharing::Arena && explores == Explores::Evolving {
            errors.push(error(
                "/sharing/mode",
                format!("`{}` has no repository", method.name()),
                "none, radio, or a method with a repository",
            ));
        }
        if let Sharing::Radio(link) = &self.sharing {
            if !link
                .range_m
                .is_none_or(|range_m| (0.0..=100.0).contains(&range_m))
            {
                errors.push(error(
                    "/sharing/range_m",
                    "is out of range",
                    "a number from 0 to 100, or null for no limit",
                ));
            }
            if !(LEAST_BYTES_PER_STEP..=MOST_BYTES_PER_STEP).contains(&link.bytes_per_step) {
                errors.push(error(
                    "/sharing/bytes_per_step",
                    format!("{} is out of range", link.bytes_per_step),
                    format!("a whole number from {LEAST_BYTES_PER_STEP} to {MOST_BYTES_PER_STEP}"),
                ));
            }
        }
    }

    fn budget_error(&self, too_small: &BudgetTooSmall) -> FieldError {
        error(
            "/memory_budget_bytes",
            format!(
                "{} bytes are too few for `{}`",
                self.memory_budget_bytes.unwrap_or(0),
                self.controller.method.name()
            ),
            format!("at least {} bytes, or null", too_small.smallest_bytes),
        )
    }

    fn check_robot(&self, errors: &mut Vec<FieldError>) {
        let p = &self.robot.parameters;
        let (step_m, radius_m) = (self.robot.max_step_m(), p.body_radius_m);
        if step_m > 0.5 * radius_m {
            errors.push(error(
                "/robot/max_wheel_speed_rad_s",
                format!("at top speed a step covers {step_m:.4} m, too far to meet walls safely"),
                format!(
                    "at most half the body radius a step: {:.2} rad/s with this wheel and step_s",
                    0.5 * radius_m / (p.wheel_radius_m * (1.0 + p.wheel_slip) * p.step_s)
                ),
            ));
        }
        let turn_rad = self.robot.max_turn_rad();
        if turn_rad > 1.5 {
            errors.push(error(
                "/robot/axle_m",
                format!("at top speed a step turns {turn_rad:.2} rad"),
                "at most 1.5 rad a step: a wider axle, slower wheels or a shorter step_s",
            ));
        }
        if self.robot.sensor_reach_m() > 2.0 {
            errors.push(error(
                "/robot/response",
                format!("sensors reach {:.2} m", self.robot.sensor_reach_m()),
                "at most 2 m",
            ));
        }
    }

    fn check_arena(&self, arena: &Arena, pointer: &str, errors: &mut Vec<FieldError>) {
        let radius_m = self.robot.parameters.body_radius_m;
        errors.extend(
            arena
                .check_starts(radius_m)
                .into_iter()
                .take(100)
                .map(|e| FieldError {
                    pointer: format!("{pointer}{}", e.pointer),
                    message: e.message,
                    allowed: e.allowed,
                }),
        );
        if !arena.objects().is_empty() && self.engine == EngineKind::Kinematic {
            errors.push(error(
                "/engine",
                format!(
                    "the kinematic engine cannot move the {} objects of the arena {}",
                    arena.objects().len(),
                    arena.name()
                ),
                "rapier, or an arena without objects",
            ));
        }
        if self.placement == Placement::Start
            && let Err(error) = enough_starts(arena, self.robots)
            && !errors.contains(&error)
        {
            errors.push(error);
        }
    }
}
