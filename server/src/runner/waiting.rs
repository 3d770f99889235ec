//! What the thread of a run does while it waits for another program: it waits at a step boundary,
//! where the run may be looked at and saved, and lets others know.

use std::time::{Duration, Instant};

use api::WaitsFor;
use swarm::run::Run;

/// Time between two looks around.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// Who attends to a run while its thread waits. It cannot change the run.
pub trait Attendant {
    /// The run has waited since then, and may be looked at. Called again and again while it waits.
    fn attend(&self, run: &Run, waits_for: WaitsFor, since: Instant) {
        let _ = (run, waits_for, since);
    }

    /// It waits no longer.
    fn goes_on(&self) {}

    /// Whether the run is to be let go, and so to wait no longer.
    fn is_stopping(&self) -> bool {
        false
    }
}

/// Nobody attends.
impl Attendant for () {}

/// One wait of a run. It costs nothing where there is nothing to wait for.
pub struct Wait<'a> {
    attendant: &'a dyn Attendant,
    run: &'a Run,
    waits_for: WaitsFor,
    /// When it began, and the last look around.
    times: Option<(Instant, Instant)>,
    is_attended: bool,
}

impl<'a> Wait<'a> {
    /// A wait that has not begun.
    pub fn new(attendant: &'a dyn Attendant, run: &'a Run, waits_for: WaitsFor) -> Self {
        Self {
            attendant,
            run,
            waits_for,
            times: None,
            is_attended: false,
        }
    }

    /// To be called again and again while there is something to wait for. Returns whether to go on
    /// waiting.
    pub fn look_around(&mut self) -> bool {
        let now = Instant::now();
        let (since, looked) = self.times.get_or_insert((now, now));
        if now.duration_since(*looked) >= LOOK_EVERY {
            self.is_attended = true;
            self.attendant.attend(self.run, self.waits_for, *since);
            *looked = Instant::now();
        }
        !self.attendant.is_stopping()
    }
}

impl Drop for Wait<'_> {
    fn drop(&mut self) {
        if self.is_attended {
            self.attendant.goes_on();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::cell::{Cell, RefCell};

    use serde_json::json;

    use super::*;
    use crate::documents::{BuiltinArenas, resolve};

    #[derive(Default)]
    struct Noting {
        attended: RefCell<Vec<(u64, WaitsFor)>>,
        goes_on: Cell<u32>,
        is_stopping: Cell<bool>,
    }

    impl Attendant for Noting {
        fn attend(&self, run: &Run, waits_for: WaitsFor, since: Instant) {
            assert!(since.elapsed() >= LOOK_EVERY);
            self.attended.borrow_mut().push((run.step(), waits_for));
        }

        fn goes_on(&self) {
            self.goes_on.set(self.goes_on.get() + 1);
        }

        fn is_stopping(&self) -> bool {
            self.is_stopping.get()
        }
    }

    #[test]
    fn a_wait_is_attended_to_now_and_then_and_is_over_when_the_run_is_let_go() {
        let spec = json!({ "arena": "easy", "controller": { "method": "brownian" }, "epochs": 1 });
        let run = Run::new(resolve(&spec, &BuiltinArenas).unwrap().run_spec()).unwrap();
        let noting = Noting::default();
        let mut none = Wait::new(&noting, &run, WaitsFor::Controllers);
        assert!(none.look_around());
        drop(none);
        assert_eq!(noting.goes_on.get(), 0, "it waited for a moment alone");

        let mut wait = Wait::new(&noting, &run, WaitsFor::LosslessReaders);
        let since = Instant::now();
        let mut looks = 0;
        while noting.attended.borrow().len() < 3 {
            assert!(wait.look_around());
            looks += 1;
        }
        assert!(since.elapsed() >= 3 * LOOK_EVERY && looks > 3, "{looks}");
        assert_eq!(
            *noting.attended.borrow(),
            [(0, WaitsFor::LosslessReaders); 3]
        );
        noting.is_stopping.set(true);
        assert!(!wait.look_around());
        drop(wait);
        assert_eq!(noting.goes_on.get(), 1);
    }
}
