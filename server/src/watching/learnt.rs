//! A robot's learner as the service shows it.

use api::learnt::{Learnt, LearntTable};
use swarm::controllers::Codebook;
use swarm::learn::repository::Repository;
use swarm::run::Run;

/// Most values of each list of lists.
const MAX_VALUES: u32 = 250_000;

/// What a robot has learnt; `None` where it learns nothing or there is no such robot.
pub fn shown(run: &Run, robot: u32, is_live: bool) -> Option<Learnt> {
    let learnt = run.learnt(robot as usize)?;
    let table = learnt.table.zip(learnt.choice);
    Some(Learnt {
        robot,
        is_live,
        phase: learnt.phase.name().to_owned(),
        arena_step: run.step(),
        sensor_clusters: learnt.clusters.0,
        actuator_clusters: learnt.clusters.1,
        sensori_motor_clusters: learnt.sensori_motor_clusters,
        fitness: learnt.fitness.filter(|fitness| fitness.is_finite()),
        bytes: learnt.memory.bytes,
        most_bytes: run.memory_plan().bytes,
        budget_bytes: run.spec().memory_budget_bytes,
        clusters_saturated: learnt.memory.clusters_saturated,
        table: table.map(|((codebook, repository), choice)| told(codebook, repository, choice)),
    })
}

fn told(codebook: &Codebook, table: &Repository, (state, action): (u32, u32)) -> LearntTable {
    LearntTable {
        states_total: table.states(),
        state,
        action,
        counts: each(table, |i, j| table.count(i, j)),
        entropy: each(table, |i, j| rounded(table.entropy(i, j))),
        score: each(table, |i, j| {
            let score = table.score(i, j);
            score.is_finite().then(|| rounded(f64::from(score)))
        }),
        states: codebook
            .states
            .iter()
            .take(shown_states(table) as usize)
            .map(Vec::from)
            .collect(),
        actions: codebook.actions.iter().map(Vec::from).collect(),
    }
}

/// A list for each state with a value for each action.
fn each<T>(table: &Repository, value: impl Fn(u32, u32) -> T) -> Vec<Vec<T>> {
    let row = |i| (0..table.actions()).map(|j| value(i, j)).collect();
    (0..shown_states(table)).map(row).collect()
}

fn shown_states(table: &Repository) -> u32 {
    table.states().min(MAX_VALUES / table.actions())
}

/// As many digits as anyone reads.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
