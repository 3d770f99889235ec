//! Robots' learners as the service shows them.

use api::ClusterCounts;
use api::learnt::{Learning, Learnt, LearntTable, RobotLearning};
use swarm::controllers::Codebook;
use swarm::learn::repository::Repository;
use swarm::run::Run;

use crate::artifacts::memory;

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

/// How far at most `limit` robots from a number on have learnt; `None` where they learn nothing. The
/// run itself does not know its id.
pub fn learning(run: &Run, from: u32, limit: u32, is_live: bool) -> Option<Learning> {
    if !run.learns() {
        return None;
    }
    let held = run.memory();
    let to = from.saturating_add(limit).min(run.spec().robots);
    let robot = |robot: usize| run.learnt_among(robot..robot + 1, &held).next();
    let clusters = robot(0).map_or_else(ClusterCounts::default, |(_, first)| ClusterCounts {
        sensor: first.clusters.0,
        actuator: first.clusters.1,
        sensori_motor: first.sensori_motor_clusters.unwrap_or(0),
    });
    let items = run.learnt_among(from as usize..to as usize, &held);
    let progress = run.progress();
    Some(Learning {
        run_id: String::new(),
        is_live,
        phase: progress.phase.name().to_owned(),
        epochs_done: progress.epochs_done,
        epochs_total: progress.epochs_total,
        arena_step: Some(run.step()),
        robots: run.spec().robots,
        budget_bytes: run.spec().memory_budget_bytes,
        memory: memory(&held, run.memory_plan()),
        clusters,
        model: None,
        items: items
            .map(|(robot, learnt)| RobotLearning {
                // A run has at most 100,000 robots.
                robot: robot as u32,
                sensor_clusters: learnt.clusters.0,
                actuator_clusters: learnt.clusters.1,
                sensori_motor_clusters: learnt.sensori_motor_clusters,
                fitness: learnt.fitness.filter(|fitness| fitness.is_finite()),
                bytes: learnt.memory.bytes,
                clusters_saturated: learnt.memory.clusters_saturated,
            })
            .collect(),
        next: (to < run.spec().robots).then(|| to.to_string()),
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
