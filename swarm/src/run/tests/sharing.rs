//! Whole runs that share, have budgets, or learn on line.

use super::*;
use crate::spec::{DEFAULT_BYTES_PER_STEP, RadioLink};

fn radio(range_m: Option<f64>, bytes_per_step: u32) -> Sharing {
    Sharing::Radio(RadioLink {
        range_m,
        bytes_per_step,
    })
}

#[test]
fn interrupted_equals_uninterrupted_with_sharing_and_budgets() {
    for sharing in [Sharing::Arena, radio(Some(0.3), 64)] {
        for memory_budget_bytes in [None, Some(crate::memory::E_PUCK_BYTES)] {
            for method in [Method::EvIterC, Method::Im] {
                let spec = RunSpec {
                    sharing: sharing.clone(),
                    memory_budget_bytes,
                    ..swarm(method, 4)
                };
                check_interrupted(&spec, 83);
            }
        }
    }
    let genomes = RunSpec {
        sharing: radio(None, 200),
        ..swarm(Method::Curiosity, 4)
    };
    check_interrupted(&genomes, 83);
}

#[test]
fn sharing_is_the_same_on_one_thread_and_on_two() {
    let specs: Vec<RunSpec> = [Sharing::Arena, radio(Some(0.3), 16), radio(None, 64)]
        .into_iter()
        .flat_map(|sharing| {
            [Method::EvIterC, Method::Im].map(|method| RunSpec {
                sharing: sharing.clone(),
                ..swarm(method, 6)
            })
        })
        .collect();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let outcomes = specs
                .par_iter()
                .map(|spec| finished(spec.clone()).state_sha256);
            outcomes.collect::<Vec<_>>()
        })
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn a_lone_robot_learns_the_same_with_a_table_in_common() {
    for method in [Method::EvIterC, Method::Im] {
        let alone = finished(spec(method));
        let team = finished(RunSpec {
            sharing: Sharing::Arena,
            ..spec(method)
        });
        assert_eq!(alone.coverage, team.coverage);
        assert_eq!(alone.collisions, team.collisions);
    }
}

#[test]
fn out_of_range_is_as_good_as_alone() {
    let silent = finished(RunSpec {
        sharing: radio(Some(0.0), DEFAULT_BYTES_PER_STEP),
        ..swarm(Method::Curiosity, 4)
    });
    assert_eq!(
        silent.coverage,
        finished(swarm(Method::Curiosity, 4)).coverage
    );
    let heard = finished(RunSpec {
        sharing: radio(None, 456),
        epochs: 4,
        ..swarm(Method::Curiosity, 4)
    });
    let alone = finished(RunSpec {
        epochs: 4,
        ..swarm(Method::Curiosity, 4)
    });
    assert_ne!(heard.coverage, alone.coverage, "genomes were adopted");
}

#[test]
fn on_line_all_phases_happen_in_one_arena_without_a_reset() {
    let mut on_line = RunSpec {
        episodes: Episodes::Continue,
        ..spec(Method::EvIterC)
    };
    on_line.controller.training = Some(Training {
        arena: arena("maze"),
        epochs: 3,
    });
    let mut run = run_of(on_line.clone());
    assert_eq!(run.venues.len(), 1);
    let step_m = on_line.robot.max_step_m() as f32;
    let mut last = run.robots()[0];
    while run.progress().phase != Phase::Done {
        run.advance(1);
        let now = run.robots()[0];
        let moved = (now.x_m - last.x_m).hypot(now.y_m - last.y_m);
        assert!(moved <= 1.01 * step_m, "jumped {moved} m at {}", run.step());
        last = now;
    }
    assert!(run.outcome().unwrap().coverage.p1 > 0);
    check_interrupted(&on_line, 97);
}
