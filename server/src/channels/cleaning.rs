//! Removes what processes that were killed left behind in shared memory: when a server starts, and
//! once an hour.

use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use super::port::{ChannelError, open_node};

/// Time between two cleanings.
const EVERY: Duration = Duration::from_secs(60 * 60);
/// Longest wait for another process that cleans.
const LIMIT: Duration = Duration::from_secs(5);

/// A thread that cleans up; dropping it ends the thread.
pub struct Cleaner {
    ends: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Cleaner {
    /// Cleans at once and then every hour, under a root. What cannot be cleaned is a warning.
    pub fn start(root: PathBuf) -> Self {
        Self::every(root, EVERY)
    }

    pub(super) fn every(root: PathBuf, interval: Duration) -> Self {
        let (ends, ended) = channel();
        let clean = move || {
            loop {
                match clean(&root) {
                    Ok(0) => {}
                    Ok(processes) => tracing::info!(
                        processes,
                        "removed what killed processes had left in shared memory"
                    ),
                    Err(error) => tracing::warn!(%error, "shared memory is not cleaned up"),
                }
                match ended.recv_timeout(interval) {
                    Err(RecvTimeoutError::Timeout) => {}
                    Ok(()) | Err(RecvTimeoutError::Disconnected) => return,
                }
            }
        };
        let thread = std::thread::Builder::new().name("cleaner".to_owned());
        let thread = thread.spawn(clean);
        if let Err(error) = &thread {
            tracing::warn!(%error, "shared memory is not cleaned up");
        }
        Self {
            ends: Some(ends),
            thread: thread.ok(),
        }
    }
}

impl Drop for Cleaner {
    fn drop(&mut self) {
        self.ends = None;
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::warn!("the thread that cleans shared memory panicked");
        }
    }
}

/// Removes what killed processes left under a root. Returns of how many.
fn clean(root: &std::path::Path) -> Result<u64, ChannelError> {
    let node = open_node(root)?;
    Ok(node.blocking_cleanup_dead_nodes(LIMIT).cleanups)
}
