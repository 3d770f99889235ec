//! Which parameters a method has: the others stand in its spec with no effect.

use swarm::methods::{Explores, Trains};
use swarm::spec::{Method, StatesFrom};

/// Of the (1+1)-ES.
const EVOLUTION: [&str; 6] = [
    "slope",
    "initial_weight_variance",
    "sigma",
    "sigma_factor",
    "success_window",
    "restart_after",
];
/// Of states, the repository and the phase-3 controller.
const EXPLORATION: [&str; 12] = [
    "epsilon_sensor",
    "kmeans_restarts",
    "kmeans_iterations",
    "sample",
    "actuator_sample",
    "lambda",
    "lambda_total",
    "insufficiency",
    "eta",
    "alpha",
    "ties",
    "action_hold_steps",
];

/// Whether a run of the method depends on this parameter, its own or one in common.
pub fn has_parameter(method: Method, states_from: StatesFrom, name: &str) -> bool {
    let definition = method.definition();
    let own = (definition.parameters)();
    let by_table = definition.explores == Explores::ByTable;
    let chooses = definition.trains == Trains::WithPhase1States;
    match name {
        _ if own.table().iter().any(|parameter| parameter.name == name) => true,
        _ if definition.explores == Explores::Walking => false,
        "states_from" => chooses,
        "babbling_epochs" => chooses && states_from == StatesFrom::Babbling,
        "replay_genomes" => by_table && definition.trains == Trains::Always,
        _ if EVOLUTION.contains(&name) => definition.trains.with(states_from),
        _ if EXPLORATION.contains(&name) => by_table,
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use serde_json::{Value, json};
    use swarm::run::Run;
    use swarm::spec::ControllerParameters;

    use super::*;
    use crate::documents::{BuiltinArenas, resolve};

    #[test]
    fn the_lists_name_parameters_of_the_table() {
        let known = |name: &&str| ControllerParameters::TABLE.iter().any(|p| p.name == *name);
        assert!(EVOLUTION.iter().chain(&EXPLORATION).all(known));
    }

    /// What a short run comes to: where robots went, and what is known of states and actions.
    fn outcome(controller: Value) -> String {
        let spec = json!({
            "arena": "easy", "controller": controller, "epochs": 2, "steps_per_epoch": 150
        });
        let mut run = Run::new(resolve(&spec, &BuiltinArenas).unwrap().run_spec()).unwrap();
        while run.outcome().is_none() {
            run.advance(10_000);
        }
        let outcome = run.outcome().unwrap();
        let clusters = (outcome.sensor_clusters, outcome.actuator_clusters);
        format!("{:?} {clusters:?} {:?}", run.visits(), outcome.coverage)
    }

    #[test]
    fn a_parameter_that_a_method_does_not_have_changes_nothing() {
        let other = [
            ("slope", json!(1.0)),
            ("sigma", json!(0.5)),
            ("eta", json!(0.5)),
            ("alpha", json!(0.1)),
            ("epsilon_sensor", json!(0.4)),
            ("lambda", json!(3)),
            ("ties", json!("random")),
            ("action_hold_steps", json!(7)),
            ("replay_genomes", json!(1)),
            ("babbling_epochs", json!(1)),
            ("kmeans_restarts", json!(1)),
            ("sample", json!(16)),
        ];
        for (method, states_from) in [
            ("brownian", None),
            ("curiosity", None),
            ("discovery-a", None),
            ("im", None),
            ("im", Some("phase-1")),
            ("ev-iter-c", None),
        ] {
            let mut plain = json!({ "method": method });
            if let Some(states_from) = states_from {
                plain["states_from"] = states_from.into();
            }
            if method != "brownian" && (method != "im" || states_from.is_some()) {
                plain["train"] = json!({ "arena": "easy", "epochs": 2 });
            }
            let states_from = states_from
                .and_then(StatesFrom::from_name)
                .unwrap_or(StatesFrom::Babbling);
            let mut changed = plain.clone();
            for (name, value) in &other {
                if !has_parameter(Method::from_name(method).unwrap(), states_from, name) {
                    changed[name] = value.clone();
                }
            }
            assert_ne!(plain, changed, "{method}");
            assert_eq!(outcome(plain.clone()), outcome(changed), "{plain}");
        }
    }
}
