//! Whether anybody still waits for what a thread is doing.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static GIVEN_UP: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// What is done because somebody asked, given up when this is dropped.
#[derive(Default)]
pub struct Asked(Arc<AtomicBool>);

/// The same for the thread that does it.
pub struct Work(Arc<AtomicBool>);

impl Asked {
    /// What the thread needs.
    pub fn work(&self) -> Work {
        Work(Arc::clone(&self.0))
    }
}

impl Drop for Asked {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Work {
    /// Does it on the present thread.
    pub fn run<T>(self, work: impl FnOnce() -> T) -> T {
        let before = GIVEN_UP.replace(Some(self.0));
        let done = work();
        GIVEN_UP.set(before);
        done
    }
}

/// Whether nobody waits any more for what this thread does, so that it may end early. `false` for
/// what nobody asked for over HTTP.
pub fn is_given_up() -> bool {
    GIVEN_UP.with_borrow(|flag| {
        flag.as_ref()
            .is_some_and(|flag| flag.load(Ordering::Relaxed))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_given_up_with_who_asked() {
        let asked = Asked::default();
        let work = asked.work();
        work.run(|| {
            assert!(!is_given_up());
            drop(asked);
            assert!(is_given_up());
        });
        assert!(!is_given_up());
    }
}
