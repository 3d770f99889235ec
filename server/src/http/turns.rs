//! Which requests take a turn because they are much work.

use std::ops::Deref;

use api::ProblemCode;
use serde_json::Value;

use super::App;
use super::refusal::Refusal;
use super::request::parse;
use crate::documents::is_heavy;
use crate::store::{JobView, RunView};
use crate::turns::{Busy, LARGE_TEXT_BYTES, Turn};

/// Pooling the results of more runs than this is much work ...
pub(super) const MANY_RUNS: u64 = 1_000;
/// ... and so are their curves and where they went.
pub(super) const MANY_FINDINGS: u64 = 100;

/// A document that was read, with its turn if it is much work.
pub struct Document {
    value: Value,
    _turn: Option<Turn>,
}

impl Deref for Document {
    type Target = Value;

    fn deref(&self) -> &Value {
        &self.value
    }
}

impl From<Busy> for Refusal {
    fn from(busy: Busy) -> Self {
        Self::new(ProblemCode::Overloaded, busy.to_string()).retry_after_s(5)
    }
}

impl App {
    /// Reads a document, on a thread that may block: when its turn comes, if it is much work.
    ///
    /// # Errors
    /// As [`parse`], and 503 when there is no turn.
    pub(super) fn read(&self, body: &[u8]) -> Result<Document, Refusal> {
        let large = self.turns.take_if(body.len() > LARGE_TEXT_BYTES)?;
        let value = parse(body)?;
        let turn = match large {
            None => {
                let heavy = is_heavy(&value, body.len(), &|name| self.is_large(name));
                self.turns.take_if(heavy)?
            }
            turn => turn,
        };
        Ok(Document { value, _turn: turn })
    }

    /// Whether this is the name of a large uploaded arena. One that cannot be looked at is not one,
    /// which whoever reads it is told.
    fn is_large(&self, arena: &str) -> bool {
        let bytes = self.store.arena_bytes(arena);
        bytes.is_ok_and(|bytes| bytes > LARGE_TEXT_BYTES as u64)
    }

    /// A turn to pool the runs of this job, if they are more than so many.
    ///
    /// # Errors
    /// 503 when there is none.
    pub(super) fn turn_to_pool(&self, job: &JobView, many: u64) -> Result<Option<Turn>, Refusal> {
        Ok(self.pooling.take_if(job.counts.total > many)?)
    }

    /// A turn to make something of this run's spec, if that is large.
    ///
    /// # Errors
    /// 503 when there is none.
    pub(super) fn turn_for_spec(&self, run: &RunView) -> Result<Option<Turn>, Refusal> {
        Ok(self.turns.take_if(self.findings.has_large_spec(run)?)?)
    }
}
