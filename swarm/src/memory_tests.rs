//! Plans against budgets.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::robot::RobotModel;
use crate::spec::{
    ControllerSpec, DEFAULT_BYTES_PER_STEP, EngineKind, Episodes, Method, Placement, RadioLink,
    Training,
};

fn spec(method: Method, memory_budget_bytes: Option<u64>, sharing: Sharing) -> RunSpec {
    let arena = Arc::new(arenas::builtin("easy").unwrap());
    RunSpec {
        seed: 1,
        arena: Arc::clone(&arena),
        controller: ControllerSpec {
            method,
            parameters: ControllerParameters::default(),
            own: Default::default(),
            training: Some(Training { arena, epochs: 200 }),
        },
        epochs: 1,
        steps_per_epoch: 10,
        robots: 1,
        placement: Placement::Start,
        episodes: Episodes::Reset,
        robot: RobotModel::default(),
        engine: EngineKind::Kinematic,
        memory_budget_bytes,
        sharing,
    }
}

fn sharings() -> [Sharing; 3] {
    let link = RadioLink {
        range_m: Some(0.47),
        bytes_per_step: DEFAULT_BYTES_PER_STEP,
    };
    [Sharing::None, Sharing::Arena, Sharing::Radio(link)]
}

#[test]
fn without_a_budget_the_parameters_hold() {
    let spec = spec(Method::EvIterC, None, Sharing::None);
    let (plan, p) = (MemoryPlan::of(&spec).unwrap(), &spec.controller.parameters);
    assert_eq!(plan.sensor_clusters, p.max_clusters);
    assert_eq!(plan.actuator_clusters, p.max_clusters);
    assert_eq!(plan.sensori_motor_clusters, p.max_clusters);
    assert_eq!(
        (plan.sample, plan.actuator_sample),
        (p.sample, p.actuator_sample)
    );
    assert_eq!((plan.lambda, plan.genomes), (p.lambda, 200));
    assert_eq!(plan.applied_to(p), *p);

    let mut fittest = spec.clone();
    fittest.controller.parameters.replay_genomes = 20;
    let plan = MemoryPlan::of(&fittest).unwrap();
    assert_eq!(plan.genomes, 20);
    let steps = |spec: &RunSpec| spec.clone().validate().unwrap().robot_steps();
    let saved = steps(&spec) - steps(&fittest);
    assert_eq!(saved, 180 * u64::from(spec.steps_per_epoch));
}

#[test]
fn both_robots_have_room_for_every_method() {
    for &method in Method::ALL {
        for sharing in sharings() {
            for budget in [E_PUCK_BYTES, E_PUCK2_BYTES] {
                let spec = spec(method, Some(budget), sharing.clone());
                let plan = MemoryPlan::of(&spec).unwrap();
                assert!(plan.bytes <= budget, "{method:?} {sharing:?}: {plan:?}");
            }
        }
    }
}

proptest! {
    #[test]
    fn a_larger_budget_never_gives_less(
        budget in 2_000_u64..4_000_000,
        more in 1_u64..1_000_000,
        method in proptest::sample::select(Method::ALL.to_vec()),
        sharing in 0_usize..3,
    ) {
        let plan = |bytes| MemoryPlan::of(&spec(method, Some(bytes), sharings()[sharing].clone()));
        match (plan(budget), plan(budget + more)) {
            (Ok(less), Ok(more_plan)) => {
                prop_assert!(less.bytes <= budget && more_plan.bytes <= budget + more);
                prop_assert!(less.sensor_clusters <= more_plan.sensor_clusters);
                prop_assert!(less.lambda <= more_plan.lambda && less.sample <= more_plan.sample);
            }
            (Err(error), other) => {
                prop_assert!(error.smallest_bytes > budget);
                prop_assert_eq!(other.is_ok(), error.smallest_bytes <= budget + more);
                prop_assert!(plan(error.smallest_bytes).is_ok());
                prop_assert!(plan(error.smallest_bytes - 1).is_err());
            }
            (Ok(_), Err(error)) => prop_assert!(false, "{error}"),
        }
    }
}
