//! The examples, run as they are.
#![allow(clippy::unwrap_used, reason = "a test may fail so")]

#[path = "../examples/one_run.rs"]
mod one_run;
#[path = "../examples/own_controller.rs"]
mod own_controller;
#[path = "../examples/save_and_restore.rs"]
mod save_and_restore;

#[test]
fn one_run() {
    let outcome = one_run::explore().unwrap();
    assert!(outcome.coverage_reachable[0] > 20, "{outcome:?}");
    assert_eq!(outcome.coverage.epoch, 5);
    one_run::main().unwrap();
}

#[test]
fn own_controller() {
    let (entered, squares) = own_controller::drive().unwrap();
    // Robots that hang on walls or in corners enter some hundreds.
    assert!(entered > squares / 5, "{entered} of {squares}");
    own_controller::main().unwrap();
}

#[test]
fn save_and_restore() {
    let [whole, restored] = save_and_restore::both_ends().unwrap();
    assert!(whole.is_some());
    assert_eq!(whole, restored);
    save_and_restore::main().unwrap();
}
