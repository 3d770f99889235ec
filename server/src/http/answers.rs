//! Large answers until their clients have taken them: bounded together, so that answers that nobody
//! reads cost no more than some. A new one takes the place of those that are taken too slowly.

use std::collections::BTreeMap;
use std::net::IpAddr;
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
/// Share of them that one address may have.
const ADDRESS_SHARE: u64 = 2;
/// Who takes nothing for so long makes room for others ...
const STILL_TIME: Duration = Duration::from_secs(10);
/// ... and so does who has not taken all after this.
const TIME: Duration = Duration::from_secs(60);

/// The large answers of a server that are under way.
#[derive(Clone, Default)]
pub struct Answers(Arc<Mutex<UnderWay>>);

#[derive(Default)]
struct UnderWay {
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
    /// Room for so many bytes; answers that are taken too slowly end for it. However large it is, an
    /// answer has room when no other is under way.
    fn room(&self, bytes: u64, connection: Option<Arc<Connection>>, now: Instant) -> Option<Room> {
        let address = address(&connection);
        let mut under_way = self.under_way();
        // An address leaves room for others.
        let its_own = |answer: &Answer| self::address(&answer.connection) == address;
        if !under_way.make_room(MAX_BYTES / ADDRESS_SHARE, its_own, bytes, now)
            || !under_way.make_room(MAX_BYTES, |_| true, bytes, now)
        {
            return None;
        }
        let number = under_way.next;
        under_way.next += 1;
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

fn address(connection: &Option<Arc<Connection>>) -> Option<IpAddr> {
    connection.as_ref().map(|connection| connection.address())
}

impl UnderWay {
    /// Whether so many bytes and those of answers that count are at most so many, or these alone,
    /// once slow answers have ended.
    fn make_room(
        &mut self,
        most: u64,
        counts: impl Fn(&Answer) -> bool,
        bytes: u64,
        now: Instant,
    ) -> bool {
        let counted = self.answers.iter().filter(|(_, answer)| counts(answer));
        let mut held: u64 = counted.clone().map(|(_, answer)| answer.bytes).sum();
        let slow = counted.filter(|(_, answer)| answer.is_slow(now));
        let slow: Vec<u64> = slow.map(|(number, _)| *number).collect();
        let has_room = |held: u64| held == 0 || held + bytes <= most;
        for number in slow {
            if has_room(held) {
                break;
            }
            if let Some(answer) = self.answers.remove(&number) {
                held -= answer.bytes;
                if let Some(connection) = answer.connection {
                    connection.close();
                }
            }
        }
        has_room(held)
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
        self.answers.under_way().answers.remove(&self.number);
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

    fn held(answers: &Answers) -> u64 {
        let under_way = answers.under_way();
        under_way.answers.values().map(|answer| answer.bytes).sum()
    }

    fn from(last: u8) -> Option<Arc<Connection>> {
        Some(Arc::new(Connection::new([10, 0, 0, last].into())))
    }

    #[test]
    fn answers_are_bounded_together_and_slow_ones_give_way() {
        let answers = Answers::default();
        let start = Instant::now();
        let third = MAX_BYTES / 3;
        let rooms = [1, 2, 3].map(|last| answers.room(third, from(last), start).unwrap());
        assert!(answers.room(third, from(4), start + TIME).is_none());
        // All are slow by then; the one that began first makes enough room.
        let late = start + TIME + Duration::from_secs(1);
        let fourth = answers.room(third, from(4), late).unwrap();
        assert_eq!(answers.under_way().answers.len(), 3);
        drop((rooms, fourth));
        assert_eq!(held(&answers), 0);
    }

    #[test]
    fn an_address_leaves_room_for_others() {
        let answers = Answers::default();
        let start = Instant::now();
        let half = MAX_BYTES / ADDRESS_SHARE;
        let first = answers.room(half, from(1), start).unwrap();
        assert!(answers.room(1, from(1), start).is_none());
        let second = answers.room(half, from(2), start).unwrap();
        drop((first, second));
        // Alone there is room for any.
        let large = answers.room(2 * MAX_BYTES, from(1), start).unwrap();
        assert!(answers.room(1, from(2), start).is_none());
        drop(large);
        assert!(answers.room(1, from(2), start).is_some());
    }
}
