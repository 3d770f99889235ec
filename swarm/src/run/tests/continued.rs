//! Runs that go on from the state of another.

use super::*;
use crate::run::CHANGEABLE;
use crate::spec::{Insufficiency, Ties};

fn ended(spec: &RunSpec) -> Vec<u8> {
    let mut run = run_of(spec.clone());
    run.advance(u64::MAX);
    run.snapshot()
}

/// Extends a run and compares with one that was simulated whole.
fn check_extended(short: &RunSpec, epochs: u32) {
    let long = RunSpec {
        epochs,
        ..short.clone()
    };
    let mut extended = Run::extended(short, valid(long.clone()), &ended(short)).unwrap();
    let mut whole = run_of(long.clone());
    assert_eq!(extended.curve().len(), short.epochs as usize);
    whole.advance(extended.step());
    let method = short.controller.method.name();
    assert!(extended.snapshot() == whole.snapshot(), "{method}: at once");
    extended.advance(u64::MAX);
    whole.advance(u64::MAX);
    assert!(
        extended.snapshot() == whole.snapshot(),
        "{method}: at the end"
    );
    assert_eq!(extended.outcome(), whole.outcome());
}

#[test]
fn an_extended_run_is_the_whole_one() {
    Method::ALL.par_iter().for_each(|&method| {
        let mut spec = spec(method);
        spec.steps_per_epoch = 60;
        check_extended(&spec, 5);
        spec.episodes = Episodes::Continue;
        check_extended(&spec, 4);
        spec.robots = 3;
        spec.placement = Placement::Grid;
        spec.engine = EngineKind::Rapier;
        check_extended(&spec, 4);
    });
    let mut swarm = swarm(Method::EvIterC, 4);
    swarm.sharing = Sharing::Arena;
    check_extended(&swarm, 4);
}

#[test]
fn rows_that_only_the_last_epoch_has_go() {
    // Of the epochs after the 64th every second has a row, but the last in any case.
    for (short, long) in [(65, 66), (65, 70), (66, 69)] {
        let spec = RunSpec {
            epochs: short,
            steps_per_epoch: 10,
            ..spec(Method::Brownian)
        };
        check_extended(&spec, long);
    }
}

#[test]
fn only_the_end_of_the_same_run_is_extended() {
    let short = spec(Method::Im);
    let longer = |epochs| {
        valid(RunSpec {
            epochs,
            ..short.clone()
        })
    };
    let end = ended(&short);
    assert!(Run::extended(&short, longer(3), &end).is_err());
    let mut other = short.clone();
    other.seed += 1;
    assert!(Run::extended(&other, longer(5), &end).is_err());
    assert!(Run::extended(&short, longer(5), &end[..end.len() - 1]).is_err());
    let mut middle = run_of(short.clone());
    middle.advance(700);
    assert!(matches!(
        Run::extended(&short, longer(5), &middle.snapshot()),
        Err(RestoreError::CannotGoOn(_))
    ));
}

#[test]
fn a_fork_without_changes_is_the_run_itself() {
    for method in [Method::EvIterC, Method::Im, Method::Levy] {
        let spec = spec(method);
        let mut run = run_of(spec.clone());
        let total = { ended(&spec) };
        for at in [150, 400, 550] {
            run.advance(at - run.step().min(at));
            let mut fork = Run::forked(&spec, valid(spec.clone()), &run.snapshot()).unwrap();
            assert!(fork.snapshot() == run.snapshot(), "{method:?} at {at}");
            fork.advance(u64::MAX);
            assert!(fork.snapshot() == total, "{method:?} from {at}");
        }
    }
}

#[test]
fn a_fork_decides_by_its_own_parameters_from_where_it_begins() {
    let mut origin = spec(Method::EvIterC);
    origin.epochs = 6;
    origin.controller.parameters.lambda = 5;
    origin.controller.parameters.lambda_total = 40;
    let mut run = run_of(origin.clone());
    while run.progress().epochs_done < 3 {
        run.advance(50);
    }
    let bytes = run.snapshot();
    let fork = |change: &dyn Fn(&mut RunSpec)| {
        let mut spec = origin.clone();
        change(&mut spec);
        let mut fork = Run::forked(&origin, valid(spec), &bytes).unwrap();
        assert_eq!(fork.visits(), run.visits());
        fork.advance(u64::MAX);
        fork.outcome().unwrap()
    };
    let same = fork(&|_| {});
    let changes: [&dyn Fn(&mut RunSpec); 6] = [
        &|spec| spec.epochs = 8,
        &|spec| spec.controller.parameters.alpha = 0.0,
        &|spec| spec.controller.parameters.eta = 0.9,
        &|spec| spec.controller.parameters.insufficiency = Insufficiency::EveryAction,
        &|spec| spec.controller.parameters.ties = Ties::Random,
        &|spec| spec.controller.parameters.action_hold_steps = 7,
    ];
    for (place, change) in changes.iter().enumerate() {
        let changed = fork(change);
        assert_ne!(changed.state_sha256, same.state_sha256, "{place}");
        // Forking twice is the same twice.
        assert_eq!(fork(change), changed);
    }
    assert_eq!(CHANGEABLE.len(), changes.len() + 1);
}

#[test]
fn a_fork_with_another_world_is_refused() {
    let origin = spec(Method::EvIterC);
    let mut run = run_of(origin.clone());
    run.advance(900);
    let bytes = run.snapshot();
    let changes: [&dyn Fn(&mut RunSpec); 6] = [
        &|spec| spec.seed = 6,
        &|spec| spec.arena = arena("easy"),
        &|spec| spec.steps_per_epoch += 1,
        &|spec| spec.controller.method = Method::EvIterD,
        &|spec| spec.controller.parameters.lambda = 7,
        &|spec| spec.robot.parameters.axle_m *= 1.1,
    ];
    for (place, change) in changes.iter().enumerate() {
        let mut spec = origin.clone();
        change(&mut spec);
        let refused = Run::forked(&origin, valid(spec), &bytes);
        assert!(
            matches!(refused, Err(RestoreError::CannotGoOn(_))),
            "{place}"
        );
    }
    while run.progress().epochs_done < 2 {
        run.advance(50);
    }
    let short = RunSpec {
        epochs: 1,
        ..origin.clone()
    };
    let refused = Run::forked(&origin, valid(short), &run.snapshot());
    assert!(matches!(refused, Err(RestoreError::Spec(_))));
}
