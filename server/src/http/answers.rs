//! Large answers until their clients have taken them: bounded together, so that answers that nobody
//! reads cost no more than some. A new one takes the place of those that are taken too slowly.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use api::ProblemCode;
use axum::body::{Body, HttpBody, to_bytes};
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;

use super::connections::Connection;
use super::refusal::Refusal;

/// Smaller answers are not counted: there are no more of them than connections.
const LARGE_BYTES: u64 = 64 << 10;
/// Most bytes of large answers at a time.
const MAX_BYTES: u64 = 256 << 20;
/// Who takes nothing for so long makes room for others ...
const STILL_TIME: Duration = Duration::from_secs(5);
/// ... and so does who has not taken all after this.
const TIME: Duration = Duration::from_secs(60);

/// The large answers of a server that are under way.
#[derive(Clone, Default)]
pub struct Answers(Arc<Mutex<UnderWay>>);

#[derive(Default)]
struct UnderWay {
    bytes: u64,
    next: u64,
    /// In the order in which they began.
    answers: BTreeMap<u64, Answer>,
}

struct Answer {
    bytes: u64,
    begun: Instant,
    connection: Option<Arc<Connection>>,
}

/// The room of one answer, until it is dropped.
struct Room {
    answers: Answers,
    number: u64,
}

impl Answers {
    /// Room for so many bytes; answers that are taken too slowly end for it. Alone any answer has
    /// room.
    fn room(&self, bytes: u64, connection: Option<Arc<Connection>>, now: Instant) -> Option<Room> {
        let mut under_way = self.under_way();
        let most = MAX_BYTES.saturating_sub(bytes);
        if under_way.bytes > most {
            let slow = under_way.answers.iter().filter(|(_, one)| one.is_slow(now));
            let slow: Vec<u64> = slow.map(|(number, _)| *number).collect();
            for number in slow {
                if under_way.bytes <= most {
                    break;
                }
                let connection = under_way.remove(number).and_then(|one| one.connection);
                if let Some(connection) = connection {
                    connection.close();
                }
            }
        }
        if under_way.bytes > most && !under_way.answers.is_empty() {
            return None;
        }
        let number = under_way.next;
        under_way.next += 1;
        under_way.bytes += bytes;
        let answer = Answer {
            bytes,
            begun: now,
            connection,
        };
        under_way.answers.insert(number, answer);
        drop(under_way);
        Some(Room {
            answers: self.clone(),
            number,
        })
    }

    fn under_way(&self) -> MutexGuard<'_, UnderWay> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl UnderWay {
    fn remove(&mut self, number: u64) -> Option<Answer> {
        let answer = self.answers.remove(&number)?;
        self.bytes -= answer.bytes;
        Some(answer)
    }
}

impl Answer {
    fn is_slow(&self, now: Instant) -> bool {
        let connection = self.connection.as_ref();
        let is_still = connection.is_some_and(|connection| connection.still_for(now) > STILL_TIME);
        is_still || now.saturating_duration_since(self.begun) > TIME
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        self.answers.under_way().remove(self.number);
    }
}

/// The bytes of an answer, with their room until the last of them is sent.
struct Sent {
    bytes: Bytes,
    _room: Room,
}

impl AsRef<[u8]> for Sent {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Sends an answer that is there as a whole if there is room for it.
pub async fn bounded(State(answers): State<Answers>, request: Request, next: Next) -> Response {
    let connection = request.extensions().get::<Arc<Connection>>().cloned();
    let response = next.run(request).await;
    let length = response.body().size_hint().exact();
    let Some(length) = length.filter(|length| *length > LARGE_BYTES) else {
        return response;
    };
    let Some(room) = answers.room(length, connection, Instant::now()) else {
        let detail = "too many large answers are being sent";
        let refusal = Refusal::new(ProblemCode::Overloaded, detail);
        return refusal.retry_after_s(5).into_response();
    };
    let (parts, body) = response.into_parts();
    match to_bytes(body, usize::MAX).await {
        Ok(bytes) => {
            let sent = Bytes::from_owner(Sent { bytes, _room: room });
            Response::from_parts(parts, Body::from(sent))
        }
        Err(error) => Refusal::internal(&error).into_response(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn answers_are_bounded_together_and_slow_ones_give_way() {
        let answers = Answers::default();
        let start = Instant::now();
        let (third, half) = (MAX_BYTES / 3, MAX_BYTES / 2);
        let first = answers.room(third, None, start).unwrap();
        let _second = answers.room(half, None, start + STILL_TIME).unwrap();
        assert!(answers.room(half, None, start + TIME).is_none());
        drop(first);
        let first = answers.room(half, None, start + STILL_TIME).unwrap();
        assert_eq!(answers.under_way().bytes, 2 * half);
        // Both are slow by then; the one that began first makes enough room.
        let late = start + STILL_TIME + TIME + Duration::from_secs(1);
        let third = answers.room(third, None, late).unwrap();
        assert_eq!(answers.under_way().answers.len(), 2);
        drop((first, third));
        assert_eq!(answers.under_way().bytes, 0);
        // Alone there is room for any.
        let large = answers.room(2 * MAX_BYTES, None, start).unwrap();
        assert!(answers.room(1, None, start).is_none());
        drop(large);
        assert!(answers.room(1, None, start).is_some());
    }
}
