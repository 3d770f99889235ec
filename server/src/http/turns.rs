//! Turns of work that takes much memory or time, so that many requests for it at once cost no more
//! than a few, and leave room for all others.

use std::ops::Deref;
use std::sync::Arc;
use std::time::Duration;

use api::ProblemCode;
use serde_json::Value;
use tokio::runtime::Handle;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

use super::memory;
use super::refusal::Refusal;
use super::request::parse;
use crate::asked::is_given_up;
use crate::documents::is_heavy;
use crate::store::JobView;

/// Turns at a time ...
const MAX_AT_A_TIME: usize = 2;
/// ... and most requests that wait for one: a quarter of those that are answered at a time.
const MAX_WAITING: usize = 32;
/// Longest wait.
const PATIENCE: Duration = Duration::from_secs(30);
/// A text above this is heavy: read, it may take a hundred times as many bytes.
const LARGE_BYTES: usize = 64 << 10;
/// What pools more runs than this is heavy.
const MANY_RUNS: u64 = 1_000;

/// Who may do heavy work of one kind.
pub struct Turns {
    working: Arc<Semaphore>,
    waiting: Semaphore,
    patience: Duration,
}

/// A turn, over when this is dropped. What it took is given back first, as the allocator would keep
/// it for each thread that ever had a turn.
pub struct Turn {
    _permit: OwnedSemaphorePermit,
}

impl Drop for Turn {
    fn drop(&mut self) {
        memory::trim();
    }
}

/// A document that was read, with its turn if it is heavy.
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

impl Default for Turns {
    fn default() -> Self {
        Self {
            working: Arc::new(Semaphore::new(MAX_AT_A_TIME)),
            waiting: Semaphore::new(MAX_WAITING),
            patience: PATIENCE,
        }
    }
}

impl Turns {
    /// Waits for a turn, on a thread that may block.
    ///
    /// # Errors
    /// 503 when too many wait, or for too long, or nobody waits for the answer any more.
    pub fn take(&self) -> Result<Turn, Refusal> {
        let refused = |detail| Refusal::new(ProblemCode::Overloaded, detail).retry_after_s(5);
        let turn = Arc::clone(&self.working).try_acquire_owned();
        let permit = match turn {
            Ok(permit) => permit,
            Err(_) => {
                let _place = self
                    .waiting
                    .try_acquire()
                    .map_err(|_| refused("too many requests for much work at a time"))?;
                let turn = timeout(self.patience, Arc::clone(&self.working).acquire_owned());
                Handle::current()
                    .block_on(turn)
                    .ok()
                    .and_then(Result::ok)
                    .ok_or_else(|| refused("other requests for much work took too long"))?
            }
        };
        let turn = Turn { _permit: permit };
        if is_given_up() {
            return Err(refused("the client is gone"));
        }
        Ok(turn)
    }

    /// A turn to pool the runs of this job, if they are many.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub fn to_pool(&self, job: &JobView) -> Result<Option<Turn>, Refusal> {
        let is_heavy = job.counts.total > MANY_RUNS;
        is_heavy.then(|| self.take()).transpose()
    }

    /// Reads a document, on a thread that may block; a heavy one when its turn comes.
    ///
    /// # Errors
    /// As [`parse`] and [`Self::take`].
    pub fn read(&self, body: &[u8]) -> Result<Document, Refusal> {
        let large = (body.len() > LARGE_BYTES).then(|| self.take());
        let large = large.transpose()?;
        let value = parse(body)?;
        let turn = match large {
            None if is_heavy(&value) => Some(self.take()?),
            turn => turn,
        };
        Ok(Document { value, _turn: turn })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[tokio::test]
    async fn heavy_documents_take_turns_and_light_ones_do_not_wait() {
        let turns = Arc::new(Turns {
            working: Arc::new(Semaphore::new(1)),
            waiting: Semaphore::new(1),
            patience: Duration::from_millis(50),
        });
        let large = [b"{}".to_vec(), vec![b' '; LARGE_BYTES]].concat();
        let long = json_of_many_runs();
        let first = turns.read(&large).ok().unwrap();
        assert!(turns.read(b"{}").is_ok());
        let wait = |body: Vec<u8>| {
            let turns = Arc::clone(&turns);
            tokio::task::spawn_blocking(move || turns.read(&body).map(drop))
        };
        // Both wait for the first, one in the place for that.
        let both = tokio::join!(wait(large.clone()), wait(long.clone()));
        assert!(both.0.unwrap().is_err() && both.1.unwrap().is_err());
        drop(first);
        for heavy in [large, long] {
            let (turn, waiting) = (turns.take().ok().unwrap(), wait(heavy));
            tokio::time::sleep(Duration::from_millis(5)).await;
            drop(turn);
            assert!(waiting.await.unwrap().is_ok());
        }
    }

    fn json_of_many_runs() -> Vec<u8> {
        br#"{"seeds": {"count": 50000}}"#.to_vec()
    }
}
