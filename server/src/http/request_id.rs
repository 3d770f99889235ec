//! Ids of requests: taken from `x-request-id` or made, told in the answer, in problems and in the log.

use std::sync::atomic::{AtomicU64, Ordering};

use axum::http::{HeaderMap, HeaderName, HeaderValue};

/// The header that brings and tells an id.
pub const HEADER: HeaderName = HeaderName::from_static("x-request-id");
/// Longest id that is taken over.
const MAX_BYTES: usize = 64;

tokio::task_local! {
    static CURRENT: String;
}

/// The id of the request that is answered; none outside of one.
pub fn current() -> Option<String> {
    CURRENT.try_with(Clone::clone).ok()
}

/// Answers a request of this id.
pub async fn scope<F: Future>(id: String, answer: F) -> F::Output {
    CURRENT.scope(id, answer).await
}

/// The id of a request: its own, where it has one that can stand in a log.
pub fn of(headers: &HeaderMap) -> String {
    let given = headers.get(HEADER).and_then(|id| id.to_str().ok());
    let is_plain = |id: &&str| {
        let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.:".contains(&byte);
        (1..=MAX_BYTES).contains(&id.len()) && id.bytes().all(plain)
    };
    given.filter(is_plain).map_or_else(made, str::to_owned)
}

/// The header that tells an id.
pub fn header(id: &str) -> HeaderValue {
    // Ids are of characters that a header can hold.
    HeaderValue::from_str(id).unwrap_or(HeaderValue::from_static(""))
}

/// A number of this process and one of the request: no other request of this machine has both.
fn made() -> String {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    static PROCESS: std::sync::OnceLock<u64> = std::sync::OnceLock::new();
    let process = PROCESS.get_or_init(|| {
        let mut bytes = [0; 8];
        match rustix::rand::getrandom(&mut bytes, rustix::rand::GetRandomFlags::empty()) {
            Ok(8) => u64::from_le_bytes(bytes),
            _ => u64::from(std::process::id()),
        }
    });
    format!("{process:016x}-{}", NEXT.fetch_add(1, Ordering::Relaxed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_that_fit_are_taken_over() {
        let of_one = |id: &'static str| {
            of(&[(HEADER, HeaderValue::from_static(id))]
                .into_iter()
                .collect())
        };
        assert_eq!(of_one("a-1_b.c:D"), "a-1_b.c:D");
        for other in ["", "with space", "a\"b", "a\tb"] {
            assert_ne!(of_one(other), other);
        }
        let (one, two) = (of(&HeaderMap::new()), of(&HeaderMap::new()));
        assert!(one != two && one.len() > 16);
    }
}
