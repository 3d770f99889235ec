//! What runs and jobs have found: live from a worker, stored, or from a checkpoint; pooled into a
//! summary or judged in a report. Whoever shows it (HTTP today) only translates.

mod coverage;
mod curves;
mod error;
mod groups;
mod kept;
mod learnt;
mod once;
mod pooled;
mod report;
mod run;
mod summary;
pub mod views;

use std::sync::Arc;

pub use error::FindingsError;
use kept::Kept;
use once::Once;

use crate::scheduler::Scheduler;
use crate::store::Store;
use crate::turns::Turns;

/// Assembles what has been found.
pub struct Assembler {
    store: Arc<Store>,
    scheduler: Arc<Scheduler>,
    kept: Kept,
    once: Once,
    /// Turns of reading large specs, and of reading what was found in arenas of many squares.
    large_specs: Turns,
    large_findings: Turns,
}

impl Assembler {
    /// Over this store, and over what workers of this scheduler know right now.
    pub fn new(store: Arc<Store>, scheduler: Arc<Scheduler>) -> Self {
        Self {
            store,
            scheduler,
            kept: Kept::default(),
            once: Once::default(),
            large_specs: Turns::default(),
            large_findings: Turns::default(),
        }
    }
}
