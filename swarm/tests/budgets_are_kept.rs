//! What learners really ask the allocator for, against what is counted and planned.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use arenas::{ArenaFormat, SquaresFormat};
use swarm::memory::{E_PUCK_BYTES, E_PUCK2_BYTES};
use swarm::robot::RobotModel;
use swarm::run::{Phase, Run};
use swarm::spec::{
    ControllerParameters, ControllerSpec, DEFAULT_BYTES_PER_STEP, EngineKind, Episodes, Method,
    Placement, RadioLink, RunSpec, Sharing, Training,
};

/// Counts what this thread holds, and the most that it held.
struct Counting;

thread_local! {
    static HELD: Cell<i64> = const { Cell::new(0) };
    static MOST: Cell<i64> = const { Cell::new(0) };
}

fn count(bytes: i64) {
    HELD.with(|held| {
        held.set(held.get() + bytes);
        MOST.with(|most| most.set(most.get().max(held.get())));
    });
}

// SAFETY: every call goes to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as i64));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// All phases in one arena, so that a run holds one world whatever its method.
fn spec(method: Method, robots: u32, memory_budget_bytes: Option<u64>) -> RunSpec {
    // Few squares, so that what is counted a square does not hide what learners hold.
    let format = ArenaFormat {
        squares: Some(SquaresFormat::Side(2)),
        ..arenas::builtin("easy").unwrap().to_format()
    };
    let arena = Arc::new(format.build().unwrap());
    RunSpec {
        seed: 3,
        arena: Arc::clone(&arena),
        controller: ControllerSpec {
            method,
            parameters: ControllerParameters {
                babbling_epochs: 3,
                ..Default::default()
            },
            own: Default::default(),
            training: Some(Training { arena, epochs: 5 }),
        },
        epochs: 2,
        steps_per_epoch: 600,
        robots,
        placement: Placement::Grid,
        episodes: Episodes::Continue,
        robot: RobotModel::default(),
        engine: EngineKind::Kinematic,
        memory_budget_bytes,
        sharing: Sharing::None,
    }
}

/// A finished run, the bytes held for it, those held for it when it was set up, and the most from
/// then until exploration began, when rows of metrics come in.
fn finished(spec: RunSpec) -> (Run, i64, i64, i64) {
    let before = HELD.get();
    let mut run = Run::new(spec.validate().unwrap()).unwrap();
    run.reachable();
    let at_first = HELD.get() - before;
    MOST.set(HELD.get());
    while !matches!(run.progress().phase, Phase::Exploration | Phase::Done) {
        run.advance(1);
    }
    let most = MOST.get() - before;
    run.advance(u64::MAX);
    (run, HELD.get() - before, at_first, most)
}

fn sharings() -> [Sharing; 3] {
    let link = RadioLink {
        range_m: Some(0.47),
        bytes_per_step: DEFAULT_BYTES_PER_STEP,
    };
    [Sharing::None, Sharing::Arena, Sharing::Radio(link)]
}

/// What a run keeps for itself that depends on the method: its list of stages.
const OF_THE_RUN_BYTES: i64 = 64;

#[test]
fn bytes_are_those_that_the_allocator_gave() {
    let robots = 8;
    // Whatever is made once in a process is made here.
    finished(spec(Method::EvIterC, robots, None));
    let (brownian, without, _, _) = finished(spec(Method::Brownian, robots, None));
    let brownians: u64 = brownian.memory().iter().map(|robot| robot.bytes).sum();
    for &method in Method::ALL {
        for budget in [None, Some(E_PUCK_BYTES), Some(E_PUCK2_BYTES)] {
            let (run, held, _, _) = finished(spec(method, robots, budget));
            let counted: u64 = run.memory().iter().map(|robot| robot.bytes).sum();
            let differs = (held - without) - (counted as i64 - brownians as i64);
            assert!(
                differs.abs() <= OF_THE_RUN_BYTES,
                "{}, budget {budget:?}: {counted} counted, {differs} more held",
                method.name()
            );
        }
    }
}

#[test]
fn no_robot_ever_holds_more_than_its_budget() {
    finished(spec(Method::EvIterC, 1, None));
    let (_, _, without, _) = finished(spec(Method::Brownian, 1, None));
    for &method in Method::ALL {
        for sharing in sharings() {
            for budget in [E_PUCK_BYTES, E_PUCK2_BYTES] {
                let spec = RunSpec {
                    sharing: sharing.clone(),
                    ..spec(method, 1, Some(budget))
                };
                let Ok(valid) = spec.clone().validate() else {
                    continue;
                };
                let planned = valid.memory_plan().bytes;
                let (run, _, _, most) = finished(spec);
                // Who hears whom is the arena's to know.
                let medium = match sharing {
                    Sharing::Radio(_) => 128,
                    Sharing::None | Sharing::Arena => 0,
                };
                let most = most - without - medium;
                let case = format!("{} {sharing:?}", method.name());
                assert!(planned <= budget, "{case}: {planned} planned of {budget}");
                assert!(
                    most <= planned as i64,
                    "{case}: {most} held, {planned} planned"
                );
                for robot in run.memory() {
                    assert!(
                        robot.bytes <= planned,
                        "{case}: {robot:?}, {planned} planned"
                    );
                }
            }
        }
    }
}
