//! The body of a request: read whole before there is a place for the request, within limits of
//! bytes and time, so that half a body holds nobody else up.

use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use api::ProblemCode;
use axum::body::{Body, HttpBody};
use axum::extract::Request;
use axum::http::header::CONTENT_LENGTH;
use bytes::{Bytes, BytesMut};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, timeout, timeout_at};

use super::checkpoints;
use super::connections::{Connection, Stage};
use super::refusal::Refusal;

/// Largest body that is read.
pub const MAX_BODY_BYTES: usize = 4 << 20;
/// Largest checkpoint that is read.
pub const MAX_CHECKPOINT_BYTES: usize = 64 << 20;
/// Bytes of all bodies together that are read or worked on.
const MAX_BYTES_AT_A_TIME: usize = 256 << 20;
/// Longest time for a body ...
const TIME: Duration = Duration::from_secs(60);
/// ... and between two parts of it.
const PAUSE: Duration = Duration::from_secs(10);
/// What is still read, and for how long, of a body that was refused, so that the client, which may
/// send all of it first, gets to read the answer.
const DRAINED_BYTES: usize = 64 << 20;
const DRAIN_TIME: Duration = Duration::from_secs(2);

/// The room for bodies.
#[derive(Clone)]
pub struct Bodies(Arc<Semaphore>);

/// The room that the body of one request takes, as long as the request is worked on.
#[derive(Default)]
pub struct Room(Option<OwnedSemaphorePermit>);

impl Default for Bodies {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(MAX_BYTES_AT_A_TIME)))
    }
}

impl Bodies {
    /// The request with all of its body.
    ///
    /// # Errors
    /// 413 when it is too large or said to be, 408 when it is too slow, 503 when there is no room,
    /// 400 when it breaks off.
    pub async fn read(&self, request: Request) -> Result<(Request, Room), Refusal> {
        let (parts, body) = request.into_parts();
        if body.is_end_stream() {
            return Ok((Request::from_parts(parts, body), Room::default()));
        }
        let most = if checkpoints::is_upload(&parts.method, parts.uri.path()) {
            MAX_CHECKPOINT_BYTES
        } else {
            MAX_BODY_BYTES
        };
        let length = parts.headers.get(CONTENT_LENGTH);
        let length = length.and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
        if length.is_some_and(|length| length > most as u64) {
            tokio::spawn(drain(body));
            return Err(too_large(most));
        }
        let connection = parts.extensions.get::<Arc<Connection>>().cloned();
        let enter = |stage| {
            if let Some(connection) = &connection {
                connection.enter(stage);
            }
        };
        enter(Stage::Body);
        let (bytes, room) = self.collect(body, most).await?;
        enter(Stage::Working);
        Ok((Request::from_parts(parts, Body::from(bytes)), room))
    }

    async fn collect(&self, mut body: Body, most: usize) -> Result<(Bytes, Room), Refusal> {
        let end = Instant::now() + TIME;
        let (mut bytes, mut room) = (BytesMut::new(), Room::default());
        loop {
            let part = timeout(PAUSE, timeout_at(end, next(&mut body))).await;
            let Ok(Ok(part)) = part else {
                let detail = "the body took too long";
                return Err(Refusal::new(ProblemCode::BodyTooSlow, detail));
            };
            let part = match part {
                None => return Ok((bytes.freeze(), room)),
                Some(Ok(part)) => part,
                Some(Err(())) => {
                    let detail = "the body broke off";
                    return Err(Refusal::new(ProblemCode::InvalidRequest, detail));
                }
            };
            if bytes.len() + part.len() > most {
                tokio::spawn(drain(body));
                return Err(too_large(most));
            }
            room.grow(&self.0, part.len())?;
            bytes.extend_from_slice(&part);
        }
    }
}

impl Room {
    fn grow(&mut self, all: &Arc<Semaphore>, bytes: usize) -> Result<(), Refusal> {
        // A part is no larger than a body.
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
        let more = Arc::clone(all).try_acquire_many_owned(bytes).map_err(|_| {
            let detail = "too many bodies at a time";
            Refusal::new(ProblemCode::Overloaded, detail).retry_after_s(1)
        })?;
        match &mut self.0 {
            Some(room) => room.merge(more),
            None => self.0 = Some(more),
        }
        Ok(())
    }
}

fn too_large(most: usize) -> Refusal {
    let detail = format!("a body has at most {most} bytes here");
    Refusal::new(ProblemCode::BodyTooLarge, detail)
}

/// The next part of a body with bytes; `None` at its end.
async fn next(body: &mut Body) -> Option<Result<Bytes, ()>> {
    loop {
        let frame =
            std::future::poll_fn(|context| Pin::new(&mut *body).poll_frame(context)).await?;
        match frame.map(|frame| frame.into_data()) {
            Ok(Ok(bytes)) => return Some(Ok(bytes)),
            // Trailers.
            Ok(Err(_)) => {}
            Err(_) => return Some(Err(())),
        }
    }
}

/// Reads on, to throw it away.
async fn drain(mut body: Body) {
    let read = async {
        let mut bytes = 0;
        while let Some(Ok(part)) = next(&mut body).await {
            bytes += part.len();
            if bytes > DRAINED_BYTES {
                return;
            }
        }
    };
    // Whatever is left then, the connection ends.
    drop(timeout(DRAIN_TIME, read).await);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    async fn read(bodies: &Bodies, body: Body) -> Result<(Request, Room), u16> {
        let request = Request::builder().body(body).unwrap();
        let read = bodies.read(request).await;
        read.map_err(|refusal| {
            axum::response::IntoResponse::into_response(refusal)
                .status()
                .as_u16()
        })
    }

    #[tokio::test]
    async fn bodies_are_counted_together() {
        let bodies = Bodies(Arc::new(Semaphore::new(10)));
        let (_, first) = read(&bodies, Body::from("sevens.")).await.unwrap();
        assert_eq!(read(&bodies, Body::from("four")).await.err(), Some(503));
        drop(first);
        let (request, _room) = read(&bodies, Body::from("four")).await.unwrap();
        let again = axum::body::to_bytes(request.into_body(), 10).await.unwrap();
        assert_eq!(&again[..], b"four");
    }
}
