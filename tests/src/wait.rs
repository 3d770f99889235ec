//! Waiting with an end.

use std::process::{Child, ExitStatus};
use std::time::{Duration, Instant};

/// Longest wait for anything: generous, as the machine may be busy, and only met when a test fails.
pub const LIMIT: Duration = Duration::from_secs(120);

/// Looks again and again until there is something.
///
/// # Panics
/// After [`LIMIT`].
pub fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < LIMIT, "waited too long for {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Waits for a process to end.
///
/// # Panics
/// After [`LIMIT`]; the process is killed then.
pub fn for_exit(child: &mut Child) -> ExitStatus {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if start.elapsed() > LIMIT {
            child.kill().unwrap();
            panic!("the process did not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}
