//! The threads that one run may use: none besides its own, or a pool of its own.
//!
//! No result depends on how many there are. Whoever owns a run says so, between two calls of
//! `advance`; worlds too small to share stay on one thread whatever they are given.

use std::sync::Arc;

use rayon::ThreadPool;

/// Fewest robots for which a further thread is worth waking.
const ROBOTS_A_THREAD: usize = 512;

/// Threads of a run.
#[derive(Clone, Debug, Default)]
pub struct Crew {
    pool: Option<Arc<ThreadPool>>,
}

impl Crew {
    /// So many threads in all, at least 1; fewer where the system refuses them.
    pub fn new(threads: usize) -> Self {
        let pool = (threads > 1).then(|| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(|number| format!("world-{number}"))
                .build()
        });
        Self {
            pool: pool.and_then(Result::ok).map(Arc::new),
        }
    }

    /// Threads that work can be spread over.
    pub fn threads(&self) -> usize {
        self.pool
            .as_ref()
            .map_or(1, |pool| pool.current_num_threads())
    }

    /// Most threads that a world of so many robots makes use of.
    pub fn useful_threads(robots: usize) -> usize {
        (robots / ROBOTS_A_THREAD).max(1)
    }

    /// The pool, where a world of so many robots is large enough to be shared by its threads.
    pub(crate) fn for_world(&self, robots: usize) -> Option<Arc<ThreadPool>> {
        let pool = self.pool.as_ref()?;
        (Self::useful_threads(robots) > 1).then(|| Arc::clone(pool))
    }

    /// The pool, where there is one.
    pub(crate) fn pool(&self) -> Option<&ThreadPool> {
        self.pool.as_deref()
    }

    /// What each thread of the pool answers; nothing where there is none. For measurements.
    pub fn each_thread<T: Send>(&self, ask: impl Fn() -> T + Sync) -> Vec<T> {
        self.pool
            .as_ref()
            .map_or_else(Vec::new, |pool| pool.broadcast(|_| ask()))
    }
}
