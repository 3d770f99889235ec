//! What is told of a learner on the way, and that telling it changes nothing.

use super::*;

#[test]
fn looking_at_a_learner_changes_nothing() {
    let (mut seen, mut unseen) = (run_of(spec(Method::EvIterC)), run_of(spec(Method::EvIterC)));
    let mut phases = Vec::new();
    while unseen.progress().phase != Phase::Done {
        unseen.advance(137);
        let phase = seen.advance(137).phase;
        let learnt = seen.learnt(0).unwrap();
        let has_table = !matches!(phase, Phase::Evolution);
        assert_eq!((learnt.phase, learnt.table.is_some()), (phase, has_table));
        assert!(seen.learns() && seen.choice(0) == learnt.choice);
        if let (Some((codebook, table)), Some((state, action))) = (learnt.table, learnt.choice) {
            assert_eq!(learnt.clusters, (table.states(), table.actions()));
            assert!(state < codebook.states.len() && action < codebook.actions.len());
        }
        let trains = matches!(phase, Phase::Evolution | Phase::Repository);
        assert_eq!(seen.is_training(), trains);
        assert_eq!(seen.first_entry().iter().all(|&first| first == 0), trains);
        phases.push(phase);
    }
    phases.dedup();
    let all = [
        Phase::Evolution,
        Phase::Repository,
        Phase::Exploration,
        Phase::Done,
    ];
    assert_eq!(phases, all);
    assert_eq!(seen.snapshot(), unseen.snapshot());
    assert!(seen.learnt(1).is_none());
}

#[test]
fn robots_with_a_common_table_and_those_without_one() {
    let mut shared = swarm(Method::EvIterC, 3);
    shared.sharing = Sharing::Arena;
    let mut run = run_of(shared);
    run.advance(u64::MAX);
    for robot in 0..3 {
        let learnt = run.learnt(robot).unwrap();
        assert!(learnt.table.is_some() && learnt.choice == run.choice(robot));
    }
    let run = run_of(spec(Method::Brownian));
    assert!(run.learnt(0).is_none() && run.choice(0).is_none() && !run.learns());
}
