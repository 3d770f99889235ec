//! Answers that are sent as they are made, by a thread that may block: never more than some parts of
//! them are held, and whoever stops reading ends the work.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use axum::body::Body;
use bytes::Bytes;
use futures_util::stream::{self, StreamExt};
use tokio::runtime::Handle;
use tokio::sync::mpsc;

/// Bytes that are sent at once, and how many such parts may wait for the client.
const PART_BYTES: usize = 64 << 10;
const PARTS: usize = 4;
/// Longest time for an answer, and that a client may take for a part.
const LONGEST: Duration = Duration::from_secs(15 * 60);
const PART_TIME: Duration = Duration::from_secs(60);

/// A body that this makes. Where it fails the client sees that what it has is not all.
pub fn streamed(make: impl FnOnce(&mut Parts) -> io::Result<()> + Send + 'static) -> Body {
    let (sender, receiver) = mpsc::channel(PARTS);
    let handle = Handle::current();
    tokio::task::spawn_blocking(move || {
        let mut out = Parts::new(sender, handle);
        if let Err(error) = make(&mut out).and_then(|()| out.flush()) {
            tracing::debug!(%error, "an answer is not sent to its end");
            out.break_off(error);
        }
    });
    let parts = stream::unfold(receiver, async |mut receiver| {
        let part: Result<Bytes, io::Error> = receiver.recv().await?;
        Some((part, receiver))
    });
    // The layer that compresses asks once more after the end.
    Body::from_stream(parts.fuse())
}

/// Writes to a client, from a thread that may block.
pub struct Parts {
    sender: mpsc::Sender<Result<Bytes, io::Error>>,
    handle: Handle,
    part: Vec<u8>,
    end: Instant,
}

impl Parts {
    fn new(sender: mpsc::Sender<Result<Bytes, io::Error>>, handle: Handle) -> Self {
        Self {
            sender,
            handle,
            part: Vec::with_capacity(PART_BYTES),
            end: Instant::now() + LONGEST,
        }
    }

    fn send(&self, part: Result<Bytes, io::Error>) -> io::Result<()> {
        let left = self.end.saturating_duration_since(Instant::now());
        let sent = self.sender.send_timeout(part, PART_TIME.min(left));
        self.handle
            .block_on(sent)
            .map_err(|error| io::Error::new(io::ErrorKind::BrokenPipe, error.to_string()))
    }

    /// Lets the client see that what it has is not all.
    fn break_off(self, error: io::Error) {
        drop(self.send(Err(error)));
    }
}

impl Write for Parts {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.part.extend_from_slice(bytes);
        if self.part.len() >= PART_BYTES {
            self.flush()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.part.is_empty() {
            return Ok(());
        }
        let part = std::mem::replace(&mut self.part, Vec::with_capacity(PART_BYTES));
        self.send(Ok(part.into()))
    }
}
