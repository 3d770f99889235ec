//! The step loop asks the allocator for nothing, whatever a robot is doing.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use swarm::robot::RobotModel;
use swarm::run::{Phase, Run};
use swarm::spec::{
    ControllerParameters, ControllerSpec, EngineKind, Episodes, Method, Placement, RadioLink,
    RunSpec, Sharing, Training,
};

/// Counts what this thread allocates.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn spec(method: Method, robots: u32) -> RunSpec {
    let arena = |name| Arc::new(arenas::builtin(name).unwrap());
    RunSpec {
        seed: 3,
        arena: arena("maze"),
        controller: ControllerSpec {
            method,
            parameters: ControllerParameters {
                babbling_epochs: 2,
                ..Default::default()
            },
            own: Default::default(),
            training: Some(Training {
                arena: arena("easy"),
                epochs: 2,
            }),
        },
        epochs: 2,
        steps_per_epoch: 400,
        robots,
        placement: Placement::Grid,
        episodes: Episodes::Reset,
        robot: RobotModel::default(),
        engine: EngineKind::Kinematic,
        memory_budget_bytes: None,
        sharing: Sharing::None,
    }
}

/// Allocations while the run is stepped inside tenths of its epochs: not at their ends, where rows
/// of metrics, evolution, clustering and the next stage's learners may take memory.
fn allocations_in_steps(spec: RunSpec) -> u64 {
    let inside = u64::from(spec.steps_per_epoch) / 10 - 1;
    let mut run = Run::new(spec.validate().unwrap()).unwrap();
    let mut sum = 0;
    while run.progress().phase != Phase::Done {
        let before = ALLOCATIONS.get();
        run.advance(inside);
        sum += ALLOCATIONS.get() - before;
        run.advance(1);
    }
    sum
}

#[test]
fn a_step_allocates_nothing() {
    for &method in Method::ALL {
        assert_eq!(
            allocations_in_steps(spec(method, 1)),
            0,
            "{}",
            method.name()
        );
        assert_eq!(
            allocations_in_steps(spec(method, 8)),
            0,
            "{} x 8",
            method.name()
        );
    }
}

#[test]
fn sharing_allocates_nothing_either() {
    let link = RadioLink {
        range_m: Some(0.3),
        bytes_per_step: 32,
    };
    for sharing in [Sharing::Arena, Sharing::Radio(link)] {
        let spec = RunSpec {
            sharing: sharing.clone(),
            ..spec(Method::EvIterC, 8)
        };
        assert_eq!(allocations_in_steps(spec), 0, "{sharing:?}");
    }
}
